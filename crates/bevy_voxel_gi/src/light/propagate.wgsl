// Light handed on from voxel to voxel (thesis section 6.6.2), so that its energy never grows.
//
// Each voxel without surfaces holds the intensity of the light that has just arrived in it, as
// spherical harmonics. In a step all of it leaves, through the six faces, in proportion to the
// intensity towards the five faces of the neighbour behind each (A. Kaplanyan and C. Dachsbacher,
// "Cascaded Light Propagation Volumes", 2010), scaled so that as much arrives as has left: no
// hand-set factor is needed. A neighbour receives each part as light in the direction in which it
// came, not as a cosine lobe, which would scatter it at every step. What meets a voxel with
// surfaces is irradiance there, and comes back by the albedo of its face as a cosine lobe about its
// normal; at the border it is lost. In `reference/propagate.rs` step by step.

#import bevy_voxel_gi::albedo::surface_albedo
#import bevy_voxel_gi::atlas::{atlas_texel, storable, unpack_light}
#import bevy_voxel_gi::faces::{keys, masks}
#import bevy_voxel_gi::harmonics::{basis, cosine_lobe, flux}
#import bevy_voxel_gi::material::Material
#import bevy_voxel_gi::rays::PI
#import bevy_voxel_gi::volume::{FACES, FLAG_WEIGHTED, face_normal, key_material, key_normal,
    level_of_index, sky_radiance, volume, voxel_count, voxel_index, voxel_of_index}

// Intensity of three channels, and the scale of what leaves.
struct Light {
    red: vec4<f32>,
    green: vec4<f32>,
    blue: vec4<f32>,
    scale: vec3<f32>,
}

// Radiance of each face of each voxel.
@group(1) @binding(0) var<storage, read> radiance: array<vec2<u32>>;
@group(1) @binding(1) var<storage, read> materials: array<Material>;
@group(1) @binding(2) var<storage, read> before: array<Light>;
@group(1) @binding(3) var<storage, read_write> after: array<Light>;
// What has arrived through each face so far.
@group(1) @binding(4) var<storage, read_write> arrived: array<vec4<f32>>;
@group(1) @binding(5) var light_texture: texture_storage_3d<rgba16float, write>;

// Solid angle of the far face of the neighbouring voxel, seen from the middle of a voxel, and of each
// at its sides: together 2 pi / 3.
const FRONT_ANGLE: f32 = 0.4006697;
const SIDE_ANGLE: f32 = 0.42343136;
// What is kept of the flux in a step, so that rounding never adds to it: 1 - 2^-19.
const KEPT: f32 = 0.9999980926513672;
// Weight of a voxel without surfaces, against 1.
const AIR_WEIGHT: f32 = 0.015625;
const NONE: u32 = 0xffffffffu;

fn is_free(index: u32) -> bool {
    return all(masks[index] == vec2(0u));
}

// The voxel behind a face, or `NONE` outside of the volume.
fn neighbor(index: u32, face: u32) -> u32 {
    let voxel = vec3<i32>(voxel_of_index(index)) + vec3<i32>(face_normal(face));
    if (any(voxel < vec3(0)) || any(voxel >= vec3(i32(volume.resolution)))) {
        return NONE;
    }
    return voxel_index(level_of_index(index), vec3<u32>(voxel));
}

// Direction from the middle of a voxel to a face of the neighbour behind `face`.
fn travel(face: u32, side: u32) -> vec3<f32> {
    let front = face_normal(face);
    return select(normalize(front + 0.5 * face_normal(side)), front, side == face);
}

// What leaves towards a face of the neighbour behind `face`, before it is scaled.
fn part(light: Light, face: u32, side: u32) -> vec3<f32> {
    let b = basis(travel(face, side));
    let angle = select(SIDE_ANGLE, FRONT_ANGLE, side == face);
    return angle
        * max(vec3(dot(light.red, b), dot(light.green, b), dot(light.blue, b)), vec3(0.0));
}

fn add(light: ptr<function, Light>, shape: vec4<f32>, amount: vec3<f32>) {
    (*light).red += shape * amount.r;
    (*light).green += shape * amount.g;
    (*light).blue += shape * amount.b;
}

// The light with the scale of what leaves it.
fn scaled(light: Light) -> Light {
    var result = light;
    let total = max(vec3(flux(light.red), flux(light.green), flux(light.blue)), vec3(0.0));
    var sum = vec3(0.0);
    for (var face = 0u; face < FACES; face++) {
        for (var side = 0u; side < FACES; side++) {
            if (side != (face ^ 1u)) {
                sum += part(light, face, side);
            }
        }
    }
    result.scale = select(vec3(0.0), total * KEPT / sum, sum > vec3(1e-30));
    return result;
}

