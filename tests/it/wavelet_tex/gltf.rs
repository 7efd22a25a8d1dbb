//! A glTF file through Bevy's own loader, shown with the wavelet texture of the image inside it.

use bevy::{
    asset::AssetServer, gltf::GltfAssetLabel, prelude::*, world_serialization::WorldAssetRoot,
};
use bevy_frugal_lab::content;
use bevy_wavelet_tex::{
    WaveletFilter, WaveletGltf, WaveletStandardMaterial,
    codec::image::{ColorSpace, Content},
    file,
};
use image::{DynamicImage, ImageFormat, RgbImage};

use super::{
    driver::Driver,
    loading::Folder,
    modes::chroma_rounding,
    scene::{STEP, decoded_by, difference, encoded, gpu_with_all_planes, linear},
    viewer::Viewer,
};

const SIZE: [u32; 2] = [64, 48];

/// A binary glTF file: an unlit quad of `SIZE` units around the origin with a picture on it.
fn glb(picture: RgbImage) -> Vec<u8> {
    let [x, y] = SIZE.map(|s| s as f32 / 2.0);
    let positions = [[-x, y, 0.0], [x, y, 0.0], [-x, -y, 0.0], [x, -y, 0.0]];
    let uvs = [[0.0f32, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let indices = [0u32, 2, 1, 1, 2, 3];
    let mut png = std::io::Cursor::new(Vec::new());
    DynamicImage::from(picture)
        .write_to(&mut png, ImageFormat::Png)
        .expect("a PNG");
    let parts: [&[u8]; 4] = [
        bytemuck::cast_slice(&positions),
        bytemuck::cast_slice(&uvs),
        bytemuck::cast_slice(&indices),
        png.get_ref(),
    ];
    let mut views = Vec::new();
    let mut binary = Vec::new();
    for part in parts {
        views.push(serde_json::json!({
            "buffer": 0, "byteOffset": binary.len(), "byteLength": part.len()
        }));
        binary.extend(part);
        binary.resize(binary.len().next_multiple_of(4), 0);
    }
    let json = serde_json::json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_unlit"],
        "buffers": [{"byteLength": binary.len()}],
        "bufferViews": views,
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                "min": positions[2], "max": positions[1],
            },
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5125, "count": 6, "type": "SCALAR"},
        ],
        "images": [{"bufferView": 3, "mimeType": "image/png"}],
        "textures": [{"source": 0}],
        "materials": [{
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
            "extensions": {"KHR_materials_unlit": {}},
        }],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0,
        }]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    });
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let mut glb = b"glTF".to_vec();
    glb.extend([2, length as u32].map(u32::to_le_bytes).as_flattened());
    for (kind, bytes) in [(b"JSON", &json), (b"BIN\0", &binary)] {
        glb.extend((bytes.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(bytes);
    }
    glb
}

#[test]
fn an_image_inside_a_gltf_file_is_shown_as_its_wavelet_texture() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let driver = Driver::new();
    let [inside, other] = [3, 9].map(|seed| content::photo_like(SIZE[0], SIZE[1], seed));
    // Another picture than the one inside, so that one sees which is shown.
    let image = encoded(&other, Content::Color, ColorSpace::Srgb);
    let folder = Folder::new("glb")
        .with("model.glb", &glb(inside))
        .with("model.glb.Texture0.wtex", &file::write(&image));
    let mut viewer = Viewer::with_settings(SIZE, folder.settings());
    let world = viewer.app.world_mut();
    let scene = GltfAssetLabel::Scene(0).from_asset("model.glb");
    let scene = world.resource::<AssetServer>().load(scene);
    world.spawn((
        WorldAssetRoot(scene),
        WaveletGltf {
            filter: WaveletFilter::Nearest,
        },
        Transform::from_xyz(0.0, 0.0, 1.0),
    ));
    let mut exchanged = 0;
    for _ in 0..500 {
        viewer.app.render_frames(1).expect("frames");
        let world = viewer.app.world_mut();
        let mut meshes = world.query::<&MeshMaterial3d<WaveletStandardMaterial>>();
        exchanged = meshes.iter(world).count();
        if exchanged > 0 {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert_eq!(exchanged, 1);
    viewer.app.run_until_ready(200).expect("ready");
    let shown = viewer.app.capture_f32().expect("a picture");
    let (_, pixels) = linear(&image, decoded_by(&driver, &image, 0));
    let found = difference(&shown, |x, y| pixels[(y * SIZE[0] + x) as usize]);
    let most = 2.0 * STEP + chroma_rounding(&image);
    assert!(
        found.largest <= most,
        "{} steps at {:?}",
        found.largest / STEP,
        found.at
    );
    // The image inside the file went with the material that used it.
    let world = viewer.app.world_mut();
    let mut meshes = world.query::<&MeshMaterial3d<StandardMaterial>>();
    assert_eq!(meshes.iter(world).count(), 0);
}
