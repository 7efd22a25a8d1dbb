// A ray through the voxels: from voxel to voxel, and through the sub-voxels of those with any. It
// visits every sub-voxel it passes (J. Amanatides and A. Woo, "A Fast Voxel Traversal Algorithm
// for Ray Tracing", 1987), so that nothing is missed, unlike by the thesis's steps of equal length
// (section 6.6.1). Where it leaves a level it goes on in the next larger one that is there.

#define_import_path bevy_voxel_gi::walk

#import bevy_voxel_gi::faces::{is_set, masks}
#import bevy_voxel_gi::volume::{FINE, fine_bit, level_corner, level_voxel_size, volume, voxel_index}

const NOTHING: u32 = 0xffffffffu;

// A touched sub-voxel on a ray's way. Distances are in voxels of the level where the ray began.
struct Touched {
    // Index of its voxel, `NOTHING` if there is none.
    index: u32,
    // The last level that the ray was in: where it touches nothing it sees the sky around that.
    level: u32,
    voxel: vec3<u32>,
    mask: vec2<u32>,
    cell: vec3<u32>,
    // Where the ray comes into the sub-voxel, and where it leaves that; also from its middle.
    distance: f32,
    leaves: f32,
    enters_from_middle: vec3<f32>,
    leaves_from_middle: vec3<f32>,
}

fn smallest(v: vec3<f32>) -> u32 {
    return select(select(2u, 1u, v.y < v.z), select(2u, 0u, v.x < v.z), v.x < v.y);
}

fn is_inside(voxel: vec3<i32>) -> bool {
    return all(voxel >= vec3(0)) && all(voxel < vec3(i32(volume.resolution)));
}

// The first touched sub-voxel from a distance on and before `reach`. `origin` is in voxels of `level`
// from its corner, `begin` and `reach` in its voxels, `direction` a unit vector.
fn walk(level: u32, origin: vec3<f32>, direction: vec3<f32>, begin: f32, reach: f32) -> Touched {
    // A component of 0 never reaches a border; a tiny one does so out of sight, and is finite.
    let ray = select(direction, vec3(1e-12), abs(direction) < vec3(1e-12));
    let inverse = 1.0 / ray;
    let ahead = select(vec3(0.0), vec3(1.0), ray > vec3(0.0));
    let step = select(vec3(-1), vec3(1), ray > vec3(0.0));
    var from_ = origin;
    var distance = begin;
    var limit = reach;
    var found: Touched;
    found.index = NOTHING;
    for (var c = level; c < volume.level_count; c++) {
        var voxel = vec3<i32>(floor(from_ + ray * distance));
        found.level = select(found.level, c, c == level || is_inside(voxel));
        loop {
            if (!is_inside(voxel)) {
                break;
            }
            let index = voxel_index(c, vec3<u32>(voxel));
            let mask = masks[index];
            if (any(mask != vec2(0u))) {
                let base = vec3<f32>(voxel);
                var at = distance;
                let entry = (from_ + ray * at - base) * f32(FINE);
                var sub = clamp(vec3<i32>(floor(entry)), vec3(0), vec3(i32(FINE) - 1));
                loop {
                    if (at >= limit) {
                        return found;
                    }
                    let low = base + vec3<f32>(sub) / f32(FINE);
                    let next = (low + ahead / f32(FINE) - from_) * inverse;
                    let axis = smallest(next);
                    if (is_set(mask, fine_bit(vec3<u32>(sub)))) {
                        let scale = level_voxel_size(c) / level_voxel_size(level);
                        let from_middle = from_ - low - 0.5 / f32(FINE);
                        return Touched(index, c, vec3<u32>(voxel), mask, vec3<u32>(sub),
                            at * scale, next[axis] * scale, from_middle + ray * at,
                            from_middle + ray * next[axis]);
                    }
                    at = next[axis];
                    sub[axis] += step[axis];
                    if (sub[axis] < 0 || sub[axis] >= i32(FINE)) {
                        break;
                    }
                }
            }
            let next = (vec3<f32>(voxel) + ahead - from_) * inverse;
            let axis = smallest(next);
            distance = next[axis];
            if (distance >= limit) {
                return found;
            }
            voxel[axis] += step[axis];
        }
        if (c + 1u < volume.level_count) {
            // In voxels of the next level, from its corner.
            let next_size = level_voxel_size(c + 1u);
            let scale = level_voxel_size(c) / next_size;
            from_ = from_ * scale + (level_corner(c) - level_corner(c + 1u)) / next_size;
            distance *= scale;
            limit *= scale;
        }
    }
    return found;
}
