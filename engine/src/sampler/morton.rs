//! Pixels in Morton (Z) order, so that neighbours in a packet are neighbours in the image.
//!
//! Morton, "A computer oriented geodetic data base and a new technique in file sequencing", 1966.

use crate::stack::Fragment;

/// Side of the largest block that is walked in one Morton curve.
const LARGEST: u32 = 32;

/// Column and row of a place on the curve: the even and the odd bits.
#[inline(always)]
pub const fn decode(code: u32) -> [u32; 2] {
    [even_bits(code), even_bits(code >> 1)]
}

/// Bits 0, 2, 4, ... 14 of `x`, moved together.
#[inline(always)]
const fn even_bits(x: u32) -> u32 {
    let x = x & 0x5555;
    let x = (x | x >> 1) & 0x3333;
    let x = (x | x >> 2) & 0x0f0f;
    (x | x >> 4) & 0x00ff
}

/// The curve as far as the largest block.
static CURVE: [[u32; 2]; (LARGEST * LARGEST) as usize] = {
    let mut places = [[0; 2]; (LARGEST * LARGEST) as usize];
    let mut code = 0;
    while code < LARGEST * LARGEST {
        places[code as usize] = decode(code);
        code += 1;
    }
    places
};

/// Calls `f` with the pixels of `fragment` that have to be sampled, in pieces of up to `piece` (1 to 1024), each once.
///
/// The fragment is cut into square blocks, and the Morton curve of each block into pieces of `piece` places; what falls
/// outside the fragment is left out. So a piece of 4, 16, 64, 256 pixels is a square, one of 2, 8, 32, 128 a rectangle
/// twice as wide as high, both clipped at the border: still a rectangle. Any other number gives consecutive pixels of the
/// curve, which is compact, but not a rectangle.
pub fn for_each_piece(fragment: Fragment, piece: usize, f: impl FnMut(&[[u32; 2]])) {
    // A small buffer is cleared in no time.
    match piece {
        0..=64 => pieces::<64>(fragment, piece, f),
        65..=256 => pieces::<256>(fragment, piece, f),
        _ => pieces::<{ CURVE.len() }>(fragment, piece, f),
    }
}

/// As [`for_each_piece`], of pieces of up to `MOST` pixels.
fn pieces<const MOST: usize>(fragment: Fragment, piece: usize, mut f: impl FnMut(&[[u32; 2]])) {
    let step = fragment.step.max(1);
    let width = fragment.x1.saturating_sub(fragment.x0).div_ceil(step) as u32;
    let height = fragment.y1.saturating_sub(fragment.y0).div_ceil(step) as u32;
    let (x0, y0, step) = (fragment.x0 as u32, fragment.y0 as u32, step as u32);
    let piece = piece.clamp(1, MOST) as u32;
    let bits = piece.next_power_of_two().trailing_zeros();
    let side = width.min(height).clamp(1, LARGEST).next_power_of_two().max(1 << bits.div_ceil(2));
    let mut pixels = [[0; 2]; MOST];
    for y in (0..height).step_by(side as usize) {
        for x in (0..width).step_by(side as usize) {
            let inside = x + side <= width && y + side <= height;
            let pixel = |[dx, dy]: [u32; 2]| [x0 + (x + dx) * step, y0 + (y + dy) * step];
            for places in CURVE[..(side * side) as usize].chunks(piece as usize) {
                let mut count = 0;
                if inside {
                    count = places.len();
                    pixels.iter_mut().zip(places).for_each(|(to, &place)| *to = pixel(place));
                } else {
                    for &place in places.iter().filter(|place| x + place[0] < width && y + place[1] < height) {
                        pixels[count] = pixel(place);
                        count += 1;
                    }
                }
                if count > 0 {
                    f(&pixels[..count]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::HashSet;

    #[test]
    fn decode_is_a_bijection() {
        let places: HashSet<[u32; 2]> = (0..1 << 16).map(decode).collect();
        assert_eq!(places.len(), 1 << 16);
        assert!(places.iter().all(|&[x, y]| x < 256 && y < 256));
    }

    proptest! {
        #[test]
        fn every_pixel_comes_once(
            x0 in 0..70_usize,
            y0 in 0..70_usize,
            w in 0..70_usize,
            h in 0..70_usize,
            step in 1..9_usize,
            piece in 1..=1024_usize,
        ) {
            let fragment = Fragment { channel: 0, x0, y0, x1: x0 + w, y1: y0 + h, step };
            let mut seen = HashSet::new();
            for_each_piece(fragment, piece, |pixels| {
                assert!(!pixels.is_empty() && pixels.len() <= piece);
                assert!(pixels.iter().all(|&p| seen.insert(p)), "a pixel comes twice");
            });
            prop_assert_eq!(seen.len(), w.div_ceil(step) * h.div_ceil(step));
            for &[x, y] in &seen {
                let (x, y) = (x as usize, y as usize);
                prop_assert!(x0 <= x && x < x0 + w && y0 <= y && y < y0 + h);
                prop_assert!((x - x0) % step == 0 && (y - y0) % step == 0);
            }
        }

        #[test]
        fn powers_of_two_are_rectangles(w in 1..70_usize, h in 1..70_usize, bits in 0..=10_u32) {
            let fragment = Fragment { channel: 0, x0: 3, y0: 5, x1: 3 + w, y1: 5 + h, step: 1 };
            for_each_piece(fragment, 1 << bits, |pixels| {
                let range = |axis: usize| {
                    let values = pixels.iter().map(|p| p[axis]);
                    values.clone().max().unwrap() - values.min().unwrap() + 1
                };
                assert_eq!(range(0) * range(1), pixels.len() as u32, "{pixels:?}");
                assert!(range(0) <= 1 << bits.div_ceil(2) && range(1) <= 1 << (bits / 2));
            });
        }
    }
}