// All that leaves through a face.
fn leaving(light: Light, face: u32) -> vec3<f32> {
    var sum = vec3(0.0);
    for (var side = 0u; side < FACES; side++) {
        if (side != (face ^ 1u)) {
            sum += part(light, face, side);
        }
    }
    return sum * light.scale;
}

// Albedo of a voxel's face, and of what is not turned that way a mean.
fn face_albedo(index: u32, face: u32) -> vec3<f32> {
    let key = keys[FACES * index + face];
    if (key != 0u) {
        return surface_albedo(index, face, materials[key_material(key)].albedo);
    }
    var sum = vec3(0.0);
    var count = 0.0;
    for (var f = 0u; f < FACES; f++) {
        let other = keys[FACES * index + f];
        if (other != 0u) {
            sum += surface_albedo(index, f, materials[key_material(other)].albedo);
            count += 1.0;
        }
    }
    return sum / max(count, 1.0);
}

fn face_surface_normal(index: u32, face: u32) -> vec3<f32> {
    let key = keys[FACES * index + face];
    if (key != 0u) {
        return key_normal(key);
    }
    return face_normal(face);
}

fn index_of(id: vec3<u32>, groups: vec3<u32>) -> u32 {
    return id.x + id.y * groups.x * 64u;
}

// What surfaces give off, and the sky through the border.
@compute @workgroup_size(64)
fn seed(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = index_of(id, groups);
    if (index >= volume.level_count * voxel_count()) {
        return;
    }
    var light: Light;
    for (var face = 0u; face < FACES; face++) {
        var reached = vec3(0.0);
        let beside = neighbor(index, face);
        if (is_free(index)) {
            if (beside == NONE) {
                let direction = face_normal(face);
                reached = sky_radiance(level_of_index(index), direction) * PI;
                add(&light, cosine_lobe(-direction), reached);
            } else if (!is_free(beside)) {
                let key = keys[FACES * beside + (face ^ 1u)];
                if (key != 0u) {
                    let normal = key_normal(key);
                    let facing = max(dot(normal, -face_normal(face)), 0.0);
                    let given = unpack_light(radiance[FACES * beside + (face ^ 1u)]).rgb;
                    add(&light, cosine_lobe(normal), given * PI * facing);
                }
            }
        }
        arrived[FACES * index + face] = vec4(reached, 0.0);
    }
    after[index] = scaled(light);
}

@compute @workgroup_size(64)
fn propagate(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let index = index_of(id, groups);
    if (index >= volume.level_count * voxel_count()) {
        return;
    }
    let free = is_free(index);
    let own = before[index];
    var light: Light;
    for (var face = 0u; face < FACES; face++) {
        let beside = neighbor(index, face);
        if (beside == NONE) {
            continue;
        }
        if (is_free(beside)) {
            // Light of the neighbour travels the opposite way.
            let other = before[beside];
            let towards = face ^ 1u;
            var sum = vec3(0.0);
            for (var side = 0u; side < FACES; side++) {
                if (side != face) {
                    let amount = part(other, towards, side) * other.scale;
                    sum += amount;
                    if (free) {
                        add(&light, basis(travel(towards, side)), amount);
                    }
                }
            }
            arrived[FACES * index + face] += vec4(sum, 0.0);
        } else if (free) {
            let albedo = face_albedo(beside, face ^ 1u);
            let normal = face_surface_normal(beside, face ^ 1u);
            add(&light, cosine_lobe(normal), leaving(own, face) * albedo);
        }
    }
    after[index] = scaled(light);
}

// To the texture that pixels read.
@compute @workgroup_size(64)
fn deposit(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let index = index_of(id, groups);
    if (index >= volume.level_count * voxel_count()) {
        return;
    }
    for (var face = 0u; face < FACES; face++) {
        let beside = neighbor(index, face);
        var weight = AIR_WEIGHT;
        if (!is_free(index)) {
            let open = beside != NONE && is_free(beside);
            weight = select(0.0, 1.0, open && keys[FACES * index + face] != 0u);
        }
        let light = storable(arrived[FACES * index + face].rgb / PI);
        var texel = vec4(light * weight, weight);
        if ((volume.flags & FLAG_WEIGHTED) == 0u) {
            texel = vec4(light, 1.0);
        }
        textureStore(light_texture, atlas_texel(index, face), texel);
    }
}
