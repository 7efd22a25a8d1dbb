// The surface that a workgroup is about, from the list of all.

#define_import_path bevy_voxel_gi::entry

#import bevy_voxel_gi::faces::{exposed_in_column, surface_normal}
#import bevy_voxel_gi::surface::{SurfacePlane, main_face, surface_plane}

// First surfaces, then voxels without: 8 times the voxel's index, plus the face.
@group(1) @binding(0) var<storage, read> work: array<u32>;
// How many of each.
@group(1) @binding(1) var<storage, read> counters: array<u32>;

var<workgroup> exposed_words: array<atomic<u32>, 2>;

struct Entry {
    index: u32,
    // The first of those that the surface stands for.
    face: u32,
    normal: vec3<f32>,
    // Its sub-voxels that are free in front, and that of this thread, or 64.
    exposed: vec2<u32>,
    bit: u32,
    plane: SurfacePlane,
}

fn exposed_now() -> vec2<u32> {
    return vec2(atomicLoad(&exposed_words[0]), atomicLoad(&exposed_words[1]));
}

// What a workgroup is about, as it stands in `work`.
fn work_item(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    let place = group.x + group.y * groups.x;
    return work[min(place, counters[0] - 1u)];
}

// All threads of the workgroup, 16 or more, must come here.
fn load_entry(item: u32, thread: u32) -> Entry {
    var result: Entry;
    result.index = item >> 3u;
    result.face = item & 7u;
    result.normal = surface_normal(result.index, result.face);
    result.bit = 64u;
    if (thread < 16u) {
        result.bit = exposed_in_column(result.index, main_face(result.normal), thread);
        if (result.bit < 64u) {
            atomicOr(&exposed_words[result.bit >> 5u], 1u << (result.bit & 31u));
        }
    }
    workgroupBarrier();
    result.exposed = exposed_now();
    result.plane = surface_plane(result.exposed, result.normal);
    return result;
}
