//! Extracts the lights with their textures, including those outside of every view. Textures are projected as Bevy's
//! `pbr_lighting.wesl` does.

use bevy::{
    camera::{primitives::CubemapLayout, visibility::RenderLayers},
    ecs::{query::QueryData, system::SystemParam},
    light::{DirectionalLightTexture, PointLightTexture, RectLight, SpotLightTexture},
    math::Affine3A,
    prelude::*,
    render::Extract,
};

use super::{place_volume::ExtractedVolume, placement::PlacedLevel};
use crate::{
    gpu_types::{LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_RECT, LIGHT_SPOT, Light},
    passes::kernel::chosen,
    settings::VoxelGiLight,
};

#[derive(Resource, Default)]
pub(crate) struct ExtractedLights {
    pub lights: Vec<Light>,
    /// The textures of lights, with their indices.
    pub textures: Vec<(usize, LightTexture)>,
}

impl ExtractedLights {
    /// The number of lights up to which it costs less to evaluate all than to look for those that reach a surface.
    const FEW: usize = 16;

    /// Whether the texture of any light has a tile.
    pub(crate) fn has_textures(&self) -> bool {
        let mut textured = self.textures.iter().map(|(index, _)| *index);
        textured.any(|index| self.lights[index].tile_size != 0)
    }

    /// The shader defs that direct light needs.
    pub(crate) fn defs(&self) -> Vec<&'static str> {
        let has_rectangles = self.lights.iter().any(|light| light.kind == LIGHT_RECT);
        chosen([
            (self.lights.len() > Self::FEW, "MANY_LIGHTS"),
            (has_rectangles, "RECTANGULAR_LIGHTS"),
            (self.has_textures(), LIGHT_TEXTURES),
        ])
    }
}

/// The shader def of what reads the tiles of the textures of lights.
pub(crate) const LIGHT_TEXTURES: &str = "LIGHT_TEXTURES";

/// The components that lights of all types have.
#[derive(QueryData)]
pub(crate) struct LightParts<L: Component> {
    entity: Entity,
    light: &'static L,
    transform: &'static GlobalTransform,
    visible: &'static InheritedVisibility,
    layers: Option<&'static RenderLayers>,
    factor: Option<&'static VoxelGiLight>,
}

/// Extracts the lights that are on and in the layers of the volumes.
pub(crate) fn extract_lights(
    mut lights: ResMut<ExtractedLights>,
    volume: Res<ExtractedVolume>,
    directional: Extract<Query<LightParts<DirectionalLight>>>,
    points: Extract<Query<LightParts<PointLight>>>,
    spots: Extract<Query<LightParts<SpotLight>>>,
    rects: Extract<Query<LightParts<RectLight>>>,
    textures: LightTextures,
) {
    lights.lights.clear();
    lights.textures.clear();
    let Some(volume) = &volume.0 else {
        return;
    };
    // Occlusion is the same in any light.
    if volume.settings.light.is_occlusion() {
        return;
    }
    let layers = &volume.scene_layers;
    let all = lit(&directional, layers, directional_light)
        .chain(lit(&points, layers, point_light))
        .chain(lit(&spots, layers, spot_light))
        .chain(lit(&rects, layers, rect_light));
    let textured = all.map(|(entity, mut light)| {
        let texture = textures.project(entity, &mut light);
        (light, texture)
    });
    let mut found: Vec<_> = textured
        .filter(|(light, _)| {
            let vectors = [
                light.position,
                light.color,
                light.direction,
                light.half_width,
                light.half_height,
            ];
            vectors.iter().all(|v| v.is_finite())
                && light.inverse_range_squared.is_finite()
                && light.color.max_element() > 0.0
                && volume.levels.iter().any(|level| reaches(light, level))
        })
        .collect();
    // An order which does not depend on their entities: sums of floats depend on their order.
    found.sort_by_cached_key(|(light, texture)| {
        (light.words(), texture.as_ref().map(LightTexture::order))
    });
    let with_textures = found.iter().enumerate();
    let with_textures =
        with_textures.filter_map(|(index, (_, texture))| Some((index, (*texture)?)));
    lights.textures.extend(with_textures);
    lights
        .lights
        .extend(found.into_iter().map(|(light, _)| light));
}

