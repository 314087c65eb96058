//! Points that fill a square evenly, however many are taken: Sobol's first two dimensions, scrambled for each pixel (Owen 1995) by hashing
//! (Burley, "Practical Hash-based Owen Scrambling", JCGT 2020; Laine and Karras 2011 for the hash).
//!
//! Whatever is chosen at random for a sample (where in its pixel, towards which point of a light) has a set of its own. The points of two
//! sets, or of two pixels, have nothing to do with each other; those of one, from the first on, are as even as may be.

use mobula_core::simd::{AnyToken, F32Lanes, I32Lanes, Task, Token};

use crate::math::hash;
use crate::warp::disk;

/// What is chosen at random for a sample. The points of a set are even together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Set(u32);

impl Set {
    /// Where in its pixel a sample is.
    pub(crate) const PIXEL: Self = Self(0);

    /// Where an ambient occlusion ray goes from a hit with so many reflections or refractions before it.
    pub(crate) fn occlusion(depth: u32) -> Self {
        Self(1 + depth)
    }

    /// Where a ray goes that is scattered at a hit with so many reflections or refractions before it.
    pub(crate) fn scattering(depth: u32) -> Self {
        Self(0x100_0000_u32.wrapping_add(depth))
    }

    /// Which of two ways a ray goes at such a hit.
    pub(crate) fn choice(depth: u32) -> Self {
        Self(0x200_0000_u32.wrapping_add(depth))
    }

    /// Where on a lens a ray starts.
    pub(crate) const LENS: Self = Self(0x300_0000);

    /// Where on a light of this number a hit with so many reflections or refractions before it looks.
    pub(crate) fn light(number: usize, depth: u32) -> Self {
        Self((number as u32).wrapping_add(1) << 8 | depth & 0xff)
    }

    /// A number that scrambles: one of three for each set.
    fn seed(self, which: u32) -> u32 {
        hash(self.0.wrapping_mul(3).wrapping_add(which + 1))
    }
}

/// Point `index` of a set, both coordinates in 0..1, for pixels with the hashes `seed`.
#[inline(always)]
pub(crate) fn point<T: Token>(token: T, seed: T::I32, index: T::I32, set: Set) -> [T::F32; 2] {
    of_place(token, seed, place(token, seed, index, set), set)
}

/// One of as many points of a set as a grid has `cells`, from point `block * cells` on: the one in cell `cell`. So the first of all pixels are
/// near each other, and the second ones, and so on. The grid is one of 2 x 2 or 4 x 4; of other numbers, points are as they come.
#[inline(always)]
pub(crate) fn point_in_cell<T: Token>(
    token: T,
    seed: T::I32,
    block: T::I32,
    (cell, cells): (u32, u32),
    set: Set,
) -> [T::F32; 2] {
    let bits = match cells {
        4 => 1,
        16 => 2,
        _ => return point(token, seed, block * token.splat_i32(cells as i32) + token.splat_i32(cell as i32), set),
    };
    // All but the lowest bits of the place say which block it is. Of the lowest, first those that permute to the cell's column.
    let low = token.splat_i32((1 << bits) - 1);
    let place = place(token, seed, block.shl(2 * bits), set) & token.splat_i32(-(cells as i32));
    let [column, row] = [cell & ((1 << bits) - 1), cell >> bits].map(|x| token.splat_i32(x as i32));
    let [seed_x, seed_y] = [1, 2].map(|which| seed ^ token.splat_i32(set.seed(which) as i32));
    let place = place | (unpermute_two(column, seed_x) & low);
    // Then those above, which add what the product lacks of what permutes to the row.
    let lacking = (unpermute_two(row, seed_y) ^ pascal(token, place)) & low;
    of_place(token, seed, place | (lacking ^ lacking.shr(1)).shl(bits), set)
}

/// Where in Sobol's sequence a point of a set is: in another order for each set, or the first points of all would go together.
#[inline(always)]
fn place<T: Token>(token: T, seed: T::I32, index: T::I32, set: Set) -> T::I32 {
    if set == Set::PIXEL {
        return index;
    }
    mirror(token, permute(token, mirror(token, index), seed ^ token.splat_i32(set.seed(0) as i32)))
}

/// The point at a place of Sobol's sequence, scrambled.
#[inline(always)]
fn of_place<T: Token>(token: T, seed: T::I32, index: T::I32, set: Set) -> [T::F32; 2] {
    let seeds = [0, 1, 2].map(|which| set.seed(which) as i32);
    // Mirrored, which is how they are permuted, the first coordinate is the index itself, the second its product with Pascal's triangle
    // modulo 2: each bit is the sum of those whose place has all its bits set.
    let x = permute(token, index, seed ^ token.splat_i32(seeds[1]));
    let y = permute(token, pascal(token, index), seed ^ token.splat_i32(seeds[2]));
    [unit(token, mirror(token, x)), unit(token, mirror(token, y))]
}

