//! The layout of a lightmap: a rectangle for each face of each box.

use bevy::{math::UVec2, prelude::*};
use bevy_frugal_lab::boxes::{BoxScene, SceneBox};

/// Edge of a texel in metres, at most.
const TEXEL: f32 = 0.05;
/// Texels around the rectangle of a face that repeat its edge, so that no filter reads another face.
pub const BORDER: u32 = 1;

/// The rectangles of all faces: six for each box of the scene, in its order.
pub struct Atlas {
    /// Size in texels.
    pub size: UVec2,
    /// The face with number `n` of box `i` is at `6 * i + n`.
    pub faces: Vec<Face>,
}

/// A face of a box and its rectangle.
#[derive(Clone, Copy)]
pub struct Face {
    /// The corner of the rectangle, without its border.
    pub corner: UVec2,
    /// Texels along both axes, without the border.
    pub texels: UVec2,
    /// The corner of the face in which both `edges` begin, in metres.
    origin: Vec3,
    edges: [Vec3; 2],
    /// A unit vector.
    pub normal: Vec3,
}

impl Face {
    /// A face; the number of one of a box is twice its axis, and one more on the negative side.
    fn new(part: &SceneBox, number: usize) -> Self {
        let (axis, u, v) = axes(number);
        let rotation = part.rotation();
        let along = |axis: usize| Vec3::AXES[axis] * part.half[axis];
        let is_negative = !number.is_multiple_of(2);
        let normal = if is_negative { -1.0 } else { 1.0 } * Vec3::AXES[axis];
        let from_center = part.half[axis] * normal - along(u) - along(v);
        let texels = |axis: usize| (2.0 * part.half[axis] / TEXEL).ceil() as u32;
        Self {
            corner: UVec2::ZERO,
            texels: UVec2::new(texels(u), texels(v)).max(UVec2::ONE),
            origin: part.center + rotation * from_center,
            edges: [rotation * (2.0 * along(u)), rotation * (2.0 * along(v))],
            normal: rotation * normal,
        }
    }

    /// A point of the face, in metres, from one of its rectangle in texels.
    pub fn position(&self, at: Vec2) -> Vec3 {
        let at = at / self.texels.as_vec2();
        self.origin + at.x * self.edges[0] + at.y * self.edges[1]
    }
}

/// The axis of a face's normal, and those of its rectangle.
fn axes(number: usize) -> (usize, usize, usize) {
    let axis = number / 2;
    (axis, (axis + 1) % 3, (axis + 2) % 3)
}

impl Atlas {
    /// Packs the faces into rows as wide as a square of all would be, the highest ones first.
    pub fn new(scene: &BoxScene) -> Self {
        let faces = scene
            .boxes
            .iter()
            .flat_map(|part| (0..6).map(|number| Face::new(part, number)));
        let mut faces: Vec<_> = faces.collect();
        let with_border = |face: &Face| face.texels + 2 * BORDER;
        let area: u32 = faces
            .iter()
            .map(|face| with_border(face).element_product())
            .sum();
        let widest = faces.iter().map(|face| with_border(face).x).max();
        let width = ((area as f32).sqrt().ceil() as u32).max(widest.unwrap_or_default());
        let mut order: Vec<_> = (0..faces.len()).collect();
        order.sort_by_key(|&i| std::cmp::Reverse(faces[i].texels.y));
        let (mut at, mut height) = (UVec2::ZERO, 0);
        for i in order {
            let size = with_border(&faces[i]);
            if at.x + size.x > width {
                at = UVec2::new(0, height);
            }
            faces[i].corner = at + BORDER;
            at.x += size.x;
            height = height.max(at.y + size.y);
        }
        Self {
            size: UVec2::new(width, height),
            faces,
        }
    }

    /// The mesh of a box, whose corners are 1 from its centre along each axis, with texture coordinates of the
    /// atlas.
    pub fn mesh(&self, part: usize) -> Mesh {
        let mesh = Cuboid::from_size(Vec3::splat(2.0)).mesh().build();
        let vectors = |attribute| {
            let values = mesh
                .attribute(attribute)
                .and_then(|values| values.as_float3());
            values
                .expect("vectors of three floats")
                .iter()
                .map(|&v| Vec3::from(v))
        };
        let vertices = vectors(Mesh::ATTRIBUTE_POSITION).zip(vectors(Mesh::ATTRIBUTE_NORMAL));
        let uvs = vertices.map(|(position, normal)| self.uv(part, position, normal).to_array());
        let uvs: Vec<_> = uvs.collect();
        mesh.with_inserted_attribute(Mesh::ATTRIBUTE_UV_1, uvs)
    }

    fn uv(&self, part: usize, corner: Vec3, normal: Vec3) -> Vec2 {
        let axis = normal.abs().max_position();
        let number = 2 * axis + usize::from(normal[axis] < 0.0);
        let (_, u, v) = axes(number);
        let face = self.faces[6 * part + number];
        let at = 0.5 * Vec2::new(corner[u], corner[v]) + 0.5;
        (face.corner.as_vec2() + at * face.texels.as_vec2()) / self.size.as_vec2()
    }
}
