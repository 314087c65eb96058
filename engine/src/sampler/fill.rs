//! A sampled pixel, and the square that it stands for.

use crate::image::FrameBuffer;
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
