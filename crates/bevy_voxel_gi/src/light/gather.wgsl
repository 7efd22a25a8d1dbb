// What reaches every surface from all around, by rays (thesis section 6.6.1), and what would reach
// one in the middle of each voxel without. One workgroup a surface or voxel.

#import bevy_voxel_gi::atlas::{atlas_texel, pack_light, storable, unpack_light}
#import bevy_voxel_gi::entry::{counters, exposed_now, exposed_words, load_entry, work, work_item}
#import bevy_voxel_gi::faces::face_key
#import bevy_voxel_gi::rays::{cosine_ray, hash_unit, sphere_ray}
#import bevy_voxel_gi::surface::{cell_center, in_plane, is_clear, middle_point, point_count,
    surface_point}
#import bevy_voxel_gi::trace::{is_back, is_enclosed, trace}
#import bevy_voxel_gi::volume::{FACES, FLAG_CHANGING, FLAG_WEIGHTED, face_normal,
    face_towards, is_due, level_of_index, level_voxel_size, sky_radiance, volume, voxel_count,
    voxel_of_index}
#import bevy_voxel_gi::walk::NOTHING

@group(1) @binding(2) var<storage, read> radiance: array<vec2<u32>>;
@group(1) @binding(3) var light_texture: texture_storage_3d<rgba16float, write>;
@group(1) @binding(4) var<storage, read_write> irradiance: array<vec4<u32>>;

const THREADS: u32 = 32u;
// Rays of a voxel without surfaces.
const SPHERE_RAYS: u32 = 32u;
// Weight of a voxel without surfaces, against 1.
const AIR_WEIGHT: f32 = 0.001953125;
// Weight of a surface, against 1, and of air, against other air, where more than a quarter of the
// rays may have begun inside of something: in a solid, or close behind a surface with one side.
// Both are dark, but beside what is outside of the solid it must not show.
const BEHIND: f32 = 0.00390625;
const AIR_BEHIND: f32 = 0.25;

// Per thread: the sum of what its rays bring, with how many tell something; and how many may have
// begun inside of something.
var<workgroup> sums: array<vec4<f32>, 32>;
var<workgroup> enclosed: array<f32, 32>;
var<workgroup> directions: array<vec3<f32>, 32>;

struct Arriving {
    // Radiance; alpha is 0 where the ray tells nothing.
    light: vec4<f32>,
    // 1 where it may have begun inside of something.
    enclosed: f32,
}

fn arriving(level: u32, origin: vec3<f32>, direction: vec3<f32>) -> Arriving {
    let reach = volume.max_distance / level_voxel_size(level);
    let met = trace(level, origin, direction, reach);
    if (met.index == NOTHING) {
        return Arriving(vec4(sky_radiance(met.level, direction), 1.0), 0.0);
    }
#ifdef OCCLUSION_ONLY
    return Arriving(vec4(0.0, 0.0, 0.0, 1.0), 0.0);
#else
    var seen = vec4(0.0);
    for (var axis = 0u; axis < 3u; axis++) {
        if ((met.shown & (1u << axis)) != 0u) {
            let face = face_towards(axis, -direction[axis]);
            let light = unpack_light(radiance[FACES * met.index + face]).rgb;
            seen += vec4(light, 1.0) * (direction[axis] * direction[axis]);
        }
    }
    if (seen.a > 0.0) {
        return Arriving(seen / seen.a, 0.0);
    }
    if (!is_back(met) && met.grazed != NOTHING) {
        return Arriving(vec4(unpack_light(radiance[met.grazed]).rgb, 1.0), 0.0);
    }
    return Arriving(vec4(0.0, 0.0, 0.0, select(0.0, 1.0, is_back(met))),
        select(0.0, 1.0, is_enclosed(met)));
#endif
}

// Sets of rays that take turns, a round each: together they are one dense set. Without a mean over
// rounds there is one.
#ifdef OCCLUSION_ONLY
const SETS: u32 = 1u;
// Points of a surface from which rays begin in a round.
const FRAME_POINTS: u32 = 16u;
#else
const SETS: u32 = 8u;
const FRAME_POINTS: u32 = 4u;
#endif

// What the texture holds of light that is multiplied by its weight: that, where the receiver
// divides by the weight.
fn texel(light: vec4<f32>) -> vec4<f32> {
    if ((volume.flags & FLAG_WEIGHTED) != 0u) {
        return light;
    }
    return vec4(light.rgb / max(light.a, 1e-6), 1.0);
}

// From point to point, so that neighbours are not in the same round; coprime to 16.
const POINT_STEP: u32 = 5u;
// Rays turn when all sets had their turn.
const TURN_STEP: u32 = 0x9e3779b9u;
// Soon after a change light that differs by more than this is not noise, nor is a surface that is
// known so much less.
const ABRUPT: f32 = 0.75;
const ABRUPT_WEIGHT: f32 = 0.125;

// The share of this round in the mean.
fn share(before: vec4<f32>, now: vec4<f32>) -> f32 {
    if (before.a == 0.0) {
        return 1.0;
    }
    if ((volume.flags & FLAG_CHANGING) == 0u) {
        return volume.blend;
    }
    let old = dot(before.rgb, vec3(1.0)) * now.a;
    let fresh = dot(now.rgb, vec3(1.0)) * before.a;
    let abrupt = abs(fresh - old) > ABRUPT * max(fresh, old) || now.a < ABRUPT_WEIGHT * before.a;
    return max(volume.blend, select(0.0, 0.5, abrupt));
}

