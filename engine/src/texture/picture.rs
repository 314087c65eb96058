//! Pictures as files have them: rows of texels, from the upper left corner.

use std::fmt;

use glam::{Vec3, Vec4};

use crate::color::from_srgb8;

/// A decoded picture: its first row is the upper one.
#[derive(Clone, PartialEq)]
pub struct Picture {
    size: [u32; 2],
    texels: Texels,
}

/// The numbers of a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// Red, green, blue and alpha from 0 to 255, as files have them: what they stand for depends on what the picture is for.
    Bytes(Vec<[u8; 4]>),
    /// Red, green, blue and alpha, linear in light, without an upper end.
    Floats(Vec<[f32; 4]>),
}

impl Texels {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Bytes(texels) => texels.len(),
            Self::Floats(texels) => texels.len(),
        }
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Picture {
    /// The most texels along a side.
    pub const MOST: u32 = 1 << 15;

    /// A picture, if there are as many texels as its size says, and no side is 0 or above [`MOST`](Self::MOST).
    pub fn new(size: [u32; 2], texels: Texels) -> Option<Self> {
        let sound = size.iter().all(|side| (1..=Self::MOST).contains(side));
        (sound && texels.len() == size[0] as usize * size[1] as usize).then_some(Self { size, texels })
    }

    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Its numbers, by rows.
    pub fn texels(&self) -> &Texels {
        &self.texels
    }

    /// Its numbers, by rows.
    pub fn into_texels(self) -> Texels {
        self.texels
    }

    /// The colours, linear RGB, by rows: bytes are taken to be on the sRGB curve, and what is not finite or below 0 as 0.
    pub fn colors(&self) -> Vec<Vec3> {
        let sound = |x: f32| if x.is_finite() { x.max(0.0) } else { 0.0 };
        match &self.texels {
            Texels::Bytes(texels) => texels.iter().map(|&[r, g, b, _]| from_srgb8([r, g, b])).collect(),
            Texels::Floats(texels) => {
                texels.iter().map(|&[r, g, b, _]| Vec3::new(sound(r), sound(g), sound(b))).collect()
            }
        }
    }

    /// Is any texel not opaque?
    pub fn has_alpha(&self) -> bool {
        match &self.texels {
            Texels::Bytes(texels) => texels.iter().any(|texel| texel[3] < 255),
            Texels::Floats(texels) => texels.iter().any(|&texel| Vec4::from(texel).w < 1.0),
        }
    }
}

impl fmt::Debug for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Picture").field("size", &self.size).finish_non_exhaustive()
    }
}