/// Fills `out` with the points of a set that belong to `samples` (hashes of pixels, and numbers there): of the square, or of the disk.
pub(crate) fn points(token: AnyToken, samples: [&[u32]; 2], set: Set, shape: Shape, out: [&mut [f32]; 2]) {
    token.run(Fill { samples, set, shape, out });
}

/// What points are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    /// Both coordinates in 0..1.
    Square,
    /// Of radius 1 around 0.
    Disk,
}

struct Fill<'a> {
    samples: [&'a [u32]; 2],
    set: Set,
    shape: Shape,
    out: [&'a mut [f32]; 2],
}

impl Task for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { samples: [seeds, numbers], set, shape, out: [x, y] } = self;
        for at in (0..seeds.len()).step_by(T::LANES) {
            let square = point(token, token.load_u32(seeds, at), token.load_u32(numbers, at), set);
            let [u, v] = match shape {
                Shape::Square => square,
                Shape::Disk => disk(token, square),
            };
            u.store(x, at);
            v.store(y, at);
        }
    }
}

/// The upper 24 bits as a number in 0..1.
#[inline(always)]
fn unit<T: Token>(token: T, bits: T::I32) -> T::F32 {
    bits.shr(8).to_f32() * token.splat(1.0 / (1 << 24) as f32)
}

/// Bit `i` decides about bits above it only: permutes, of numbers whose first bit is the lowest, the halves, their halves, and so on.
#[inline(always)]
fn permute<T: Token>(token: T, x: T::I32, seed: T::I32) -> T::I32 {
    let mut x = x + seed;
    for factor in [0x6c50_b47c_u32, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
        x = x ^ (x * token.splat_i32(factor as i32));
    }
    x
}

/// The lowest two bits of what [`permute`] makes into the lowest two of `x`: its factors change them twice, to and fro.
#[inline(always)]
fn unpermute_two<I: I32Lanes>(x: I, seed: I) -> I {
    x - seed
}

/// The bits in reverse order.
#[inline(always)]
fn mirror<T: Token>(token: T, x: T::I32) -> T::I32 {
    let mut x = x.shl(16) | x.shr(16);
    for (by, low) in [(8, 0x00ff_00ff), (4, 0x0f0f_0f0f), (2, 0x3333_3333), (1, 0x5555_5555)] {
        let low = token.splat_i32(low);
        x = (x & low).shl(by) | (x.shr(by) & low);
    }
    x
}