/// Whether light may arrive in a level: beyond its range there is none.
fn reaches(light: &Light, level: &PlacedLevel) -> bool {
    let half = Vec3::splat(0.5 * level.size);
    let outside = ((light.position - level.center).abs() - half).max(Vec3::ZERO);
    light.kind == LIGHT_DIRECTIONAL || outside.length_squared() * light.inverse_range_squared < 1.0
}

/// The direction in which a light shines, zero where its scale is.
fn forward(transform: &GlobalTransform) -> Vec3 {
    (-transform.affine().matrix3.z_axis)
        .normalize_or_zero()
        .into()
}

/// The lights of a type that shine into the volumes, as much as each gives to them.
fn lit<'a, L: Component>(
    all: &'a Query<LightParts<L>>,
    layers: &'a RenderLayers,
    as_light: fn(&L, &GlobalTransform) -> Light,
) -> impl Iterator<Item = (Entity, Light)> {
    let shining = all.iter().filter(|light| {
        let own = light.layers.unwrap_or_default();
        light.visible.get() && own.intersects(layers)
    });
    shining.map(move |parts| {
        let mut light = as_light(parts.light, parts.transform);
        light.color *= parts.factor.map_or(1.0, |own| own.factor);
        (parts.entity, light)
    })
}

/// A light of no kind, size and range.
fn light_at(transform: &GlobalTransform, color: Color, unit: f32, range: f32) -> Light {
    Light {
        position: transform.translation(),
        color: color.to_linear().to_vec3() * unit,
        inverse_range_squared: (range * range).recip(),
        direction: forward(transform),
        spot_offset: 1.0,
        ..default()
    }
}

fn directional_light(light: &DirectionalLight, transform: &GlobalTransform) -> Light {
    Light {
        kind: LIGHT_DIRECTIONAL,
        position: Vec3::ZERO,
        inverse_range_squared: 0.0,
        ..light_at(transform, light.color, light.illuminance, 1.0)
    }
}

fn point_light(light: &PointLight, transform: &GlobalTransform) -> Light {
    Light {
        kind: LIGHT_POINT,
        near: near(light.shadow_map_near_z),
        ..light_at(
            transform,
            light.color,
            candela(light.intensity),
            light.range,
        )
    }
}

fn spot_light(light: &SpotLight, transform: &GlobalTransform) -> Light {
    // The cone attenuation of Bevy's spot lights.
    let outer = light.outer_angle.cos();
    let spot_scale = (light.inner_angle.cos() - outer).max(1e-4).recip();
    Light {
        kind: LIGHT_SPOT,
        spot_scale,
        spot_offset: -outer * spot_scale,
        near: near(light.shadow_map_near_z),
        ..light_at(
            transform,
            light.color,
            candela(light.intensity),
            light.range,
        )
    }
}

/// A rectangle that emits to one side, as bright from everywhere.
fn rect_light(light: &RectLight, transform: &GlobalTransform) -> Light {
    let edge = |axis: Vec3, length: f32| transform.affine().transform_vector3(axis * length);
    let (width, height) = (edge(Vec3::X, light.width), edge(Vec3::Y, light.height));
    // As in Bevy, from the power of all of its area over the hemisphere.
    let radiance = light.intensity / (width.length() * height.length() * std::f32::consts::PI);
    Light {
        kind: LIGHT_RECT,
        half_width: 0.5 * width,
        half_height: 0.5 * height,
        ..light_at(transform, light.color, radiance, light.range)
    }
}

