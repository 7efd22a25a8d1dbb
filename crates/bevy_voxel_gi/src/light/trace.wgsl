// What a ray meets: the first touched sub-voxel in which it comes behind the middle. The surface is
// taken to go through there: where in the sub-voxel it really is nobody knows, but so it is at the
// right place in the mean, while all of the sub-voxel would be too near, and windows too narrow.

#define_import_path bevy_voxel_gi::trace

#import bevy_voxel_gi::faces::{is_outermost, surface_normal}
#import bevy_voxel_gi::volume::{FACES, face_towards}
#import bevy_voxel_gi::walk::{NOTHING, Touched, walk}

// In place of a surface: a ray stays behind that.
const BACK: u32 = 0xfffffffeu;

// How the surfaces of a voxel are turned to a ray that touches a sub-voxel of theirs.
struct Facing {
    // The axes of which the face towards the ray has a surface that is turned to it, a bit each.
    turned: u32,
    // Those of them whose surface is at the sub-voxel. Without this rule the outside of a thin wall
    // would be seen from within.
    shown: u32,
    // Whether the ray goes on.
    passes: bool,
    // What it only grazes then: a surface in front of which it stays, `FACES` times the index of the
    // voxel, plus the face; or `BACK`; or `NOTHING`.
    grazed: u32,
}

// `before` is what the ray grazed in the sub-voxel just before.
fn facing(touched: Touched, direction: vec3<f32>, before: u32) -> Facing {
    var result = Facing(0u, 0u, false, NOTHING);
    for (var axis = 0u; axis < 3u; axis++) {
        let face = face_towards(axis, -direction[axis]);
        let normal = surface_normal(touched.index, face);
        if (dot(direction, normal) < 0.0) {
            result.turned |= 1u << axis;
            if (is_own(touched, face)) {
                result.shown |= 1u << axis;
                let stays = dot(normal, touched.leaves_from_middle) >= 0.0;
                let grazed = FACES * touched.index + face;
                result.grazed = select(result.grazed, min(result.grazed, grazed), stays);
            }
        }
    }
    result.passes = result.grazed != NOTHING;
    if (result.turned == 0u) {
        let away = facing_away(touched, direction);
        result.passes = away == STAYS_BEHIND || (away == WAS_IN_FRONT && before != BACK);
        result.grazed = select(NOTHING, BACK, away == STAYS_BEHIND);
    }
    return result;
}

fn is_own(touched: Touched, face: u32) -> bool {
    return is_outermost(touched.level, touched.voxel, touched.mask, touched.cell, face);
}

const STAYS_BEHIND: u32 = 1u;
const WAS_IN_FRONT: u32 = 2u;

// On which side a ray is of all surfaces of a sub-voxel, which are turned away from it; 0 without any
// or if it goes through. Behind one of two that make an edge it may be in front of the other.
fn facing_away(touched: Touched, direction: vec3<f32>) -> u32 {
    var away = 0u;
    var behind = 0u;
    var in_front = 0u;
    for (var axis = 0u; axis < 3u; axis++) {
        let face = face_towards(axis, direction[axis]);
        let normal = surface_normal(touched.index, face);
        if (dot(direction, normal) > 0.0) {
            away += 1u;
            if (is_own(touched, face)) {
                behind += select(0u, 1u, dot(normal, touched.leaves_from_middle) <= 0.0);
                in_front += select(0u, 1u, dot(normal, touched.enters_from_middle) >= 0.0);
            }
        }
    }
    if (away == 0u) {
        return 0u;
    }
    return select(select(0u, WAS_IN_FRONT, in_front == away), STAYS_BEHIND, behind == away);
}

struct Met {
    // Index of the voxel, `NOTHING` if the ray meets none.
    index: u32,
    // The last level that it was in.
    level: u32,
    // As of `Facing`.
    turned: u32,
    shown: u32,
    // How far it went, in voxels of the level where it began.
    distance: f32,
    // What it grazed in the sub-voxel just before.
    grazed: u32,
}

// Where a ray goes on behind a sub-voxel that it grazed, in voxels: surely in the next one.
const NUDGE: f32 = 0.0009765625;

// As `walk`. The loop is around the walk and not in it, so that rays beside each other walk together.
fn trace(level: u32, origin: vec3<f32>, direction: vec3<f32>, reach: f32) -> Met {
    var begin = 0.0;
    var met = Met(NOTHING, level, 0u, 0u, 0.0, NOTHING);
    loop {
        let touched = walk(level, origin, direction, begin, reach);
        met.index = touched.index;
        met.level = touched.level;
        if (touched.index == NOTHING) {
            break;
        }
        // There was a gap since the sub-voxel that it grazed.
        met.grazed = select(met.grazed, NOTHING, touched.distance > begin + NUDGE);
        let seen = facing(touched, direction, met.grazed);
        met.turned = seen.turned;
        met.shown = seen.shown;
        met.distance = touched.distance;
        if (!seen.passes) {
            break;
        }
        met.grazed = seen.grazed;
        begin = touched.leaves + NUDGE;
    }
    return met;
}

// A back that is met nearer than this, in voxels, may belong to the solid in which the ray began.
// Of a large solid only what is near its surface matters: receivers outside interpolate with it.
const NEAR: f32 = 4.0;

// Whether the ray met the back of a surface with one side, which is black. Else, if no face shows, it
// ended between surfaces, in an edge or inside of a thin wall: it shows the surface that it grazed,
// or else tells nothing.
fn is_back(met: Met) -> bool {
    return met.turned == 0u || (met.shown == 0u && met.grazed == BACK);
}

// Whether the ray, which met something, may have begun inside of it.
fn is_enclosed(met: Met) -> bool {
    return met.shown == 0u && select(met.grazed == NOTHING, met.distance < NEAR, is_back(met));
}
