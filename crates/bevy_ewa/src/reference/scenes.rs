//! Pictures to filter, as functions of a point on the screen: no renderer is needed to know what
//! they should look like.

use std::f64::consts::TAU;

use super::footprint::Derivatives;

/// A surface that fills the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// The inside of a cylinder without end, of radius 1, seen along its axis (thesis figure 5.10).
    Tunnel {
        /// Tangent of half the angle of view.
        half_view: f64,
        /// Textures around it.
        around: f64,
        /// Textures per unit of its length.
        along: f64,
        /// Textures that the eye has moved along it.
        moved: f64,
    },
    /// A plane one unit below the eye.
    Plane {
        /// Angle between the middle of the view and the plane, in radians.
        grazing: f64,
        /// Tangent of half the angle of view; the horizon stays above the picture.
        half_view: f64,
        /// Angle by which the texture is turned, in radians.
        turn: f64,
        /// Textures per unit.
        scale: f64,
        /// Textures that the eye has moved along v.
        moved: f64,
    },
}

impl Surface {
    /// Texture coordinates at a position on the screen, from -1 to 1 to the right and down.
    pub fn uv(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        match *self {
            Self::Tunnel {
                half_view,
                around,
                along,
                moved,
            } => {
                let distance = 1.0 / (x.hypot(y) * half_view).max(1e-9);
                [around * y.atan2(x) / TAU, along * distance + moved]
            }
            Self::Plane {
                grazing,
                half_view,
                turn,
                scale,
                moved,
            } => {
                let (sin, cos) = grazing.sin_cos();
                let down = (sin + y * half_view * cos).max(1e-9);
                let forward = cos - y * half_view * sin;
                let p = [x * half_view / down, forward / down];
                let (sin, cos) = turn.sin_cos();
                [
                    scale * (cos * p[0] - sin * p[1]),
                    scale * (sin * p[0] + cos * p[1]) + moved,
                ]
            }
        }
    }

    /// The surface from further on.
    pub fn moved_by(mut self, textures: f64) -> Self {
        let (Self::Tunnel { moved, .. } | Self::Plane { moved, .. }) = &mut self;
        *moved += textures;
        self
    }

    /// Texture coordinates in the middle of a pixel of a square picture, and their derivatives.
    pub fn pixel(&self, size: u32, [x, y]: [u32; 2]) -> ([f64; 2], Derivatives) {
        const STEP: f64 = 1e-3;
        let at = |dx: f64, dy: f64| self.at(size, [x as f64 + 0.5 + dx, y as f64 + 0.5 + dy]);
        let difference = |a: [f64; 2], b: [f64; 2]| {
            let mut d = [0, 1].map(|i| b[i] - a[i]);
            if let Self::Tunnel { around, .. } = self {
                // Across the seam.
                d[0] -= around * (d[0] / around).round();
            }
            d.map(|d| d / (2.0 * STEP))
        };
        let derivatives = Derivatives {
            dx: difference(at(-STEP, 0.0), at(STEP, 0.0)),
            dy: difference(at(0.0, -STEP), at(0.0, STEP)),
        };
        (at(0.0, 0.0), derivatives)
    }

    /// Texture coordinates at a position in pixels of a square picture.
    pub fn at(&self, size: u32, position: [f64; 2]) -> [f64; 2] {
        self.uv(position.map(|p| 2.0 * p / f64::from(size) - 1.0))
    }
}
