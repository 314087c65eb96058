//! One sample a pixel, in its middle.

use mobula_core::{Properties, RayPacket};

use super::{fill, morton::for_each_piece};
use crate::color::to_pixels;
use crate::image::FrameBuffer;
use crate::scratch::lend;
use crate::stack::{Camera, Context, Fragment, PixelSampler};

/// One ray through the middle of each pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct SingleSample;

impl<const N: usize> PixelSampler<N> for SingleSample {
    fn render_fragment(&self, context: &Context<'_, N>, camera: &dyn Camera<N>, fragment: Fragment, out: &FrameBuffer) {
        let size = [out.width() as u32, out.height() as u32];
        let packet: &mut RayPacket<N> = &mut lend();
        let mut known = Properties::HAVE_IMAGE_COORDINATES | Properties::CONSTANT_SAMPLE_REGION;
        if N.is_power_of_two() {
            known |= Properties::HAVE_CORNER_RAYS;
        }
        let mut shown = [0; N];
        for_each_piece::<N>(fragment, N, |pixels| {
            packet.reset(0..pixels.len());
            packet.channel = fragment.channel as u32;
            for (i, pixel) in pixels.iter().enumerate() {
                packet.image[0][i] = pixel[0] as f32 + 0.5;
                packet.image[1][i] = pixel[1] as f32 + 0.5;
            }
            let one = if pixels.len() == 1 { Properties::CONSTANT_PIXEL } else { Properties::empty() };
            packet.promise(known | one);
            camera.make_rays(context, size, packet);
            context.renderer.trace(context, packet);
            to_pixels(context.token, &packet.color, pixels.len(), &mut shown);
            for (&pixel, &color) in pixels.iter().zip(&shown) {
                fill(out, &fragment, pixel, color);
            }
        });
    }
}
