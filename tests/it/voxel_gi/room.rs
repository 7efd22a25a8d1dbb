//! A closed room of quads with colours, in which light bounces.

use std::f32::consts::PI;

use bevy::{
    asset::RenderAssetUsages,
    image::{CompressedImageFormats, ImageSampler, ImageType},
    mesh::{Indices, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
    render::render_resource::TextureFormat,
};
use bevy_voxel_gi::VoxelGiVolume;

use super::fixture::*;
use crate::support::triangle_mesh;

/// Four colours, sRGB; even numbers, which blocks of BC7 store as they are.
pub const PALETTE: [[u8; 3]; 4] = [[230, 230, 230], [220, 30, 30], [30, 200, 30], [20, 20, 20]];

/// A quad: corners, normal, and number of its colour.
pub type Quad = ([Vec3; 4], Vec3, usize);

/// The inner sides of a closed room of 3.6 m; cameras outside look through them.
pub fn room() -> Vec<Quad> {
    const HALF: f32 = 1.8;
    let sides = [
        (Vec3::X, 1),
        (Vec3::NEG_X, 2),
        (Vec3::Y, 0),
        (Vec3::NEG_Y, 0),
        (Vec3::Z, 0),
        (Vec3::NEG_Z, 0),
    ];
    sides
        .map(|(normal, color)| (square(-HALF * normal, normal, HALF), normal, color))
        .to_vec()
}

/// The corners of a square around a centre.
pub fn square(center: Vec3, normal: Vec3, half: f32) -> [Vec3; 4] {
    let (u, v) = normal.any_orthonormal_pair();
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[x, y]| center + half * (x * u + y * v))
}

pub fn mesh(quads: &[Quad], uvs: impl Fn(&Quad) -> [Vec2; 4]) -> Mesh {
    let (mut positions, mut normals, mut coordinates) = (vec![], vec![], vec![]);
    let (mut colors, mut indices) = (vec![], vec![]);
    for quad in quads {
        let first = positions.len() as u32;
        let (corners, normal, color) = quad;
        let is_front = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .dot(*normal)
            > 0.0;
        for (corner, uv) in corners.iter().zip(uvs(quad)) {
            positions.push(corner.to_array());
            normals.push(normal.to_array());
            coordinates.push(uv.to_array());
            colors.push(linear(*color).to_f32_array());
        }
        let order = if is_front {
            [0, 1, 2, 0, 2, 3]
        } else {
            [0, 2, 1, 0, 3, 2]
        };
        indices.extend(order.map(|i| first + i));
    }
    triangle_mesh(PrimitiveTopology::TriangleList, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, coordinates)
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_COLOR,
            VertexAttributeValues::Float32x4(colors),
        )
        .with_inserted_indices(Indices::U32(indices))
}

pub fn without_colors(mut mesh: Mesh) -> Mesh {
    mesh.remove_attribute(Mesh::ATTRIBUTE_COLOR);
    mesh
}

/// A quad with coordinates of a whole texture.
pub fn quad(quad: Quad) -> Mesh {
    without_colors(mesh(&[quad], whole))
}

pub fn linear(color: usize) -> LinearRgba {
    let [r, g, b] = PALETTE[color];
    Color::srgb_u8(r, g, b).to_linear()
}

/// Coordinates of the middle of a colour's strip in the palette.
pub fn in_palette((_, _, color): &Quad) -> [Vec2; 4] {
    [Vec2::new((*color as f32 + 0.5) / 4.0, 0.5); 4]
}

/// Coordinates of a whole texture.
pub fn whole(_: &Quad) -> [Vec2; 4] {
    [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]
}

pub fn matt_with(material: StandardMaterial) -> StandardMaterial {
    StandardMaterial {
        perceptual_roughness: 1.0,
        reflectance: 0.0,
        ..material
    }
}

pub fn image(size: UVec2, texel: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    let texels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y)));
    let texels = texels.flat_map(|(x, y)| texel(x, y)).collect();
    image_of(size, TextureFormat::Rgba8UnormSrgb, texels)
}

/// Four strips of the palette.
pub fn palette() -> Image {
    image(UVec2::splat(64), |x, _| {
        let [r, g, b] = PALETTE[x as usize / 16];
        [r, g, b, 255]
    })
}

