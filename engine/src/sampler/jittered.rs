//! Several samples a pixel, one in each cell of a grid.

use glam::Vec3;

use super::fill::fill;
use super::morton::for_each_piece;
use crate::color::to_pixel;
use crate::image::FrameBuffer;
use crate::math::{hash, unit};
use crate::packet::{Packet, vec3};
use crate::scratch::lend;
use crate::stack::{Camera, Context, Fragment, PixelSampler};

/// Stratified sampling: `side * side` samples a pixel, each somewhere in its cell of a grid. Where depends on pixel,
/// sample and frame only, and the samples of a pixel are added in one order, so the picture does not depend on tiles,
/// packet width or threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Jittered {
    side: u32,
}

impl Jittered {
    /// The most cells along a pixel's side.
    pub const MOST: u32 = 32;

    /// `side * side` samples a pixel; `side` is limited to 1..=32.
    pub fn new(side: u32) -> Self {
        Self { side: side.clamp(1, Self::MOST) }
    }

    /// Image coordinates of a sample of a pixel.
    #[inline(always)]
    fn place(self, [x, y]: [u32; 2], sample: u32, frame: u32) -> [f32; 2] {
        let cell = [sample % self.side, sample / self.side];
        let h = hash(x ^ hash(y ^ hash(sample ^ hash(frame.wrapping_add(0x9e37_79b9)))));
        let jitter = [unit(h), unit(hash(h))];
        let at = |pixel: u32, axis: usize| pixel as f32 + (cell[axis] as f32 + jitter[axis]) / self.side as f32;
        [at(x, 0), at(y, 1)]
    }
}

impl PixelSampler for Jittered {
    fn render_fragment(&self, context: &Context<'_>, camera: &dyn Camera, fragment: Fragment, out: &FrameBuffer) {
        let size = [out.width() as u32, out.height() as u32];
        let samples = (self.side * self.side) as usize;
        let width = context.width;
        let packet: &mut Packet = &mut lend(width);
        // As many whole pixels as fit into a packet; where not even one does, one pixel in several packets.
        for_each_piece(fragment, width / samples, |pixels| {
            let mut sum = Vec3::ZERO;
            for first in (0..pixels.len() * samples).step_by(width) {
                let count = width.min(pixels.len() * samples - first);
                packet.reset(count);
                packet.channel = fragment.channel as u32;
                for i in 0..count {
                    let (pixel, sample) = ((first + i) / samples, (first + i) % samples);
                    let [x, y] = self.place(pixels[pixel], sample as u32, context.frame);
                    packet.image[0][i] = x;
                    packet.image[1][i] = y;
                }
                camera.make_rays(context, size, packet);
                context.renderer.trace(context, packet);
                for i in 0..count {
                    sum += vec3(&packet.color, i);
                    if (first + i + 1).is_multiple_of(samples) {
                        let pixel = pixels[(first + i) / samples];
                        fill(out, &fragment, pixel, to_pixel(sum / samples as f32));
                        sum = Vec3::ZERO;
                    }
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_stay_in_their_cells_and_differ() {
        let sampler = Jittered::new(4);
        let mut seen = std::collections::HashSet::new();
        for frame in 0..3 {
            for sample in 0..16 {
                let [x, y] = sampler.place([10, 20], sample, frame);
                assert_eq!((x - 10.0) * 4.0 % 4.0, (x - 10.0) * 4.0);
                assert_eq!(((x - 10.0) * 4.0) as u32, sample % 4);
                assert_eq!(((y - 20.0) * 4.0) as u32, sample / 4);
                assert!(seen.insert((x.to_bits(), y.to_bits())));
            }
        }
    }
}
