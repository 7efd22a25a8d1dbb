// How a pixel reads the volume: the ambient cube of Bevy's irradiance volumes (J. Mitchell et al.,
// "Shading in Valve's Source Engine", 2006, slide 28), where each texel says in alpha how well it
// knows the surface, and colours are multiplied by that: the mean over the voxels around a pixel is
// a mean over those that know. The smallest cascade that holds the pixel is read, and blended into
// the next at its border.

#define_import_path bevy_voxel_gi::receive

// No irradiance volume has such a depth: theirs are multiples of three.
fn is_voxel_gi(light: texture_3d<f32>) -> bool {
    return textureDimensions(light).z % 3u == 1u;
}

// Width in voxels of the blend between cascades.
const BLEND: f32 = 2.0;

fn cascade_light(light: texture_3d<f32>, linear: sampler, cascade: i32, position: vec3<f32>,
    normal: vec3<f32>) -> vec4<f32> {
    let size = vec3<f32>(textureDimensions(light));
    let resolution = size.x;
    let place = clamp((position + 0.5) * resolution, vec3(0.5), vec3(resolution - 0.5));
    var sum = vec4(0.0);
    for (var axis = 0; axis < 3; axis++) {
        let negative = select(0.0, resolution, normal[axis] < 0.0);
        let corner = vec3(0.0, negative, f32(3 * cascade + axis) * resolution);
        let texel = textureSampleLevel(light, linear, (place + corner) / size, 0.0);
        sum += texel * (normal[axis] * normal[axis]);
    }
    return sum;
}

// Irradiance over pi at a place of the volume, -0.5 to 0.5 across its largest cascade.
fn voxel_gi_light(light: texture_3d<f32>, linear: sampler, place: vec3<f32>, normal: vec3<f32>)
    -> vec3<f32> {
    let size = textureDimensions(light);
    let cascades = i32((size.z - 1u) / (3u * size.x));
    let resolution = f32(size.x);
    var cascade = cascades - 1;
    var position = place;
    // Inwards as long as the next cascade holds it.
    loop {
        let inner = 2.0 * position;
        let largest = max(abs(inner.x), max(abs(inner.y), abs(inner.z)));
        if (cascade == 0 || largest > 0.5) {
            break;
        }
        cascade -= 1;
        position = inner;
    }
    var sum = cascade_light(light, linear, cascade, position, normal);
    if (cascade + 1 < cascades) {
        let largest = max(abs(position.x), max(abs(position.y), abs(position.z)));
        let share = saturate((0.5 - largest) * resolution / BLEND);
        if (share < 1.0) {
            let outer = cascade_light(light, linear, cascade + 1, 0.5 * position, normal);
            sum = mix(outer, sum, share);
        }
    }
    return select(vec3(0.0), sum.rgb / sum.a, sum.a > 1e-5);
}
