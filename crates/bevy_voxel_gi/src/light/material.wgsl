// What voxels know of materials.

#define_import_path bevy_voxel_gi::material

// In step with `scene/surface.rs`.
struct Material {
    albedo: vec3<f32>,
    emissive_exposure_weight: f32,
    emissive: vec3<f32>,
    double_sided: u32,
    transparent: u32,
    coverage: f32,
}
