// A ray through the voxels: from voxel to voxel, and through the sub-voxels of those with any. It
// visits every sub-voxel it passes (J. Amanatides and A. Woo, "A Fast Voxel Traversal Algorithm
// for Ray Tracing", 1987), so that nothing is missed, unlike by the thesis's steps of equal length
// (section 6.6.1). In a touched one it ends if it comes behind the middle. Where it leaves a level it
// goes on in the next larger one that is there.

#define_import_path bevy_voxel_gi::trace

#import bevy_voxel_gi::faces::{is_outermost, is_turned, masks, surface_normal}
#import bevy_voxel_gi::volume::{FACES, FINE, face_towards, level_corner, level_voxel_size, volume,
    voxel_index}

const NOTHING: u32 = 0xffffffffu;

// The largest level that the last ray was in: where it met nothing it saw the sky around that.
var<private> outermost: u32;
// How far it went before what it met, in voxels of the level that it began in.
var<private> travelled: f32;
// If it came there through a sub-voxel in front of its surface: `FACES` times the index of the voxel,
// plus the face. `NOTHING` otherwise.
var<private> grazed: u32;

fn smallest(v: vec3<f32>) -> u32 {
    return select(select(2u, 1u, v.y < v.z), select(2u, 0u, v.x < v.z), v.x < v.y);
}

fn is_inside(voxel: vec3<i32>) -> bool {
    return all(voxel >= vec3(0)) && all(voxel < vec3(i32(volume.resolution)));
}

// Where it leaves the sub-voxel that it met: how far from its beginning, and from the sub-voxel's
// middle.
var<private> leaves: f32;
var<private> leaves_from_middle: vec3<f32>;

// In front of which surface of the touched sub-voxel that it met the last ray stays, as `grazed`. The
// surface is taken to go through the middle: where in the sub-voxel it really is nobody knows, but so
// it is at the right place in the mean, while all of the sub-voxel would be too near, and windows too
// narrow.
fn grazed_face(hit: u32, direction: vec3<f32>) -> u32 {
    for (var axis = 0u; axis < 3u; axis++) {
        let face = face_towards(axis, -direction[axis]);
        if (is_turned(hit, direction, axis)
            && dot(surface_normal(hit / 64u, face), leaves_from_middle) >= 0.0
            && is_outermost(hit, direction, axis)) {
            return FACES * (hit / 64u) + face;
        }
    }
    return NOTHING;
}

// Where a ray goes on behind a sub-voxel that it grazed, in voxels: surely in the next one.
const NUDGE: f32 = 0.0009765625;

// 64 times the index of the voxel in which a ray meets a surface, plus the bit of the sub-voxel; or
// `NOTHING` if that is outside of the volume or not before `reach`. `origin` is in voxels of `level`
// from its corner, `reach` in its voxels, `direction` a unit vector.
//
// The loop is around the walk and not in it, so that rays beside each other walk together.
fn trace(level: u32, origin: vec3<f32>, direction: vec3<f32>, reach: f32) -> u32 {
    var begin = 0.0;
    var hit = NOTHING;
    grazed = NOTHING;
    loop {
        hit = walk(level, origin, direction, begin, reach);
        if (hit == NOTHING) {
            break;
        }
        // There was a gap since the sub-voxel that it grazed.
        grazed = select(grazed, NOTHING, travelled > begin + NUDGE);
        let passed = grazed_face(hit, direction);
        if (passed == NOTHING) {
            break;
        }
        grazed = passed;
        begin = leaves + NUDGE;
    }
    return hit;
}

// The same for the first touched sub-voxel, wherever its surface is.
fn trace_touched(level: u32, origin: vec3<f32>, direction: vec3<f32>, reach: f32) -> u32 {
    return walk(level, origin, direction, 0.0, reach);
}

// The first touched sub-voxel from a distance on.
fn walk(level: u32, origin: vec3<f32>, direction: vec3<f32>, begin: f32, reach: f32) -> u32 {
    // A component of 0 never reaches a border; a tiny one does so out of sight, and is finite.
    let ray = select(direction, vec3(1e-12), abs(direction) < vec3(1e-12));
    let inverse = 1.0 / ray;
    let ahead = select(vec3(0.0), vec3(1.0), ray > vec3(0.0));
    let step = select(vec3(-1), vec3(1), ray > vec3(0.0));
    var from_ = origin;
    var distance = begin;
    var limit = reach;
    for (var c = level; c < volume.level_count; c++) {
        var voxel = vec3<i32>(floor(from_ + ray * distance));
        outermost = select(outermost, c, c == level || is_inside(voxel));
        loop {
            if (!is_inside(voxel)) {
                break;
            }
            let index = voxel_index(c, vec3<u32>(voxel));
            let mask = vec2(masks[2u * index], masks[2u * index + 1u]);
            if (any(mask != vec2(0u))) {
                let base = vec3<f32>(voxel);
                var at = distance;
                let entry = (from_ + ray * at - base) * f32(FINE);
                var sub = clamp(vec3<i32>(floor(entry)), vec3(0), vec3(i32(FINE) - 1));
                loop {
                    if (at >= limit) {
                        return NOTHING;
                    }
                    let bit = u32(sub.x + 4 * sub.y + 16 * sub.z);
                    let word = select(mask.x, mask.y, bit >= 32u);
                    let low = base + vec3<f32>(sub) / f32(FINE);
                    let next = (low + ahead / f32(FINE) - from_) * inverse;
                    let axis = smallest(next);
                    if ((word & (1u << (bit & 31u))) != 0u) {
                        let scale = level_voxel_size(c) / level_voxel_size(level);
                        travelled = at * scale;
                        leaves = next[axis] * scale;
                        leaves_from_middle = from_ + ray * next[axis] - low - 0.5 / f32(FINE);
                        return 64u * index + bit;
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
                return NOTHING;
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
    return NOTHING;
}
