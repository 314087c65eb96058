//! One sample a pixel, in its middle.

use super::fill::{fill, keep};
use super::morton::for_each_piece;
use super::pixel_seed;
use crate::color::to_pixels;
use crate::image::FrameBuffer;
use crate::packet::{Column, Packet, vec3};
use crate::scratch::lend;
use crate::stack::{Camera, Context, Fragment, PixelSampler};

/// One ray through the middle of each pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct SingleSample;

impl PixelSampler for SingleSample {
    fn render_fragment(&self, context: &Context<'_>, camera: &dyn Camera, fragment: Fragment, out: &FrameBuffer) {
        let size = [out.width() as u32, out.height() as u32];
        let packet: &mut Packet = &mut lend(context.width);
        let shown: &mut Column<u32> = &mut lend(context.width);
        for_each_piece(fragment, context.width, |pixels| {
            packet.reset(pixels.len());
            packet.channel = fragment.channel as u32;
            let [x, y] = &mut packet.image;
            for ((x, y), pixel) in x.iter_mut().zip(y.iter_mut()).zip(pixels) {
                // By way of i32: all levels have instructions for that.
                *x = pixel[0] as i32 as f32 + 0.5;
                *y = pixel[1] as i32 as f32 + 0.5;
            }
            let [seeds, numbers] = &mut packet.samples;
            seeds.iter_mut().zip(pixels).for_each(|(seed, &pixel)| *seed = pixel_seed(pixel));
            numbers[..pixels.len()].fill(context.frame);
            camera.make_rays(context, size, packet);
            context.renderer.trace(context, packet);
            to_pixels(
                context.token,
                context.tone,
                packet.color.each_ref().map(|column| &column[..]),
                pixels.len(),
                shown,
            );
            if let Some(layers) = out.layers() {
                let colors = pixels.iter().enumerate().map(|(i, pixel)| (pixel, vec3(&packet.color, i)));
                colors.for_each(|(&pixel, color)| keep(layers, pixel, color));
            }
            if fragment.step == 1 {
                out.set_each(pixels, shown);
            } else {
                pixels.iter().zip(shown.iter()).for_each(|(&pixel, &color)| fill(out, &fragment, pixel, color));
            }
        });
    }
}
