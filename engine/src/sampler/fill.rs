//! A sampled pixel, and the square that it stands for.

use glam::Vec3;

use crate::image::FrameBuffer;
use crate::layers::{Layers, Plane};
use crate::stack::Fragment;

/// Gives a sampled pixel its colour, and with it the square that it stands for (see [`Fragment::step`]).
#[inline(always)]
pub(super) fn fill(out: &FrameBuffer, fragment: &Fragment, [x, y]: [u32; 2], color: u32) {
    if fragment.step == 1 {
        out.set(x as usize, y as usize, color);
    } else {
        fill_square(out, fragment, [x as usize, y as usize], color);
    }
}

#[inline(never)]
fn fill_square(out: &FrameBuffer, fragment: &Fragment, [x, y]: [usize; 2], color: u32) {
    for y in y..(y + fragment.step).min(fragment.y1) {
        for x in x..(x + fragment.step).min(fragment.x1) {
            out.set(x, y, color);
        }
    }
}

/// Keeps the light of a pixel, as it arrives.
pub(super) fn keep(layers: &Layers, [x, y]: [u32; 2], light: Vec3) {
    layers.set([Plane::Red, Plane::Green, Plane::Blue], x as usize, y as usize, light.to_array());
}
