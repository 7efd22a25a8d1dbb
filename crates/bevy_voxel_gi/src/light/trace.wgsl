// What a ray meets: the first touched sub-voxel in which it comes behind the middle. The surface is
// taken to go through there: where in the sub-voxel it really is nobody knows, but so it is at the
// right place in the mean, while all of the sub-voxel would be too near, and windows too narrow.

#define_import_path bevy_voxel_gi::trace

#import bevy_voxel_gi::faces::{is_outermost, surface_normal}
#import bevy_voxel_gi::volume::{FACES, face_towards}
#import bevy_voxel_gi::walk::{NOTHING, Touched, walk}

// How the surfaces of a voxel are turned to a ray that touches a sub-voxel of theirs.
struct Facing {
    // The axes of which the face towards the ray has a surface that is turned to it, a bit each.
    turned: u32,
    // Those of them whose surface is at the sub-voxel. Without this rule the outside of a thin wall
    // would be seen from within.
    shown: u32,
    // A face in front of whose surface the ray stays: `FACES` times the index of the voxel, plus the
    // face. `NOTHING` without.
    grazed: u32,
}

fn facing(touched: Touched, direction: vec3<f32>) -> Facing {
    var result = Facing(0u, 0u, NOTHING);
    for (var axis = 0u; axis < 3u; axis++) {
        let face = face_towards(axis, -direction[axis]);
        let normal = surface_normal(touched.index, face);
        if (dot(direction, normal) < 0.0) {
            result.turned |= 1u << axis;
            if (is_outermost(touched.level, touched.voxel, touched.mask, touched.cell, face)) {
                result.shown |= 1u << axis;
                let stays = dot(normal, touched.leaves_from_middle) >= 0.0;
                let grazed = FACES * touched.index + face;
                result.grazed = select(result.grazed, min(result.grazed, grazed), stays);
            }
        }
    }
    return result;
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
        let seen = facing(touched, direction);
        met.turned = seen.turned;
        met.shown = seen.shown;
        met.distance = touched.distance;
        // There was a gap since the sub-voxel that it grazed.
        met.grazed = select(met.grazed, NOTHING, touched.distance > begin + NUDGE);
        if (seen.grazed == NOTHING) {
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
    return met.turned == 0u;
}

// Whether the ray, which met something, may have begun inside of it.
fn is_enclosed(met: Met) -> bool {
    return met.shown == 0u && select(met.grazed == NOTHING, met.distance < NEAR, is_back(met));
}