/// The product with Pascal's triangle modulo 2.
#[inline(always)]
fn pascal<T: Token>(token: T, x: T::I32) -> T::I32 {
    let mut x = x;
    for (by, low) in [(1, 0x5555_5555), (2, 0x3333_3333), (4, 0x0f0f_0f0f), (8, 0x00ff_00ff), (16, 0x0000_ffff)] {
        x = x ^ (x.shr(by) & token.splat_i32(low));
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Points {
        seed: u32,
        count: usize,
        set: Set,
    }

    impl Task for Points {
        type Output = Vec<[f32; 2]>;

        #[inline(always)]
        fn run<T: Token>(self, token: T) -> Vec<[f32; 2]> {
            let numbers: Vec<u32> = (0..self.count as u32).collect();
            let (mut x, mut y) = (vec![0.0; self.count], vec![0.0; self.count]);
            for at in (0..self.count).step_by(T::LANES) {
                let seed = token.splat_i32(self.seed as i32);
                let [u, v] = point(token, seed, token.load_u32(&numbers, at), self.set);
                u.store(&mut x, at);
                v.store(&mut y, at);
            }
            x.into_iter().zip(y).map(|(x, y)| [x, y]).collect()
        }
    }

    fn points(token: AnyToken, seed: u32, count: usize, set: Set) -> Vec<[f32; 2]> {
        token.run(Points { seed, count, set })
    }

    #[test]
    fn columns_of_points_are_the_points_and_disks_are_filled_evenly() {
        let token = AnyToken::detect();
        let (seeds, numbers) = (vec![7; 1023], (0..1023).collect::<Vec<u32>>());
        let set = Set::scattering(2);
        let fill = |shape| {
            let (mut x, mut y) = (vec![0.0; 1023], vec![0.0; 1023]);
            super::points(token, [&seeds, &numbers], set, shape, [&mut x, &mut y]);
            x.into_iter().zip(y).map(|(x, y)| [x, y]).collect::<Vec<_>>()
        };
        assert_eq!(fill(Shape::Square), points(token, 7, 1023, set));
        let disk = fill(Shape::Disk);
        assert!(disk.iter().all(|[x, y]| x * x + y * y < 1.000_001));
        // A quarter of the area is within half the radius, and half of it on each side.
        let share =
            |inside: &dyn Fn(&[f32; 2]) -> bool| disk.iter().filter(|point| inside(point)).count() as f32 / 1023.0;
        assert!((share(&|[x, y]| x * x + y * y < 0.25) - 0.25).abs() < 0.01);
        assert!((share(&|[x, _]| *x < 0.0) - 0.5).abs() < 0.01 && (share(&|[_, y]| *y < 0.0) - 0.5).abs() < 0.01);
    }

    #[test]
    fn each_box_of_an_area_has_its_point() {
        let token = AnyToken::detect();
        for (seed, set) in [(0, 0), (1, 0), (0xdead_beef, 0), (7, 1), (8, 5)] {
            for bits in 0..10 {
                let points = points(token, seed, 1 << bits, Set(set));
                // (0, 2)-sequence: boxes of 2^-a by 2^-b, a + b = bits.
                for a in 0..=bits {
                    let place = |[x, y]: [f32; 2]| {
                        ((x * (1 << a) as f32) as usize) << (bits - a) | (y * (1 << (bits - a)) as f32) as usize
                    };
                    let mut seen: Vec<usize> = points.iter().map(|&point| place(point)).collect();
                    seen.sort_unstable();
                    assert!(seen.into_iter().eq(0..1 << bits), "seed {seed}, set {set}, 2^{bits} points, {a}");
                }
            }
        }
    }

    struct Cells {
        seed: u32,
        block: u32,
        cells: u32,
    }

    impl Task for Cells {
        type Output = Vec<[f32; 2]>;

        #[inline(always)]
        fn run<T: Token>(self, token: T) -> Vec<[f32; 2]> {
            let [seed, block] = [self.seed, self.block].map(|x| token.splat_i32(x as i32));
            let (mut x, mut y) = (vec![0.0; T::LANES], vec![0.0; T::LANES]);
            let of = |cell| {
                let [u, v] = point_in_cell(token, seed, block, (cell, self.cells), Set::occlusion(3));
                u.store(&mut x, 0);
                v.store(&mut y, 0);
                [x[0], y[0]]
            };
            (0..self.cells).map(of).collect()
        }
    }

    #[test]
    fn points_are_where_their_cells_are_and_no_others() {
        let token = AnyToken::detect();
        let cell = |side: f32, point: [f32; 2]| point.map(|x| (x * side) as u32);
        for cells in [1, 3, 4, 16, 64] {
            let side = f32::from(cells as u16).sqrt();
            let expected = token.run(Cells { seed: 0, block: 0, cells });
            for (seed, block) in [(0, 0), (1, 0), (2, 1), (0xdead_beef, 5), (77, 1000)] {
                let found = token.run(Cells { seed, block, cells });
                if matches!(cells, 4 | 16) {
                    for (a, b) in expected.iter().zip(&found) {
                        assert_eq!(cell(side, *a), cell(side, *b), "{cells} cells, seed {seed}, block {block}");
                    }
                }
                let mut usual = points(token, seed, ((block + 1) * cells) as usize, Set::occlusion(3));
                let mut usual = usual.split_off((block * cells) as usize);
                let mut found = found;
                usual.sort_by(|a, b| a[0].total_cmp(&b[0]));
                found.sort_by(|a, b| a[0].total_cmp(&b[0]));
                assert_eq!(found, usual, "{cells} cells, seed {seed}, block {block}");
            }
        }
    }

    #[test]
    fn sets_and_pixels_differ_and_all_levels_agree() {
        let all =
            |token| [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1)].map(|(seed, set)| points(token, hash(seed), 33, Set(set)));
        let expected = all(AnyToken::detect());
        for (i, some) in expected.iter().enumerate() {
            assert!(some.iter().flatten().all(|x| (0.0..1.0).contains(x)));
            for others in &expected[..i] {
                let same = some.iter().zip(others).filter(|(a, b)| a == b).count();
                assert!(same < 3, "{same} of 33 points are the same");
            }
        }
        for token in AnyToken::available() {
            assert_eq!(all(token), expected, "{}", token.level());
        }
    }
}
