//! What pictures hold beside their bytes: linear colours, and what is behind each pixel. Render threads fill them through a shared
//! reference, as they do frame buffers.

use std::sync::atomic::{AtomicU32, Ordering};

/// One number of each pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Plane {
    /// Light, linear RGB, before exposure and tone curve: all samples of the pixel.
    Red,
    /// See [`Red`](Self::Red).
    Green,
    /// See [`Red`](Self::Red).
    Blue,
    /// Distance along the ray through the middle of the pixel, as are the following; infinite where nothing is.
    Depth,
    /// Unit shading normal, in coordinates of the scene; 0 where nothing is.
    NormalX,
    /// See [`NormalX`](Self::NormalX).
    NormalY,
    /// See [`NormalX`](Self::NormalX).
    NormalZ,
    /// Colour of the surface, unlit; 0 where nothing is.
    AlbedoRed,
    /// See [`AlbedoRed`](Self::AlbedoRed).
    AlbedoGreen,
    /// See [`AlbedoRed`](Self::AlbedoRed).
    AlbedoBlue,
    /// Number of the geometry; [`NOTHING`] where nothing is.
    Geometry,
    /// Number of the primitive in it; [`NOTHING`] where nothing is.
    Primitive,
    /// Number of the material; [`NOTHING`] where nothing is.
    Material,
}

/// The number of what is not there.
pub const NOTHING: u32 = u32::MAX;

/// Number of planes.
const COUNT: usize = Plane::Material as usize + 1;

/// All planes of a picture. Numbers are relaxed atomics, for the reasons that frame buffers have.
#[derive(Debug)]
pub struct Layers {
    width: usize,
    pixels: usize,
    bits: Box<[AtomicU32]>,
}

impl Layers {
    /// Zeros for a picture of this size; `None` where there is no memory for it.
    pub fn new(width: usize, height: usize) -> Option<Self> {
        let pixels = width.checked_mul(height)?;
        let count = pixels.checked_mul(COUNT)?;
        let mut bits = Vec::new();
        bits.try_reserve_exact(count).ok()?;
        bits.extend((0..count).map(|_| AtomicU32::new(0)));
        Some(Self { width, pixels, bits: bits.into_boxed_slice() })
    }

    #[inline]
    fn at(&self, plane: Plane, x: usize, y: usize) -> &AtomicU32 {
        assert!(x < self.width, "column {x} is outside a picture {} wide", self.width);
        &self.plane(plane)[y * self.width + x]
    }

    fn plane(&self, plane: Plane) -> &[AtomicU32] {
        &self.bits[plane as usize * self.pixels..][..self.pixels]
    }

    /// Writes numbers of one pixel to some planes.
    ///
    /// # Panics
    /// When it does not lie inside the picture.
    #[inline]
    pub fn set<const N: usize>(&self, planes: [Plane; N], x: usize, y: usize, numbers: [f32; N]) {
        for (plane, number) in planes.into_iter().zip(numbers) {
            // Relaxed: ordered before the display by the pipeline's barrier.
            self.at(plane, x, y).store(number.to_bits(), Ordering::Relaxed);
        }
    }

    /// As [`set`](Self::set), for whole numbers.
    ///
    /// # Panics
    /// When it does not lie inside the picture.
    #[inline]
    pub fn set_whole<const N: usize>(&self, planes: [Plane; N], x: usize, y: usize, numbers: [u32; N]) {
        for (plane, number) in planes.into_iter().zip(numbers) {
            self.at(plane, x, y).store(number, Ordering::Relaxed);
        }
    }

    /// The numbers of a plane, row by row from the top.
    pub fn numbers(&self, plane: Plane) -> Vec<f32> {
        self.plane(plane).iter().map(|bits| f32::from_bits(bits.load(Ordering::Relaxed))).collect()
    }

    /// As [`numbers`](Self::numbers), of a plane of whole numbers.
    pub fn whole_numbers(&self, plane: Plane) -> Vec<u32> {
        self.plane(plane).iter().map(|bits| bits.load(Ordering::Relaxed)).collect()
    }

    /// Copies the rectangle `x0..x1` by `y0..y1` from the planes of another picture, as far as both have it.
    pub fn copy_from(&self, other: &Self, x0: usize, y0: usize, x1: usize, y1: usize) {
        let height = |layers: &Self| layers.pixels.checked_div(layers.width).unwrap_or(0);
        let (x1, y1) = (x1.min(self.width).min(other.width), y1.min(height(self)).min(height(other)));
        for plane in 0..COUNT {
            for y in y0..y1 {
                for x in x0..x1 {
                    let bits = other.bits[plane * other.pixels + y * other.width + x].load(Ordering::Relaxed);
                    self.bits[plane * self.pixels + y * self.width + x].store(bits, Ordering::Relaxed);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_land_in_their_planes() {
        let layers = Layers::new(3, 2).unwrap();
        layers.set([Plane::Depth, Plane::Red], 2, 1, [7.5, 0.25]);
        layers.set_whole([Plane::Material], 0, 0, [NOTHING]);
        assert_eq!(layers.numbers(Plane::Depth), [0.0, 0.0, 0.0, 0.0, 0.0, 7.5]);
        assert_eq!(layers.numbers(Plane::Red)[5], 0.25);
        assert_eq!(layers.whole_numbers(Plane::Material)[0], NOTHING);
        let copy = Layers::new(2, 2).unwrap();
        copy.copy_from(&layers, 0, 0, 9, 9);
        assert_eq!(copy.whole_numbers(Plane::Material), [NOTHING, 0, 0, 0]);
    }

    #[test]
    #[should_panic(expected = "outside a picture 3 wide")]
    fn a_pixel_outside_is_refused() {
        Layers::new(3, 2).unwrap().set([Plane::Depth], 3, 0, [0.0]);
    }
}
