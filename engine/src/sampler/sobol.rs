//! Several samples a pixel, spread evenly over it and a filter around it.

use std::sync::Arc;

use mobula_core::simd::{F32Lanes, Task, Token};

use super::fill::{fill, keep};
use super::film::{Film, Sum};
use super::filter::Filter;
use super::morton::for_each_piece;
use super::pixel_seed;
use crate::color::to_pixel;
use crate::image::FrameBuffer;
use crate::packet::{Column, Packet, vec3};
use crate::scratch::lend;
use crate::sequence::{Set, point};
use crate::stack::{Camera, Context, Fragment, PixelSampler};

/// So many samples a pixel, at the points of a sequence of its own for each pixel (Sobol, scrambled), as often where the filter is high
/// as it is (Ernst, Stamminger and Greiner, "Filter Importance Sampling", 2006). Where depends on pixel, sample and frame only, and the
/// samples of a pixel are added in one order, so the picture does not depend on tiles, packet width or threads. Frames go on with the
/// sequence, and may add to what earlier ones have left on a film.
#[derive(Clone, Debug)]
pub struct Sobol {
    samples: u32,
    filter: Filter,
    film: Option<Arc<Film>>,
    /// Is the mean shown?
    shows: bool,
}

impl Sobol {
    /// The most samples a pixel.
    pub const MOST: u32 = 1 << 16;

    /// `samples` a pixel, 1 to [`MOST`](Self::MOST), which it is limited to.
    pub fn new(samples: u32, filter: Filter) -> Self {
        Self { samples: samples.clamp(1, Self::MOST), filter, film: None, shows: true }
    }

    /// One sample a pixel and frame, added to those of the frames before, from frame 0 on. What is shown is the mean of all; or if not
    /// `shows`, nothing is, and the picture stays as it is. Fragments must have a step of 1.
    pub fn onto(film: Arc<Film>, shows: bool) -> Self {
        Self { samples: 1, filter: film.filter(), film: Some(film), shows }
    }
}

impl PixelSampler for Sobol {
    fn render_fragment(&self, context: &Context<'_>, camera: &dyn Camera, fragment: Fragment, out: &FrameBuffer) {
        let size = [out.width() as u32, out.height() as u32];
        let samples = self.samples as usize;
        let first_number = context.frame.wrapping_mul(self.samples);
        let width = context.width;
        // Each sample stands for its part of the pixel's area.
        let cone = 1.0 / (samples as f32).sqrt();
        let packet: &mut Packet = &mut lend(width);
        let weights: &mut Column<f32> = &mut lend(width);
        // As many whole pixels as fit into a packet; where not even one does, one pixel in several packets.
        for_each_piece(fragment, width / samples, |pixels| {
            let so_far =
                |pixel: [u32; 2]| self.film.as_ref().map_or(Sum::default(), |film| film.sum(pixel, first_number));
            let mut sum = so_far(pixels[0]);
            for first in (0..pixels.len() * samples).step_by(width) {
                let count = width.min(pixels.len() * samples - first);
                packet.reset(count);
                packet.channel = fragment.channel as u32;
                let number = |i: usize| first_number.wrapping_add(((first + i) % samples) as u32);
                at_pixels(packet, |i| (pixels[(first + i) / samples], number(i)));
                let Packet { image, samples: [seeds, numbers], .. } = packet;
                context.token.run(Place { seeds, numbers, image, count });
                self.filter.spread(image, &mut weights[..count]);
                camera.make_rays(context, size, packet);
                packet.scale_cones(cone);
                context.renderer.trace(context, packet);
                for i in 0..count {
                    sum.add(vec3(&packet.color, i), weights[i]);
                    if (first + i + 1).is_multiple_of(samples) {
                        let pixel = pixels[(first + i) / samples];
                        if self.shows {
                            let mean = sum.mean();
                            if let Some(layers) = out.layers() {
                                keep(layers, pixel, mean);
                            }
                            fill(out, &fragment, pixel, to_pixel(context.tone.of(mean)));
                        }
                        if let Some(film) = &self.film {
                            film.keep(pixel, &sum);
                        }
                        sum = pixels.get((first + i) / samples + 1).map_or(Sum::default(), |&next| so_far(next));
                    }
                }
            }
        });
    }
}

/// Makes the rays of a packet samples of pixels, with their numbers; image coordinates are those of the pixels' corners.
pub(super) fn at_pixels(packet: &mut Packet, of: impl Fn(usize) -> ([u32; 2], u32)) {
    for i in 0..packet.len() {
        let (pixel, number) = of(i);
        (packet.samples[0][i], packet.samples[1][i]) = (pixel_seed(pixel), number);
        (packet.image[0][i], packet.image[1][i]) = (pixel[0] as f32, pixel[1] as f32);
    }
}

/// Moves image coordinates from the corners of pixels to where their samples are in them.
pub(super) struct Place<'a> {
    pub(super) seeds: &'a [u32],
    pub(super) numbers: &'a [u32],
    pub(super) image: &'a mut [Column<f32>; 2],
    pub(super) count: usize,
}

impl Task for Place<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { seeds, numbers, image: [x, y], count } = self;
        for at in (0..count).step_by(T::LANES) {
            let [u, v] = point(token, token.load_u32(seeds, at), token.load_u32(numbers, at), Set::PIXEL);
            (token.load(x, at) + u).store(x, at);
            (token.load(y, at) + v).store(y, at);
        }
    }
}