/// Luminous intensity of a light of this luminous power in lumens. As in Bevy, the power is spread over
/// the whole sphere, for spot lights too.
fn candela(lumens: f32) -> f32 {
    lumens / (4.0 * std::f32::consts::PI)
}

/// The distance within which nothing shadows a light.
fn near(shadow_map_near_z: f32) -> f32 {
    if shadow_map_near_z.is_finite() {
        shadow_map_near_z.max(0.0)
    } else {
        0.0
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LightTexture {
    pub image: AssetId<Image>,
    pub coverage: TextureCoverage,
    /// The light in the main world.
    pub light: Entity,
}

impl LightTexture {
    /// An order of textures that does not depend on the lights' entities.
    fn order(&self) -> (AssetId<Image>, [u32; 3]) {
        let words = match self.coverage {
            TextureCoverage::Cone => [0; 3],
            TextureCoverage::Tiled => [1, 0, 0],
            TextureCoverage::Single => [2, 0, 0],
            TextureCoverage::Cube(cells) => [3, cells.columns, cells.rows],
        };
        (self.image, words)
    }
}

/// The part of a light's directions or space that its texture covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TextureCoverage {
    /// The square around a cone. A stretched light has a wider cone, where the image goes on as its sampler says.
    Cone,
    /// The plane across the light, again and again.
    Tiled,
    /// A rectangle of that plane, around which there is no light.
    Single,
    Cube(CubeCells),
}

/// The places of a cube's faces in an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct CubeCells {
    /// Columns and rows of cells.
    pub grid: UVec2,
    /// The column of each face, four bits each: +X in the lowest, then -X, +Y, -Y, -Z and +Z.
    pub columns: u32,
    /// The same of rows.
    pub rows: u32,
    pub faces: u32,
}

impl CubeCells {
    /// An image that is one face.
    pub(crate) const ONE: Self = Self {
        grid: UVec2::ONE,
        columns: 0,
        rows: 0,
        faces: 1,
    };

    fn of(layout: CubemapLayout) -> Self {
        // The cells of Bevy's shader. It has -Z and +Z of crosses the other way round than `CubemapLayout` says.
        let (grid, columns, rows) = match layout {
            CubemapLayout::CrossVertical => (UVec2::new(3, 4), 0x11_1102, 0x13_2011),
            CubemapLayout::CrossHorizontal => (UVec2::new(4, 3), 0x13_1102, 0x11_2011),
            CubemapLayout::SequenceVertical => (UVec2::new(1, 6), 0, 0x54_3210),
            CubemapLayout::SequenceHorizontal => (UVec2::new(6, 1), 0x54_3210, 0),
        };
        Self {
            grid,
            columns,
            rows,
            faces: 6,
        }
    }
}

type Textured<T, L = ()> = (&'static T, L, &'static GlobalTransform);

#[derive(SystemParam)]
pub(crate) struct LightTextures<'w, 's> {
    directional: Extract<'w, 's, Query<'static, 'static, Textured<DirectionalLightTexture>>>,
    points: Extract<'w, 's, Query<'static, 'static, Textured<PointLightTexture>>>,
    spots: Extract<'w, 's, Query<'static, 'static, Textured<SpotLightTexture, &'static SpotLight>>>,
}

impl LightTextures<'_, '_> {
    /// The texture of a light, whose projection is written into it.
    fn project(&self, entity: Entity, light: &mut Light) -> Option<LightTexture> {
        let (image, coverage) = match light.kind {
            LIGHT_DIRECTIONAL => {
                let (texture, (), transform) = self.directional.get(entity).ok()?;
                project_plane(transform, light);
                let coverage = if texture.tiled {
                    TextureCoverage::Tiled
                } else {
                    TextureCoverage::Single
                };
                (&texture.image, coverage)
            }
            LIGHT_POINT => {
                let (texture, (), transform) = self.points.get(entity).ok()?;
                project_cube(transform, light);
                let cells = CubeCells::of(texture.cubemap_layout);
                (&texture.image, TextureCoverage::Cube(cells))
            }
            LIGHT_SPOT => {
                let (texture, spot, transform) = self.spots.get(entity).ok()?;
                project_cone(transform, spot.outer_angle, light);
                (&texture.image, TextureCoverage::Cone)
            }
            _ => return None,
        };
        Some(LightTexture {
            image: image.id(),
            coverage,
            light: entity,
        })
    }
}

