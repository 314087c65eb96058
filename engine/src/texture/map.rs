//! A texture, and how it lies on a surface.

use std::sync::Arc;

use glam::Vec4;

use super::pyramid::{Texture, Wrap};

/// A texture on a surface: the surface's texture coordinates `(u, v)` are multiplied by `turn` and moved by `offset` to places on the
/// texture, whose lower left corner is (0, 0), and the upper right one (1, 1).
#[derive(Clone, Debug)]
pub struct Map {
    /// What lies there.
    pub texture: Arc<Texture>,
    /// How it goes on beyond its borders, across and up.
    pub wrap: [Wrap; 2],
    /// The rows of a matrix.
    pub turn: [[f32; 2]; 2],
    /// A place on the texture.
    pub offset: [f32; 2],
}

/// The same texture object, in the same way.
impl PartialEq for Map {
    fn eq(&self, other: &Self) -> bool {
        let way = |map: &Self| (map.wrap, map.turn, map.offset);
        Arc::ptr_eq(&self.texture, &other.texture) && way(self) == way(other)
    }
}

impl Map {
    /// A texture that repeats, once for each unit of the texture coordinates.
    pub fn new(texture: Arc<Texture>) -> Self {
        Self { texture, wrap: [Wrap::Repeat; 2], turn: [[1.0, 0.0], [0.0, 1.0]], offset: [0.0; 2] }
    }

    /// What is seen at texture coordinates, through a footprint that covers so much area of them: linear RGB and alpha.
    #[inline]
    pub fn sample(&self, [u, v]: [f32; 2], area: f32) -> Vec4 {
        let [[a, b], [c, d]] = self.turn;
        let place = [a * u + b * v + self.offset[0], c * u + d * v + self.offset[1]];
        self.texture.sample(place, area * (a * d - b * c).abs(), self.wrap)
    }
}
