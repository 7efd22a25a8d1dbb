//! The textures of lights count in direct light, where Bevy's `pbr_lighting.wesl` projects them.

use std::f32::consts::PI;

use bevy::{
    asset::RenderAssetUsages,
    camera::primitives::CubemapLayout,
    image::ToExtents,
    light::{DirectionalLightTexture, PointLightTexture, SpotLightTexture},
    prelude::*,
    render::render_resource::{TextureDimension, TextureFormat},
};
use bevy_voxel_gi::{Bounces, Solver};

use super::{
    fixture::*,
    room::{around_room, quad, room, spawn},
};
use crate::support::drawn;

/// The faces of a cube, in the order of Bevy's sequences.
const FACES: [Vec3; 6] = [
    Vec3::X,
    Vec3::NEG_X,
    Vec3::Y,
    Vec3::NEG_Y,
    Vec3::NEG_Z,
    Vec3::Z,
];

/// The layouts of cubes with their faces by row and column. Of crosses, Bevy's shader takes -Z for +Z and the other way
/// round, unlike the documentation of `CubemapLayout`.
const LAYOUTS: [(CubemapLayout, &[&str]); 4] = [
    (CubemapLayout::CrossVertical, &[".2.", "150", ".3.", ".4."]),
    (CubemapLayout::CrossHorizontal, &[".2..", "1504", ".3.."]),
    (
        CubemapLayout::SequenceVertical,
        &["0", "1", "2", "3", "4", "5"],
    ),
    (CubemapLayout::SequenceHorizontal, &["012345"]),
];

/// An image of one channel, from the value at coordinates.
fn image(size: UVec2, value: impl Fn(Vec2) -> f32) -> Image {
    let texels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| UVec2::new(x, y)));
    let texels = texels.map(|at| (at.as_vec2() + 0.5) / size.as_vec2());
    let texels = texels.map(|uv| (255.0 * value(uv)).round() as u8);
    image_of(size, TextureFormat::R8Unorm, texels.collect())
}

/// A cube in a layout, from the value of each face at coordinates of the face.
fn cube_image(layout: CubemapLayout, value: impl Fn(usize, Vec2) -> f32) -> Image {
    const EDGE: u32 = 16;
    let (_, cells) = LAYOUTS[layout as usize];
    let grid = UVec2::new(cells[0].len() as u32, cells.len() as u32);
    image(EDGE * grid, |uv| {
        let at = uv * grid.as_vec2();
        let cell = at.as_uvec2();
        let face = char::from(cells[cell.y as usize].as_bytes()[cell.x as usize]).to_digit(10);
        face.map_or(0.0, |face| value(face as usize, at.fract()))
    })
}

/// The types of lights that have textures.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Directional,
    Tiled,
    Spot,
    Point,
}

const KINDS: [Kind; 4] = [Kind::Directional, Kind::Tiled, Kind::Spot, Kind::Point];

const OUTER_ANGLE: f32 = 0.9;

/// Above the floor; all but the point light shine down, and their up is between the axes.
fn place(kind: Kind) -> Transform {
    let above = Transform::from_xyz(0.0, 1.6, 0.0);
    match kind {
        Kind::Point => above,
        // A texture covers two units of the light's space.
        Kind::Directional => above
            .looking_to(Vec3::NEG_Y, Vec3::Z)
            .with_scale(Vec3::splat(2.0)),
        _ => above.looking_to(Vec3::NEG_Y, Vec3::Z),
    }
}

fn spawn_light(world: &mut World, kind: Kind) -> Entity {
    let entity = world.spawn(place(kind)).id();
    let mut light = world.entity_mut(entity);
    match kind {
        Kind::Directional | Kind::Tiled => light.insert(DirectionalLight {
            illuminance: 20.0,
            ..default()
        }),
        Kind::Spot => light.insert(SpotLight {
            intensity: 200.0 * PI,
            inner_angle: OUTER_ANGLE,
            outer_angle: OUTER_ANGLE,
            ..default()
        }),
        Kind::Point => light.insert(point_light(200.0 * PI, 20.0)),
    };
    entity
}