@compute @workgroup_size(32)
fn gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let item = work_item(group, groups);
    if (!is_due(item >> 3u)) {
        return;
    }
    let entry = load_entry(item, thread);
    let index = entry.index;
    let face = entry.face;
    let key = face_key(index, face);
    let normal = entry.normal;
    let bit = entry.bit;
    var exposed = entry.exposed;
    let plane = entry.plane;
    let level = level_of_index(index);
    let corner = vec3<f32>(voxel_of_index(index)) + normal * plane.guard;
#ifdef PER_PIXEL
    // Of a surface that a wall divides, one side: pixels look on which side they are.
    let middle = middle_point(exposed, plane, normal);
    workgroupBarrier();
    if (bit < 64u) {
        let point = in_plane(cell_center(bit), plane, normal);
        if (!is_clear(level, corner + middle, corner + point)) {
            atomicAnd(&exposed_words[bit >> 5u], ~(1u << (bit & 31u)));
        }
    }
    workgroupBarrier();
    exposed = exposed_now();
#endif
    let points = point_count(exposed);
    var faces = 0u;
    for (var f = 0u; f < FACES; f++) {
        faces |= select(0u, 1u << f, face_key(index, f) == key);
    }
    let ray_set = volume.round % SETS;
    let turn = hash_unit(64u * index + faces + volume.round / SETS * TURN_STEP);
    // All rays of a thread begin at one point.
    let place_of_point = (volume.round * FRAME_POINTS + thread % FRAME_POINTS) * POINT_STEP;
    let origin = corner + surface_point(exposed, plane, normal, place_of_point % points);
    var sum = vec4(0.0);
    var inside = 0.0;
    for (var i = thread; i < volume.rays; i += THREADS) {
        let direction = cosine_ray(i * SETS + ray_set, volume.rays * SETS, turn, normal);
        let found = arriving(level, origin, direction);
        sum += found.light;
        inside += found.enclosed;
    }
    sums[thread] = sum;
    enclosed[thread] = inside;
    workgroupBarrier();
    if (thread > 0u) {
        return;
    }
    var front = vec4(0.0);
    var behind = vec4(0.0);
    for (var k = 0u; k < FRAME_POINTS; k++) {
        var of_point = vec4(0.0);
        inside = 0.0;
        for (var i = k; i < THREADS; i += FRAME_POINTS) {
            of_point += sums[i];
            inside += enclosed[i];
        }
        let rays = f32((volume.rays - k + FRAME_POINTS - 1u) / FRAME_POINTS);
        if (4.0 * inside > rays) {
            behind += of_point;
        } else {
            front += of_point;
        }
    }
    // Irradiance over pi, and how well it is known. Where no ray tells anything nothing is learned.
    var now = vec4(0.0);
#ifndef OCCLUSION_ONLY
    let stored = irradiance[FACES * index + face];
    now = vec4(unpack_light(stored.xy).rgb, 0.0);
#endif
    if (front.a > 0.0) {
        now = vec4(storable(front.rgb / front.a), front.a / f32(volume.rays));
    } else if (behind.a > 0.0) {
        now = vec4(storable(behind.rgb / behind.a), BEHIND);
    }
    var mean = vec4(now.rgb * now.a, now.a);
#ifndef OCCLUSION_ONLY
    let before = unpack_light(stored.zw);
    mean = mix(before, mean, share(before, mean));
#endif
    for (var f = face; f < FACES; f++) {
        if (face_key(index, f) == key) {
#ifndef OCCLUSION_ONLY
            irradiance[FACES * index + f] = vec4<u32>(pack_light(now), pack_light(mean));
#endif
            textureStore(light_texture, atlas_texel(index, f), texel(mean));
        }
    }
}

@compute @workgroup_size(32)
fn gather_air(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let place = group.x + group.y * groups.x;
    let count = volume.level_count * voxel_count();
    let index = work[FACES * count + min(place, counters[1] - 1u)] >> 3u;
    let level = level_of_index(index);
    let origin = vec3<f32>(voxel_of_index(index)) + 0.5;
    let ray_set = volume.round % SETS;
    let turn = hash_unit(64u * index + volume.round / SETS * TURN_STEP);
    let direction = sphere_ray(thread * SETS + ray_set, SPHERE_RAYS * SETS, turn);
    directions[thread] = direction;
    let found = arriving(level, origin, direction);
    sums[thread] = found.light;
    enclosed[thread] = found.enclosed;
    workgroupBarrier();
    if (thread >= FACES) {
        return;
    }
    // The cosine as weight, so that a uniform field is uniform however few rays there are.
    let normal = face_normal(thread);
    var sum = vec4(0.0);
    var inside = 0.0;
    for (var i = 0u; i < SPHERE_RAYS; i++) {
        sum += sums[i] * max(dot(directions[i], normal), 0.0);
        inside += enclosed[i];
    }
    let weight = AIR_WEIGHT * select(1.0, AIR_BEHIND, 4.0 * inside > f32(SPHERE_RAYS));
    let light = storable(sum.rgb / max(sum.a, 1e-6));
    textureStore(light_texture, atlas_texel(index, thread),
        texel(vec4(light * weight, weight)));
}
