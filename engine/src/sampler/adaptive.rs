//! As many samples a pixel as it needs: those where little changes from sample to sample get few.

use glam::Vec3;

use super::fill::{fill, keep};
use super::film::Sum;
use super::filter::Filter;
use super::morton::for_each_piece;
use super::sobol::{Place, at_pixels};
use crate::color::to_pixel;
use crate::image::FrameBuffer;
use crate::packet::{Column, Packet, vec3};
use crate::scratch::lend;
use crate::stack::{Camera, Context, Fragment, PixelSampler};

/// The samples of [`Sobol`](super::Sobol), in blocks of [`BLOCK`](Self::BLOCK): after each block a pixel has enough of them if the standard
/// error of its mean, as if samples were independent, is below a threshold in all three colours, or there are as many as may be
/// (after Lee, Redner and Uselton, "Statistically Optimized Sampling for Distributed Ray Tracing", SIGGRAPH 1985). That depends on the
/// pixel's own samples alone, so the picture does not depend on tiles, packet width or threads.
#[derive(Clone, Debug)]
pub struct Adaptive {
    most: u32,
    threshold: f32,
    filter: Filter,
}

/// So many pixels are sampled together: enough to fill packets when few of them go on.
const PIXELS: usize = 64;

impl Adaptive {
    /// After so many samples it is decided whether more are needed.
    pub const BLOCK: u32 = 16;

    /// At most so many samples, rounded up to whole blocks; `threshold` is in linear light.
    pub fn new(most: u32, threshold: f32, filter: Filter) -> Self {
        Self { most: most.max(1).div_ceil(Self::BLOCK) * Self::BLOCK, threshold, filter }
    }
}

/// A pixel that is not finished.
#[derive(Clone, Copy, Default)]
struct Pixel {
    at: [u32; 2],
    sum: Sum,
    squares: Vec3,
    count: f32,
}

impl Pixel {
    fn add(&mut self, color: Vec3, weight: f32) {
        self.sum.add(color, weight);
        self.squares += color * color;
        self.count += 1.0;
    }

    /// Is the error of the mean below the threshold?
    fn is_enough(&self, threshold: f32) -> bool {
        let mean = self.sum.plain() / self.count;
        // Of the mean: the variance of the samples over their number; one less, because the mean is theirs.
        let variance = (self.squares / self.count - mean * mean).max(Vec3::ZERO) / (self.count - 1.0);
        variance.max_element() <= threshold * threshold
    }
}

impl PixelSampler for Adaptive {
    fn render_fragment(&self, context: &Context<'_>, camera: &dyn Camera, fragment: Fragment, out: &FrameBuffer) {
        let size = [out.width() as u32, out.height() as u32];
        let block = Self::BLOCK as usize;
        let first_number = context.frame.wrapping_mul(self.most);
        // As if no block followed the first.
        let cone = 1.0 / (Self::BLOCK as f32).sqrt();
        let packet: &mut Packet = &mut lend(context.width);
        let weights: &mut Column<f32> = &mut lend(context.width);
        for_each_piece(fragment, PIXELS, |pixels| {
            let mut all = [Pixel::default(); PIXELS];
            let all = &mut all[..pixels.len()];
            all.iter_mut().zip(pixels).for_each(|(pixel, &at)| pixel.at = at);
            let mut active = all.len();
            for start in (0..self.most).step_by(block) {
                let rays = active * block;
                for first in (0..rays).step_by(context.width) {
                    let count = context.width.min(rays - first);
                    packet.reset(count);
                    packet.channel = fragment.channel as u32;
                    let sample = |i: usize| {
                        let number = start + ((first + i) % block) as u32;
                        (all[(first + i) / block].at, first_number.wrapping_add(number))
                    };
                    at_pixels(packet, sample);
                    let Packet { image, samples: [seeds, numbers], .. } = packet;
                    context.token.run(Place { seeds, numbers, image, count });
                    self.filter.spread(image, &mut weights[..count]);
                    camera.make_rays(context, size, packet);
                    packet.scale_cones(cone);
                    context.renderer.trace(context, packet);
                    for i in 0..count {
                        all[(first + i) / block].add(vec3(&packet.color, i), weights[i]);
                    }
                }
                // Those that need more go on, in their order.
                let last = start + Self::BLOCK >= self.most;
                let mut more = 0;
                for k in 0..active {
                    let pixel = all[k];
                    if last || pixel.is_enough(self.threshold) {
                        let mean = pixel.sum.mean();
                        if let Some(layers) = out.layers() {
                            keep(layers, pixel.at, mean);
                        }
                        fill(out, &fragment, pixel.at, to_pixel(context.tone.of(mean)));
                    } else {
                        all[more] = pixel;
                        more += 1;
                    }
                }
                active = more;
                if active == 0 {
                    break;
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_is_enough_when_its_mean_is_known() {
        let mut even = Pixel::default();
        (0..16).for_each(|_| even.add(Vec3::splat(0.5), 1.0));
        assert!(even.is_enough(1e-3));
        let mut mixed = Pixel::default();
        (0..16).for_each(|i| mixed.add(Vec3::new(0.5, if i % 2 == 0 { 1.0 } else { 0.0 }, 0.5), 1.0));
        // Deviation 1/2, and the root of 15 samples.
        assert!(!mixed.is_enough(0.128) && mixed.is_enough(0.13));
        let mut broken = Pixel::default();
        (0..16).for_each(|_| broken.add(Vec3::splat(f32::NAN), 1.0));
        broken.is_enough(1e-3);
    }
}