/// Gives a light a texture from the value at its coordinates, those of the face for a point light.
fn project(world: &mut World, light: Entity, kind: Kind, value: impl Fn(Vec2) -> f32) {
    let image = match kind {
        Kind::Point => cube_image(CubemapLayout::CrossHorizontal, |_, uv| value(uv)),
        _ => image(UVec2::splat(64), value),
    };
    let image = world.add_asset(image);
    let mut light = world.entity_mut(light);
    match kind {
        Kind::Directional | Kind::Tiled => light.insert(DirectionalLightTexture {
            image,
            tiled: kind == Kind::Tiled,
        }),
        Kind::Spot => light.insert(SpotLightTexture { image }),
        Kind::Point => light.insert(PointLightTexture {
            image,
            cubemap_layout: CubemapLayout::CrossHorizontal,
        }),
    };
}

/// Where Bevy samples the texture of a light for a point of the floor.
fn coordinates(kind: Kind, point: Vec3) -> Vec2 {
    let local = place(kind).to_matrix().inverse().transform_point3(point);
    match kind {
        Kind::Directional => local.truncate() * Vec2::new(-0.5, 0.5) + 0.5,
        Kind::Tiled => (local.truncate() * Vec2::new(-0.5, 0.5) + 0.5).fract_gl(),
        Kind::Spot => local.truncate() / (local.z * OUTER_ANGLE.tan()) * Vec2::new(-0.5, 0.5) + 0.5,
        // The floor's middle is in the face -Y.
        Kind::Point => Vec2::new(local.x, local.z) / -local.y * 0.5 + 0.5,
    }
}

/// The settled light of all voxels.
fn settled_light(app: &mut HeadlessApp) -> Vec<[Vec4; 6]> {
    ready(app);
    frames(app, 2);
    settle(app);
    read_texels(app)
}

fn total<'a>(light: impl IntoIterator<Item = &'a [Vec4; 6]>) -> Vec3 {
    let light = light.into_iter().flatten();
    light.map(|light| light.truncate()).sum()
}

#[test]
fn a_gray_texture_dims_each_type_of_light() {
    // Above 16, lights are culled.
    let rows = [1, 20].map(|count| KINDS.map(|kind| (count, kind)));
    for (count, kind) in drawn(1, rows.into_iter().flatten()) {
        let mut app = floor_app();
        let world = app.world_mut();
        let lights: Vec<_> = (0..count).map(|_| spawn_light(world, kind)).collect();
        world.spawn(small_volume());
        let without = total(&settled_light(&mut app)).x;
        for light in lights {
            project(app.world_mut(), light, kind, |_| 0.6);
        }
        let dimmed = total(&settled_light(&mut app)).x / without;
        println!("{count} x {kind:?}: {dimmed:.4}");
        assert!((dimmed - 0.6).abs() < 0.006, "{count} x {kind:?}: {dimmed}");
    }
}

/// The light just above the floor within a metre of its middle: all, and in the halves towards +X and +Z.
fn above_floor(light: &[[Vec4; 6]]) -> [f32; 3] {
    let resolution = RESOLUTION as usize;
    let voxel = 4.0 / RESOLUTION as f32;
    let mut sums = [0.0; 3];
    for (i, light) in light.iter().enumerate() {
        let [x, y, z] = [1, resolution, resolution * resolution].map(|step| i / step % resolution);
        let at = (Vec2::new(x as f32, z as f32) + 0.5) * voxel - 2.0;
        if y == resolution / 2 && at.abs().max_element() < 1.0 {
            let light = total([light]).x;
            sums[0] += light;
            sums[1] += if at.x > 0.0 { light } else { 0.0 };
            sums[2] += if at.y > 0.0 { light } else { 0.0 };
        }
    }
    sums
}

