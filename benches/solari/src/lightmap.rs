//! Bevy's lightmaps with the indirect light that the lab's path tracer finds.

use bevy::{math::UVec3, pbr::Lightmap, prelude::*, render::render_resource::TextureDimension};
use bevy_frugal_lab::{
    boxes::{BoxScene, trace_receivers},
    path_tracer::{Receiver, TraceSettings},
};

use crate::{
    atlas::{Atlas, BORDER, Face},
    bake::{Baked, fill, texture},
};

/// Paths from each texel.
const SAMPLES: u32 = 2048;

/// Bakes the lightmap of all boxes, an atlas, and gives it to their entities.
pub fn bake(world: &mut World, scene: &BoxScene, boxes: &[Entity]) -> Baked {
    let atlas = Atlas::new(scene);
    let (baked, image) = Baked::bake(|| {
        let size = atlas.size.extend(1);
        texture(TextureDimension::D2, size, &texels(scene, &atlas))
    });
    let image = world.resource_mut::<Assets<Image>>().add(image);
    for (part, &entity) in boxes.iter().enumerate() {
        let mesh = world.resource_mut::<Assets<Mesh>>().add(atlas.mesh(part));
        world.entity_mut(entity).insert((
            Mesh3d(mesh),
            Lightmap {
                image: image.clone(),
                ..default()
            },
        ));
    }
    baked
}

/// Switches all lightmaps on or off.
pub fn switch(world: &mut World, on: bool) {
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    for (_, material) in materials.iter_mut() {
        material.lightmap_exposure = if on { 1.0 } else { 0.0 };
    }
}

/// Irradiance over pi, as Bevy multiplies a lightmap with the albedo alone. A texel has the mean of its area, or
/// of what no other box covers of it.
fn texels(scene: &BoxScene, atlas: &Atlas) -> Vec<Vec3> {
    let (mut faces, mut first) = (Vec::new(), Vec::new());
    for (number, face) in atlas.faces.iter().enumerate() {
        first.push(faces.len());
        let texels = face.texels.element_product() as usize;
        faces.extend(std::iter::repeat_n(number, texels));
    }
    let settings = TraceSettings {
        samples: SAMPLES,
        ..default()
    };
    let light = trace_receivers(scene, &settings, faces.len() as u32, |index, at| {
        let number = faces[index as usize];
        let face = &atlas.faces[number];
        let texel = index - first[number] as u32;
        let corner = UVec2::new(texel % face.texels.x, texel / face.texels.x);
        Some(Receiver {
            position: face.position(corner.as_vec2() + at),
            normal: face.normal,
        })
    });
    let mut texels = vec![Vec3::ZERO; atlas.size.element_product() as usize];
    for (face, &first) in atlas.faces.iter().zip(&first) {
        let light = &light[first..][..face.texels.element_product() as usize];
        write(&mut texels, atlas.size.x, face, light);
    }
    texels
}

/// Writes the rectangle of a face and its border to the atlas.
fn write(texels: &mut [Vec3], width: u32, face: &Face, light: &[Option<Vec3>]) {
    let size = face.texels + 2 * BORDER;
    let mut padded = vec![None; size.element_product() as usize];
    for (row, light) in (BORDER..).zip(light.chunks(face.texels.x as usize)) {
        let start = (row * size.x + BORDER) as usize;
        padded[start..start + light.len()].copy_from_slice(light);
    }
    fill(&mut padded, UVec3::new(size.x, size.y, 1));
    let corner = face.corner - BORDER;
    for (row, light) in (0..).zip(padded.chunks(size.x as usize)) {
        let start = (corner.x + (corner.y + row) * width) as usize;
        for (texel, light) in texels[start..].iter_mut().zip(light) {
            *texel = light.unwrap_or_default();
        }
    }
}