/// The rows of the matrix from world space to that of a light.
fn rows(transform: &GlobalTransform) -> [Vec3; 3] {
    let Affine3A { matrix3, .. } = transform.affine().inverse();
    let rows = matrix3.transpose();
    [rows.x_axis, rows.y_axis, rows.z_axis].map(Vec3::from)
}

/// Coordinates grow by one over two units of the light's space.
fn project_plane(transform: &GlobalTransform, light: &mut Light) {
    let [x, y, _] = rows(transform);
    light.position = transform.translation();
    (light.half_width, light.half_height) = (-0.5 * x, 0.5 * y);
}

fn project_cube(transform: &GlobalTransform, light: &mut Light) {
    [light.half_width, light.half_height, light.direction] = rows(transform);
}

/// Coordinates grow by one from edge to edge of the cone.
fn project_cone(transform: &GlobalTransform, outer_angle: f32, light: &mut Light) {
    let [x, y, _] = rows(transform);
    // The shader divides by the distance along the cone's axis, in metres.
    let scale = 0.5 * transform.affine().matrix3.z_axis.length() / outer_angle.tan();
    (light.half_width, light.half_height) = (scale * x, -scale * y);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lumens_and_cones_are_bevys() {
        let transform = GlobalTransform::from_xyz(1.0, 2.0, 3.0);
        let light = PointLight {
            intensity: 4.0 * std::f32::consts::PI,
            range: 10.0,
            ..default()
        };
        let point = point_light(&light, &transform);
        assert!((point.color - Vec3::ONE).abs().max_element() < 1e-6);
        assert!((point.inverse_range_squared - 0.01).abs() < 1e-8);
        let light = SpotLight {
            inner_angle: 0.3,
            outer_angle: 0.6,
            ..default()
        };
        let spot = spot_light(&light, &transform);
        let cone = |angle: f32| angle.cos() * spot.spot_scale + spot.spot_offset;
        assert!(cone(0.6).abs() < 1e-4);
        assert!((cone(0.3) - 1.0).abs() < 1e-4);
        assert_eq!(spot.direction, Vec3::NEG_Z);
    }

    #[test]
    fn a_light_under_zero_scale_is_none_and_others_point_where_bevys_do() {
        let transform = Transform::from_xyz(1.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
        let scaled = GlobalTransform::from(transform.with_scale(Vec3::splat(0.1)));
        assert!(forward(&scaled).distance(*scaled.forward()) < 1e-6);
        let flat = GlobalTransform::from(transform.with_scale(Vec3::ZERO));
        assert_eq!(spot_light(&default(), &flat).direction, Vec3::ZERO);
        assert_eq!(directional_light(&default(), &flat).direction, Vec3::ZERO);
    }

    #[test]
    fn lights_reach_as_far_as_their_range() {
        let level = PlacedLevel::of(Vec3::X, 4.0);
        let at = |x: f32, y: f32| {
            let light = PointLight {
                range: 5.0,
                ..default()
            };
            point_light(&light, &GlobalTransform::from_xyz(x, y, 0.0))
        };
        assert!(reaches(&at(1.0, 0.0), &level) && reaches(&at(7.9, 0.0), &level));
        assert!(!reaches(&at(8.1, 0.0), &level));
        // Three and four metres from the edge.
        assert!(reaches(&at(5.9, 6.0), &level) && !reaches(&at(6.1, 6.0), &level));
        let sun = directional_light(&default(), &GlobalTransform::from_xyz(1e6, 0.0, 0.0));
        assert!(reaches(&sun, &level));
    }

    #[test]
    fn a_rectangle_spreads_its_power_over_its_scaled_area() {
        let light = RectLight {
            intensity: 12.0 * std::f32::consts::PI,
            width: 1.0,
            height: 2.0,
            ..default()
        };
        let transform = Transform::from_scale(Vec3::new(3.0, 1.0, 1.0)).into();
        let rect = rect_light(&light, &transform);
        assert!((rect.color - Vec3::splat(2.0)).abs().max_element() < 1e-5);
        assert_eq!(
            (rect.half_width, rect.half_height),
            (Vec3::X * 1.5, Vec3::Y)
        );
    }

    const AT: Vec3 = Vec3::new(1.0, 2.0, 3.0);

    fn transform() -> GlobalTransform {
        let rotation = Quat::from_euler(EulerRot::YXZ, 0.4, -1.1, 0.7);
        let transform = Transform::from_translation(AT).with_rotation(rotation);
        transform.with_scale(Vec3::new(2.0, 3.0, 0.5)).into()
    }

    fn local(transform: &GlobalTransform, point: Vec3) -> Vec3 {
        transform.affine().inverse().transform_point3(point)
    }

    fn assert_near(found: Vec2, expected: Vec2) {
        assert!(found.distance(expected) < 1e-4, "{found} for {expected}");
    }

    #[test]
    fn a_plane_is_projected_as_in_bevy() {
        let transform = transform();
        let mut light = Light::default();
        project_plane(&transform, &mut light);
        for point in [AT, Vec3::ZERO, Vec3::new(-3.0, 5.0, 1.0)] {
            let to = point - light.position;
            let found = 0.5 + Vec2::new(light.half_width.dot(to), light.half_height.dot(to));
            let expected = local(&transform, point).truncate() * Vec2::new(-0.5, 0.5) + 0.5;
            assert_near(found, expected);
        }
    }

    #[test]
    fn a_cone_is_projected_as_in_bevy() {
        let transform = transform();
        let mut light = Light {
            position: AT,
            direction: transform.forward().into(),
            ..default()
        };
        project_cone(&transform, 0.6, &mut light);
        for around in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.3, 0.2, -1.0)] {
            let point = AT + 3.0 * light.direction + around;
            let to = point - light.position;
            let across = Vec2::new(light.half_width.dot(to), light.half_height.dot(to));
            let found = 0.5 + across / light.direction.dot(to);
            let local = local(&transform, point);
            let tangent = 0.6_f32.tan();
            let expected = local.truncate() / (local.z * tangent) * Vec2::new(-0.5, 0.5) + 0.5;
            assert_near(found, expected);
        }
    }

    #[test]
    fn cells_of_faces_are_those_of_bevys_shader() {
        let cell = |layout, face: u32| {
            let cells = CubeCells::of(layout);
            [cells.columns, cells.rows].map(|word| word >> (4 * face) & 0xF)
        };
        // +X, -X, +Y, -Y, -Z, +Z.
        for (layout, expected) in [
            (
                CubemapLayout::CrossVertical,
                [[2, 1], [0, 1], [1, 0], [1, 2], [1, 3], [1, 1]],
            ),
            (
                CubemapLayout::CrossHorizontal,
                [[2, 1], [0, 1], [1, 0], [1, 2], [3, 1], [1, 1]],
            ),
            (
                CubemapLayout::SequenceVertical,
                [[0, 0], [0, 1], [0, 2], [0, 3], [0, 4], [0, 5]],
            ),
            (
                CubemapLayout::SequenceHorizontal,
                [[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [5, 0]],
            ),
        ] {
            let found = [0, 1, 2, 3, 4, 5].map(|face| cell(layout, face));
            assert_eq!(found, expected, "{layout:?}");
        }
    }
}