#[test]
fn half_a_texture_lights_its_own_side() {
    type Half = (&'static str, fn(Vec2) -> bool);
    const HALVES: [[Half; 2]; 2] = [
        [("left", |uv| uv.x < 0.5), ("right", |uv| uv.x >= 0.5)],
        [("top", |uv| uv.y < 0.5), ("bottom", |uv| uv.y >= 0.5)],
    ];
    for kind in drawn(1, KINDS) {
        let mut app = floor_app();
        let world = app.world_mut();
        let light = spawn_light(world, kind);
        world.spawn(small_volume());
        project(world, light, kind, |_| 1.0);
        let [whole, ..] = above_floor(&settled_light(&mut app));
        for halves in HALVES {
            let mut sum = 0.0;
            for (name, is_lit) in halves {
                let value = |uv| if is_lit(uv) { 1.0 } else { 0.0 };
                project(app.world_mut(), light, kind, value);
                let [all, to_x, to_z] = above_floor(&settled_light(&mut app));
                sum += all;
                // Half a metre from the middle, tiles of two metres do not repeat.
                let lit_at = |point| is_lit(coordinates(kind, point));
                let sides = [(to_x, 0.5 * Vec3::X), (to_z, 0.5 * Vec3::Z)];
                let shares = sides.map(|(light, _)| light / all);
                println!("{kind:?}, {name}: {shares:.3?}");
                for ((_, side), share) in sides.into_iter().zip(shares) {
                    match (lit_at(side), lit_at(-side)) {
                        (true, false) => assert!(share > 0.75, "{kind:?}, {name}: {share}"),
                        (false, true) => assert!(share < 0.25, "{kind:?}, {name}: {share}"),
                        _ => assert!((share - 0.5).abs() < 0.05, "{kind:?}, {name}: {share}"),
                    }
                }
            }
            let wrong = (sum / whole - 1.0).abs();
            println!("{kind:?}: {sum} for {whole}");
            assert!(wrong < 0.01, "{kind:?}: {sum} for {whole}");
        }
    }
}

/// In the middle of a room whose walls each reflect other colours, once.
#[test]
fn each_face_of_a_cube_lights_its_wall() {
    let colors = [
        Vec3::X,
        Vec3::Y,
        Vec3::Z,
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(0.0, 1.0, 1.0),
        Vec3::new(1.0, 0.0, 1.0),
    ];
    let mut app = app();
    let world = app.world_mut();
    settings(world).light = global_illumination(Solver::default(), Bounces::Count(1));
    for side in room() {
        let face = FACES.iter().position(|face| *face == -side.1);
        let color = LinearRgba::from_vec3(colors[face.expect("a face")]);
        spawn(world, quad(side), StandardMaterial::from_color(color));
    }
    let light = (point_light(400.0 * PI, 20.0), Transform::IDENTITY);
    let light = world.spawn(light).id();
    world.spawn(around_room());
    // Three walls reflect each colour.
    let of_wall = total(&settled_light(&mut app)) / 3.0;
    let rows = LAYOUTS
        .into_iter()
        .flat_map(|(layout, _)| (0..6).map(move |face| (layout, face)));
    for (layout, face) in drawn(2, rows) {
        let lit = |other, _| if other == face { 1.0 } else { 0.0 };
        let image = app.world_mut().add_asset(cube_image(layout, lit));
        let texture = PointLightTexture {
            image,
            cubemap_layout: layout,
        };
        app.world_mut().entity_mut(light).insert(texture);
        let found = total(&settled_light(&mut app)) / of_wall;
        let wrong = (found - colors[face]).abs().max_element();
        println!("{layout:?}, {}: {found:.4}, {wrong:.4}", FACES[face]);
        assert!(wrong < 0.01, "{layout:?}, {}: {found}", FACES[face]);
    }
}

/// A black image of three dimensions.
fn solid() -> Image {
    Image::new_fill(
        UVec3::splat(4).to_extents(),
        TextureDimension::D3,
        &[0],
        TextureFormat::R8Unorm,
        RenderAssetUsages::all(),
    )
}

#[test]
fn after_any_change_of_a_texture_the_light_is_that_of_a_new_app() {
    type Value = fn(Vec2) -> f32;
    let left: Value = |uv| if uv.x < 0.5 { 1.0 } else { 0.0 };
    let right: Value = |uv| if uv.x < 0.5 { 0.0 } else { 0.8 };
    let small = |value: Value| image(UVec2::splat(32), value);
    let scene = |world: &mut World| {
        floor(world);
        block(world, Vec3::new(0.7, 0.5, 0.0), Vec3::ONE);
        world.spawn(small_volume());
        spawn_light(world, Kind::Spot)
    };
    let as_new = |image: Option<Image>| {
        let mut app = app_with(|_| ());
        let light = scene(app.world_mut());
        if let Some(image) = image {
            let image = app.world_mut().add_asset(image);
            let texture = SpotLightTexture { image };
            app.world_mut().entity_mut(light).insert(texture);
        }
        settled_light(&mut app)
    };
    let difference = |a: &[[Vec4; 6]], b: &[[Vec4; 6]]| {
        let pairs = a.iter().flatten().zip(b.iter().flatten());
        let wrong: f32 = pairs.map(|(a, b)| (a.x - b.x).abs()).sum();
        wrong / total(a).x
    };
    let mut app = app_with(|_| ());
    let light = scene(app.world_mut());
    let mut before = settled_light(&mut app);
    let memory = |app: &HeadlessApp| report(app).memory;
    let without = memory(&app);
    let first = app.world_mut().add_asset(small(left));
    let later = app.world().resource::<Assets<Image>>().reserve_handle();
    let insert = |world: &mut World, image: &Handle<Image>| {
        let image = image.clone();
        world.entity_mut(light).insert(SpotLightTexture { image });
    };
    type Change<'a> = (&'static str, Option<Image>, &'a dyn Fn(&mut World));
    let changes: [Change; 8] = [
        ("added", Some(small(left)), &|world| insert(world, &first)),
        ("edited", Some(small(right)), &|world| {
            let mut images = world.resource_mut::<Assets<Image>>();
            images.get_mut(&first).expect("an image").data = small(right).data;
        }),
        ("not loaded", None, &|world| insert(world, &later)),
        ("loaded", Some(small(left)), &|world| {
            let mut images = world.resource_mut::<Assets<Image>>();
            images.insert(&later, small(left)).expect("a handle");
        }),
        ("swapped", Some(small(right)), &|world| {
            insert(world, &first);
        }),
        ("that cannot be read", None, &|world| {
            let black = world.add_asset(solid());
            insert(world, &black);
        }),
        (
            "of another size",
            Some(image(UVec2::new(8, 4), left)),
            &|world| {
                let mut images = world.resource_mut::<Assets<Image>>();
                let new = image(UVec2::new(8, 4), left);
                images.insert(&first, new).expect("a handle");
                insert(world, &first);
            },
        ),
        ("removed", None, &|world| {
            world.entity_mut(light).remove::<SpotLightTexture>();
        }),
    ];
    let compared = drawn(1, 0..changes.len());
    for (i, (name, texture, change)) in changes.into_iter().enumerate() {
        change(app.world_mut());
        let found = settled_light(&mut app);
        let effect = difference(&found, &before);
        assert!(effect > 0.05, "{name}: an effect of {effect}");
        let has_tile = texture.is_some();
        if compared.contains(&i) {
            let wrong = difference(&as_new(texture), &found);
            println!("{name}: {wrong:.5} of an effect of {effect:.5}");
            assert!(wrong < 0.001, "{name}: {wrong} of {effect}");
        }
        assert_eq!(memory(&app) > without, has_tile, "{name}: {}", memory(&app));
        assert_eq!(settle(&mut app), 1, "{name}: it rests");
        before = found;
    }
    assert_eq!(memory(&app), without);
}
