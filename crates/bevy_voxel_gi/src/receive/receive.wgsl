// How a pixel reads the volume: the ambient cube of Bevy's irradiance volumes (J. Mitchell et al.,
// "Shading in Valve's Source Engine", 2006, slide 28), where each texel says in alpha how well it
// knows the surface, and colours are multiplied by that: the mean over the voxels around a pixel is
// a mean over those that know. The smallest level that holds the pixel is read, and blended into
// the next at its border.

#define_import_path bevy_voxel_gi::receive

#import bevy_pbr::mesh_view_bindings::view
#import bevy_voxel_gi::seen::seen_light

// No irradiance volume has such a depth: theirs are multiples of three.
fn is_voxel_gi(light: texture_3d<f32>) -> bool {
    return textureDimensions(light).z % 3u == 1u;
}

// Width in voxels of the blend between levels.
const BLEND: f32 = 2.0;

// A number from the last slice, in step with `list.wgsl`.
fn told(light: texture_3d<f32>, place: u32) -> f32 {
    let size = textureDimensions(light);
    let at = vec3(place % size.x, place / size.x, size.z - 1u);
    let bytes = vec4<u32>(textureLoad(light, vec3<i32>(at), 0));
    return bitcast<f32>(bytes.x | (bytes.y << 8u) | (bytes.z << 16u) | (bytes.w << 24u));
}

// Light times weight, and weight; `position` is in voxels from the corner of the level.
fn level_light(light: texture_3d<f32>, linear: sampler, level: u32, position: vec3<f32>,
    normal: vec3<f32>) -> vec4<f32> {
    let size = vec3<f32>(textureDimensions(light));
    let resolution = size.x;
    let place = clamp(position, vec3(0.5), vec3(resolution - 0.5));
    var sum = vec4(0.0);
    for (var axis = 0u; axis < 3u; axis++) {
        let negative = select(0.0, resolution, normal[axis] < 0.0);
        let corner = vec3(0.0, negative, f32(3u * level + axis) * resolution);
        let texel = textureSampleLevel(light, linear, (place + corner) / size, 0.0);
        sum += texel * (normal[axis] * normal[axis]);
    }
    return sum;
}

// From a place in the world to the camera.
fn to_viewer(world_position: vec3<f32>) -> vec3<f32> {
    if (view.clip_from_view[3].w == 1.0) {
        return normalize(view.world_from_view[2].xyz);
    }
    return normalize(view.world_position - world_position);
}

// Irradiance over pi at a place, -0.5 to 0.5 across the box around all levels.
fn voxel_gi_light(light: texture_3d<f32>, linear: sampler, place: vec3<f32>, normal: vec3<f32>,
    world_position: vec3<f32>) -> vec3<f32> {
    let size = textureDimensions(light);
    let resolution = f32(size.x);
    var sum = vec4(0.0);
    if (size.z == 3u * size.x + 1u) {
        // One level, and nothing to look for.
        sum = level_light(light, linear, 0u, (place + 0.5) * resolution, normal);
    } else {
        let levels = u32(told(light, 0u));
        let from_center = place * vec3(told(light, 1u), told(light, 2u), told(light, 3u));
        let looks = size.z > 4u * levels * size.x;
        var left = 1.0;
        for (var level = 0u; level < levels && left > 0.0; level++) {
            let start = 4u + 5u * level;
            let corner = vec3(told(light, start), told(light, start + 1u),
                told(light, start + 2u));
            let position = (from_center - corner) / told(light, start + 3u);
            let inside = min(position, resolution - position);
            let depth = min(inside.x, min(inside.y, inside.z));
            if (depth < 0.0) {
                continue;
            }
            // Never 0: there may be no other level.
            let share = clamp(depth / BLEND, 1e-3, 1.0);
            var found: vec4<f32>;
            if (looks) {
                found = seen_light(light, level, levels, position, normal,
                    to_viewer(world_position));
            } else {
                found = level_light(light, linear, level, position, normal);
            }
            sum += found * vec4(vec3(told(light, start + 4u)), 1.0) * (left * share);
            left = left * (1.0 - share);
        }
    }
    return select(vec3(0.0), sum.rgb / sum.a, sum.a > 1e-7);
}
