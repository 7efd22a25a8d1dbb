// Light from the lamps on every surface, and what the surface makes of it (thesis section 6.5.4):
// the radiance that leaves it, emission and light of earlier bounces included. One workgroup a
// surface, one thread a point of it.

#import bevy_voxel_gi::albedo::surface_albedo
#import bevy_voxel_gi::atlas::{pack_light, storable, unpack_light}
#import bevy_voxel_gi::entry::{load_entry, work_item}
#import bevy_voxel_gi::faces::{face_key, keys}
#import bevy_voxel_gi::material::Material
#import bevy_voxel_gi::rays::PI
#import bevy_voxel_gi::surface::{point_count, surface_point}
#import bevy_voxel_gi::trace::{is_enclosed, trace}
#import bevy_voxel_gi::volume::{FACES, FLAG_FEEDBACK, key_material, level_corner, level_of_index,
    level_voxel_size, volume, voxel_of_index}
#import bevy_voxel_gi::walk::NOTHING

// In step with `lights.rs`, where the fields are explained.
struct Light {
    position: vec3<f32>,
    kind: u32,
    color: vec3<f32>,
    inverse_range_squared: f32,
    direction: vec3<f32>,
    spot_scale: f32,
    spot_offset: f32,
    pad: vec3<f32>,
}

const DIRECTIONAL: u32 = 0u;
const SPOT: u32 = 2u;

@group(1) @binding(2) var<storage, read_write> radiance: array<vec2<u32>>;
@group(1) @binding(3) var<storage, read> materials: array<Material>;
@group(1) @binding(4) var<storage, read> lights: array<Light>;
@group(1) @binding(5) var<storage, read> irradiance: array<vec4<u32>>;

// Irradiance at each point by one lamp, and whether it counts.
var<workgroup> irradiances: array<vec4<f32>, 16>;

struct Arriving {
    // Irradiance of what faces the lamp.
    irradiance: vec3<f32>,
    direction: vec3<f32>,
    // In metres.
    distance: f32,
}

// Nearer than this, in voxels, a lamp shines as from there.
const NEAREST: f32 = 0.125;

fn arriving(light: Light, position: vec3<f32>, voxel_size: f32) -> Arriving {
    if (light.kind == DIRECTIONAL) {
        return Arriving(light.color, -light.direction, 3e38);
    }
    let to = light.position - position;
    let distance = length(to);
    let direction = to / max(distance, 1e-9);
    let squared = pow(max(distance, NEAREST * voxel_size), 2.0);
    // As Bevy fades lamps out.
    let factor = squared * light.inverse_range_squared;
    let window = pow(saturate(1.0 - factor * factor), 2.0);
    var cone = 1.0;
    if (light.kind == SPOT) {
        let cosine = -dot(direction, light.direction);
        cone = pow(saturate(cosine * light.spot_scale + light.spot_offset), 2.0);
    }
    return Arriving(light.color * (window * cone / squared), direction, distance);
}

@compute @workgroup_size(16)
fn inject(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let entry = load_entry(work_item(group, groups), thread);
    let index = entry.index;
    let face = entry.face;
    let normal = entry.normal;
    let exposed = entry.exposed;
    let plane = entry.plane;
    let level = level_of_index(index);
    let corner = vec3<f32>(voxel_of_index(index));
    let size = level_voxel_size(level);
    let used = min(point_count(exposed), volume.shadow_samples);
    // Threads without a point do the first one again, as all must come to the barriers.
    let used_points = max(used, 1u);
    let number = (2u * (thread % used_points) + 1u) * point_count(exposed) / (2u * used_points);
    let point = corner + surface_point(exposed, plane, normal, number);
    let position = level_corner(level) + size * point;
    let origin = point + normal * plane.guard;
    var direct = vec3(0.0);
    for (var i = 0u; i < volume.light_count; i++) {
        let arrived = arriving(lights[i], position, size);
        let cosine = dot(normal, arrived.direction);
        var counted = vec4(0.0, 0.0, 0.0, 1.0);
        if (thread < used && cosine > 0.0 && any(arrived.irradiance > vec3(0.0))) {
            let met = trace(level, origin, arrived.direction,
                arrived.distance / size - plane.guard);
            if (met.index == NOTHING) {
                counted = vec4(arrived.irradiance * cosine, 1.0);
            } else if (is_enclosed(met)) {
                // The point may be inside something.
                counted = vec4(0.0);
            }
        }
        irradiances[thread] = counted;
        workgroupBarrier();
        if (thread == 0u) {
            var sum = vec4(0.0);
            for (var k = 0u; k < used; k++) {
                sum += irradiances[k];
            }
            direct += sum.rgb / max(sum.a, 1.0);
        }
        workgroupBarrier();
    }
    if (thread > 0u) {
        return;
    }
    let material = materials[key_material(keys[FACES * index + face])];
    let albedo = surface_albedo(index, face, material.albedo);
    let exposure = mix(1.0 / volume.exposure, 1.0, material.emissive_exposure_weight);
    var leaving = volume.storage_scale
        * (material.emissive * exposure + albedo * direct / PI);
    if ((volume.flags & FLAG_FEEDBACK) != 0u) {
        // Irradiance over pi.
        leaving += albedo * unpack_light(irradiance[FACES * index + face].xy).rgb;
    }
    let stored = storable(leaving);
    let packed = pack_light(vec4(stored, 0.0));
    let key = face_key(index, face);
    for (var f = face; f < FACES; f++) {
        if (face_key(index, f) == key) {
            radiance[FACES * index + f] = packed;
        }
    }
}
