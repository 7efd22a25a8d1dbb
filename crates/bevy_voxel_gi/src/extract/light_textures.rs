//! The textures of lights, and how lights project them: as Bevy's `pbr_lighting.wesl` does.

use bevy::{
    camera::primitives::CubemapLayout,
    ecs::system::SystemParam,
    light::{DirectionalLightTexture, PointLightTexture, SpotLightTexture},
    math::Affine3A,
    prelude::*,
    render::Extract,
};

use crate::gpu_types::{LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_SPOT, Light};

/// The texture of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LightTexture {
    pub image: AssetId<Image>,
    pub coverage: TextureCoverage,
    /// The light in the main world.
    pub light: Entity,
}

impl LightTexture {
    /// An order of textures that does not depend on the lights' entities.
    pub(super) fn order(&self) -> (AssetId<Image>, [u32; 3]) {
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
    /// All directions.
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
    /// Number of faces.
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

/// The lights with textures.
#[derive(SystemParam)]
pub(crate) struct LightTextures<'w, 's> {
    directional: Extract<
        'w,
        's,
        Query<'static, 'static, (&'static DirectionalLightTexture, &'static GlobalTransform)>,
    >,
    points: Extract<
        'w,
        's,
        Query<'static, 'static, (&'static PointLightTexture, &'static GlobalTransform)>,
    >,
    spots: Extract<
        'w,
        's,
        Query<
            'static,
            'static,
            (
                &'static SpotLightTexture,
                &'static SpotLight,
                &'static GlobalTransform,
            ),
        >,
    >,
}

impl LightTextures<'_, '_> {
    /// The texture of a light, whose projection is written into it.
    pub(super) fn project(&self, entity: Entity, light: &mut Light) -> Option<LightTexture> {
        let (image, coverage) = match light.kind {
            LIGHT_DIRECTIONAL => {
                let (texture, transform) = self.directional.get(entity).ok()?;
                project_plane(transform, light);
                let coverage = if texture.tiled {
                    TextureCoverage::Tiled
                } else {
                    TextureCoverage::Single
                };
                (&texture.image, coverage)
            }
            LIGHT_POINT => {
                let (texture, transform) = self.points.get(entity).ok()?;
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