/// The same with a block of BC7 for each: mode 6, with equal ends.
pub fn compressed_palette() -> Image {
    let block = |[r, g, b]: [u8; 3]| {
        let ends = [r, g, b, 254].map(|channel| u128::from(channel >> 1));
        let channels = ends.iter().enumerate();
        let word = channels.fold(1 << 6, |word: u128, (i, end)| {
            word | end << (7 + 14 * i) | end << (14 + 14 * i)
        });
        word.to_le_bytes()
    };
    let blocks = PALETTE.iter().flat_map(|color| block(*color)).collect();
    let format = TextureFormat::Bc7RgbaUnormSrgb;
    Image {
        asset_usage: RenderAssetUsages::RENDER_WORLD,
        ..image_of(UVec2::new(16, 4), format, blocks)
    }
}

/// The same from a KTX2 file, without descriptors of its format.
pub fn palette_of_file() -> Image {
    const BC7_SRGB_BLOCK: u32 = 146;
    const DESCRIPTORS: u32 = 104;
    const BLOCKS: u64 = 112;
    let image = compressed_palette();
    let blocks = image.data.expect("blocks");
    let size = blocks.len() as u64;
    let format = [BC7_SRGB_BLOCK, 1, 16, 4, 0, 0, 1, 1, 0];
    let index = [DESCRIPTORS, 4, 0, 0, 0, 0, 0, 0];
    let level = [BLOCKS, size, size];
    let mut file = b"\xABKTX 20\xBB\r\n\x1A\n".to_vec();
    file.extend(
        [&format[..], &index]
            .concat()
            .iter()
            .flat_map(|word| word.to_le_bytes()),
    );
    file.extend(level.iter().flat_map(|word| word.to_le_bytes()));
    file.resize(BLOCKS as usize, 0);
    file.extend(blocks);
    Image::from_buffer(
        &file,
        ImageType::Extension("ktx2"),
        CompressedImageFormats::BC,
        true,
        ImageSampler::Default,
        RenderAssetUsages::RENDER_WORLD,
    )
    .expect("a file")
}

pub fn spawn(world: &mut World, mesh: Mesh, material: StandardMaterial) -> Entity {
    let model = model(world, mesh, matt_with(material));
    world.spawn(model).id()
}

/// Spawns a quad whose material has the quad's colour.
pub fn spawn_colored(world: &mut World, colored: Quad) {
    let material = StandardMaterial::from_color(linear(colored.2));
    spawn(world, quad(colored), material);
}

/// A material with only a base colour texture.
pub fn textured(world: &mut World, image: Image) -> StandardMaterial {
    StandardMaterial {
        base_color_texture: Some(world.add_asset(image)),
        ..default()
    }
}

pub fn ceiling_light(world: &mut World) -> Entity {
    let light = PointLight {
        shadow_maps_enabled: false,
        ..point_light(400.0 * PI, 20.0)
    };
    let place = Transform::from_xyz(0.0, 1.0, 0.0);
    world.spawn((light, place)).id()
}

pub fn around_room() -> VoxelGiVolume {
    VoxelGiVolume::fixed(5.0)
}

/// The indirect light on the floor, left and right, of a room.
pub fn on_floor(build: impl FnOnce(&mut World)) -> [Vec3; 3] {
    on_floor_without_light(|world| {
        build(world);
        ceiling_light(world);
    })
}

/// The same where only emission lights the room.
pub fn on_floor_without_light(build: impl FnOnce(&mut World)) -> [Vec3; 3] {
    let mut app = app();
    build(app.world_mut());
    in_room(&mut app)
}

/// The same in an app.
pub fn in_room(app: &mut HeadlessApp) -> [Vec3; 3] {
    ready(app);
    places(&indirect(app, around_room()))
}

fn places(light: &[Vec3]) -> [Vec3; 3] {
    [
        at(light, -1.2, 0.0),
        at(light, 0.0, 1.0),
        at(light, 1.2, -0.4),
    ]
}

pub fn assert_close(what: &str, actual: [Vec3; 3], expected: [Vec3; 3], tolerance: f32) {
    for (actual, expected) in actual.into_iter().zip(expected) {
        let wrong = (actual / expected - 1.0).abs().max_element();
        assert!(
            wrong < tolerance,
            "{what}: {actual} for {expected}, {wrong}"
        );
    }
}
