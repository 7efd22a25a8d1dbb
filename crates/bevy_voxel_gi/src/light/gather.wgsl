// What reaches every surface from all around, by rays (thesis section 6.6.1), and what would reach
// one in the middle of each voxel without. One workgroup a surface or voxel.

#import bevy_voxel_gi::atlas::{atlas_texel, storable}
#import bevy_voxel_gi::rays::{PI, cosine_ray, hash_unit, sphere_ray}
#import bevy_voxel_gi::surface::{exposed_in_column, face_key, main_face, point_count,
    surface_normal, surface_plane, surface_point}
#import bevy_voxel_gi::trace::{NOTHING, keys, trace, volume}
#import bevy_voxel_gi::volume::{FACES, FLAG_WEIGHTED, cascade_voxel_size, face_normal, key_normal,
    sky_radiance, voxel_count, voxel_of_index}

@group(1) @binding(0) var<storage, read> work: array<u32>;
@group(1) @binding(1) var<storage, read> counters: array<u32>;
@group(1) @binding(2) var<storage, read> radiance: array<vec2<u32>>;
@group(1) @binding(3) var light_texture: texture_storage_3d<rgba16float, write>;

const THREADS: u32 = 32u;
// Points of a surface from which rays begin.
const MOST_ORIGINS: u32 = 16u;
// Rays of a voxel without surfaces.
const SPHERE_RAYS: u32 = 32u;
// Weight of a voxel without surfaces, against 1.
const AIR_WEIGHT: f32 = 0.015625;

var<workgroup> exposed_words: array<atomic<u32>, 2>;
// Per thread: the sum of what its rays bring, and how many count.
var<workgroup> sums: array<vec4<f32>, 32>;
var<workgroup> directions: array<vec3<f32>, 32>;

// Radiance along a ray; alpha is 0 where it meets the back of a surface, which tells nothing.
fn arriving(cascade: u32, origin: vec3<f32>, direction: vec3<f32>) -> vec4<f32> {
    let reach = volume.max_distance / cascade_voxel_size(volume, cascade);
    let hit = trace(cascade, origin, direction, reach);
    if (hit == NOTHING) {
        return vec4(sky_radiance(volume, direction), 1.0);
    }
#ifdef OCCLUSION_ONLY
    return vec4(0.0, 0.0, 0.0, 1.0);
#else
    var sum = vec3(0.0);
    var total = 0.0;
    for (var axis = 0u; axis < 3u; axis++) {
        let face = 2u * axis + select(1u, 0u, direction[axis] < 0.0);
        let key = keys[FACES * hit + face];
        if (key != 0u && dot(direction, key_normal(key)) < 0.0) {
            let packed = radiance[FACES * hit + face];
            let light = vec3(unpack2x16float(packed.x), unpack2x16float(packed.y).x);
            let weight = direction[axis] * direction[axis];
            sum += weight * light;
            total += weight;
        }
    }
    return select(vec4(0.0), vec4(sum / total, 1.0), total > 0.0);
#endif
}

// What the texture holds of an irradiance: divided by pi, and by weight where the receiver divides
// by it.
fn texel(irradiance: vec3<f32>, weight: f32) -> vec4<f32> {
    let light = storable(irradiance / PI);
    if ((volume.flags & FLAG_WEIGHTED) != 0u) {
        return vec4(light * weight, weight);
    }
    return vec4(light, 1.0);
}

fn is_due(index: u32) -> bool {
    return voxel_of_index(volume, index).z % volume.interval == volume.phase;
}

@compute @workgroup_size(32)
fn gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let place = group.x + group.y * groups.x;
    let entry = work[min(place, counters[0] - 1u)];
    let index = entry >> 3u;
    let face = entry & 7u;
    let key = face_key(index, face);
    let normal = surface_normal(index, face);
    if (thread < 16u) {
        let bit = exposed_in_column(index, main_face(normal), thread);
        if (bit < 64u) {
            atomicOr(&exposed_words[bit >> 5u], 1u << (bit & 31u));
        }
    }
    workgroupBarrier();
    let exposed = vec2(atomicLoad(&exposed_words[0]), atomicLoad(&exposed_words[1]));
    let plane = surface_plane(exposed, normal);
    let cascade = index / voxel_count(volume);
    let corner = vec3<f32>(voxel_of_index(volume, index)) + normal * plane.guard;
    let used = min(point_count(exposed), MOST_ORIGINS);
    var faces = 0u;
    for (var f = 0u; f < FACES; f++) {
        faces |= select(0u, 1u << f, face_key(index, f) == key);
    }
    let turn = hash_unit(64u * index + faces);
    var sum = vec4(0.0);
    if (is_due(index)) {
        for (var i = thread; i < volume.rays; i += THREADS) {
            let direction = cosine_ray(i, volume.rays, turn, normal);
            let origin = corner + surface_point(exposed, plane, normal, i % used, used);
            sum += arriving(cascade, origin, direction);
        }
    }
    sums[thread] = sum;
    workgroupBarrier();
    if (thread > 0u || !is_due(index)) {
        return;
    }
    var total = vec4(0.0);
    for (var i = 0u; i < THREADS; i++) {
        total += sums[i];
    }
    let weight = total.a / f32(volume.rays);
    let stored = texel(total.rgb * PI / max(total.a, 1.0), weight);
    for (var f = face; f < FACES; f++) {
        if (face_key(index, f) == key) {
            textureStore(light_texture, atlas_texel(volume, index, f), stored);
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
    let count = volume.cascades * voxel_count(volume);
    let index = work[FACES * count + min(place, counters[1] - 1u)] >> 3u;
    let cascade = index / voxel_count(volume);
    let origin = vec3<f32>(voxel_of_index(volume, index)) + 0.5;
    let direction = sphere_ray(thread, SPHERE_RAYS, hash_unit(64u * index));
    directions[thread] = direction;
    sums[thread] = arriving(cascade, origin, direction);
    workgroupBarrier();
    if (thread >= FACES || !is_due(index)) {
        return;
    }
    let normal = face_normal(thread);
    var irradiance = vec3(0.0);
    var valid = 0.0;
    for (var i = 0u; i < SPHERE_RAYS; i++) {
        irradiance += sums[i].rgb * max(dot(directions[i], normal), 0.0);
        valid += sums[i].a;
    }
    // Inside a solid most rays meet backs.
    let weight = select(0.0, AIR_WEIGHT, 4.0 * valid > 3.0 * f32(SPHERE_RAYS));
    let stored = texel(irradiance * 4.0 * PI / f32(SPHERE_RAYS), weight);
    textureStore(light_texture, atlas_texel(volume, index, thread), stored);
}
