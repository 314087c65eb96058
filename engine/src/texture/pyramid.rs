//! Pictures in ever smaller copies (mip-maps: Williams, "Pyramidal Parametrics", 1983), and what is seen of them through a footprint.

use std::fmt;
use std::sync::LazyLock;

use glam::Vec4;

use super::picture::{Picture, Texels};
use crate::color::from_srgb8;

/// What the red, green and blue bytes of a picture stand for. Alpha is linear in any case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// Colours on the sRGB curve.
    Srgb,
    /// Numbers from 0 to 1: normals, roughness, opacity.
    Linear,
}

/// How a texture goes on beyond its borders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// Again and again.
    #[default]
    Repeat,
    /// Again and again, each the mirror image of the one before.
    Mirror,
    /// As at the border.
    Clamp,
}

/// A picture, and copies of it, each half as wide and high as the one before.
pub struct Texture {
    store: Texels,
    levels: Vec<Level>,
    /// What bytes stand for.
    table: &'static [f32; 256],
    has_alpha: bool,
}

/// One of the copies: its texels begin at `first`.
#[derive(Clone, Copy, Debug)]
struct Level {
    size: [u32; 2],
    first: usize,
}

static SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| from_srgb8([i as u8; 3]).x));
static PLAIN: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| i as f32 / 255.0));

/// Means of bytes on the sRGB curve are taken of such whole numbers, linear in light, which are less than this.
const FINE: usize = 1 << 14;
/// The number for each byte, and the byte for each number.
static FINES: LazyLock<([u16; 256], Box<[u8; FINE]>)> = LazyLock::new(|| {
    let to = SRGB.map(|linear| (linear * (FINE - 1) as f32 + 0.5) as u16);
    // The bytes whose own numbers are nearest.
    let halves: Vec<f32> = SRGB.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let mut from = Box::new([0; FINE]);
    for (i, byte) in from.iter_mut().enumerate() {
        *byte = halves.partition_point(|&half| half <= i as f32 / (FINE - 1) as f32) as u8;
    }
    (to, from)
});

impl Texture {
    /// Makes the copies of a picture. `encoding` says what its bytes stand for.
    pub fn new(picture: Picture, encoding: Encoding) -> Self {
        let size = picture.size();
        let mut levels = vec![Level { size, first: 0 }];
        let has_alpha = picture.has_alpha();
        let mut store = picture.into_texels();
        let (to, from_fine) = &*FINES;
        let of_srgb = OfSrgb { to, from: from_fine };
        while let Some(&from) = levels.last().filter(|level| level.size != [1, 1]) {
            let next = Level { size: from.size.map(|side| (side / 2).max(1)), first: store.len() };
            match (&mut store, encoding) {
                (Texels::Bytes(texels), Encoding::Srgb) => shrink(&of_srgb, texels, from, next),
                (Texels::Bytes(texels), Encoding::Linear) => shrink(&OfBytes, texels, from, next),
                (Texels::Floats(texels), _) => shrink(&OfFloats, texels, from, next),
            }
            levels.push(next);
        }
        let table = if encoding == Encoding::Srgb { &*SRGB } else { &*PLAIN };
        Self { store, levels, table, has_alpha }
    }

    /// Width and height of the picture.
    pub fn size(&self) -> [u32; 2] {
        self.levels[0].size
    }

    /// Is any texel not opaque?
    pub fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    /// Bytes that it occupies.
    pub fn bytes(&self) -> usize {
        match &self.store {
            Texels::Bytes(texels) => size_of_val(&texels[..]),
            Texels::Floats(texels) => size_of_val(&texels[..]),
        }
    }

    /// What is seen at a place, from (0, 0) at the lower left corner to (1, 1) at the upper right one, through a footprint of so much
    /// area: linear RGB and alpha. Between texels of two copies it is linear (trilinear filtering). A place that is not finite is the
    /// origin.
    pub fn sample(&self, place: [f32; 2], area: f32, wrap: [Wrap; 2]) -> Vec4 {
        let [width, height] = self.size().map(|side| side as f32);
        let level = 0.5 * log2(area * (width * height));
        let last = self.levels.len() - 1;
        if level.is_nan() || level <= 0.0 {
            return self.bilinear(0, place, wrap);
        }
        let whole = (level as usize).min(last);
        let fine = self.bilinear(whole, place, wrap);
        if whole == last {
            return fine;
        }
        fine + (self.bilinear(whole + 1, place, wrap) - fine) * (level - whole as f32)
    }

    /// Between the texels of one copy.
    fn bilinear(&self, level: usize, place: [f32; 2], wrap: [Wrap; 2]) -> Vec4 {
        let Level { size: [width, height], first } = self.levels[level];
        let ([x0, x1], across) = neighbours(place[0], width, wrap[0]);
        let ([y0, y1], down) = neighbours(1.0 - place[1], height, wrap[1]);
        let row = |y: u32| first + y as usize * width as usize;
        let (upper, lower) = (row(y0), row(y1));
        let at = [upper + x0 as usize, upper + x1 as usize, lower + x0 as usize, lower + x1 as usize];
        let [a, b, c, d] = match &self.store {
            Texels::Bytes(texels) => at.map(|i| {
                let [r, g, b, a] = texels[i].map(usize::from);
                Vec4::new(self.table[r], self.table[g], self.table[b], a as f32 * (1.0 / 255.0))
            }),
            Texels::Floats(texels) => at.map(|i| Vec4::from(texels[i])),
        };
        let (upper, lower) = (a + (b - a) * across, c + (d - c) * across);
        upper + (lower - upper) * down
    }
}

impl fmt::Debug for Texture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Texture").field("size", &self.size()).finish_non_exhaustive()
    }
}

/// The two texels beside a place, and how far it is from the first to the second.
#[inline(always)]
fn neighbours(place: f32, count: u32, wrap: Wrap) -> ([u32; 2], f32) {
    let size = count as f32;
    let within = |x: f32| if x.is_finite() { x } else { 0.0 };
    let at = match wrap {
        Wrap::Repeat => within(place - place.floor()) * size,
        Wrap::Mirror => {
            let twice = within(place - 2.0 * (place * 0.5).floor());
            (1.0 - (twice - 1.0).abs()) * size
        }
        Wrap::Clamp => {
            if place.is_nan() {
                0.0
            } else {
                place.clamp(0.0, 1.0) * size
            }
        }
    };
    // Texels are seen at their middles.
    let at = at - 0.5;
    let before = at.floor();
    let part = at - before;
    let before = before as i64;
    let end = i64::from(count);
    let pick = |x: i64| match wrap {
        Wrap::Repeat => x.rem_euclid(end) as u32,
        Wrap::Mirror | Wrap::Clamp => x.clamp(0, end - 1) as u32,
    };
    ([pick(before), pick(before + 1)], part)
}

/// The logarithm to base 2 of a number that is not negative, linear between powers of 2: at most 0.09 too little, and what filters
/// want, as it does not jump. Of 0 it is about -127.
#[inline(always)]
fn log2(x: f32) -> f32 {
    x.to_bits() as f32 * (1.0 / (1 << 23) as f32) - 127.0
}

/// What texels are together.
trait Mean {
    type Texel: Copy + Default;

    /// Of some texels, at least one.
    fn of(&self, texels: impl Iterator<Item = Self::Texel>) -> Self::Texel;

    /// Of four: nearly all are.
    fn of_four(&self, texels: [Self::Texel; 4]) -> Self::Texel {
        self.of(texels.into_iter())
    }
}

/// Of colours: as much of each counts as is opaque. What is wholly transparent counts a little, so that where nothing else is, it is
/// kept.
struct OfSrgb<'a> {
    to: &'a [u16; 256],
    from: &'a [u8; FINE],
}

impl Mean for OfSrgb<'_> {
    type Texel = [u8; 4];

    fn of(&self, texels: impl Iterator<Item = [u8; 4]>) -> [u8; 4] {
        let (mut color, mut weights, mut alpha, mut count) = ([0; 3], 0, 0, 0);
        for [r, g, b, a] in texels {
            let weight = u32::from(a).max(1);
            for (sum, byte) in color.iter_mut().zip([r, g, b]) {
                *sum += u32::from(self.to[usize::from(byte)]) * weight;
            }
            weights += weight;
            alpha += u32::from(a);
            count += 1;
        }
        let by = 1.0 / weights as f32;
        let [r, g, b] = color.map(|sum| self.from[(sum as f32 * by + 0.5) as usize % FINE]);
        [r, g, b, ((alpha + count / 2) / count) as u8]
    }

    #[inline(always)]
    fn of_four(&self, texels: [[u8; 4]; 4]) -> [u8; 4] {
        if texels.iter().any(|texel| texel[3] < 255) {
            return self.of(texels.into_iter());
        }
        let channel = |i: usize| {
            let [a, b, c, d] = texels.map(|texel| usize::from(self.to[usize::from(texel[i])]));
            self.from[(a + b + c + d + 2) / 4 % FINE]
        };
        [channel(0), channel(1), channel(2), 255]
    }
}

/// Of plain bytes.
struct OfBytes;

impl Mean for OfBytes {
    type Texel = [u8; 4];

    #[inline(always)]
    fn of(&self, texels: impl Iterator<Item = [u8; 4]>) -> [u8; 4] {
        let (mut sums, mut count) = ([0; 4], 0);
        for texel in texels {
            sums.iter_mut().zip(texel).for_each(|(sum, byte)| *sum += u32::from(byte));
            count += 1;
        }
        sums.map(|sum| ((sum + count / 2) / count) as u8)
    }

    #[inline(always)]
    fn of_four(&self, [a, b, c, d]: [[u8; 4]; 4]) -> [u8; 4] {
        std::array::from_fn(|i| (([a[i], b[i], c[i], d[i]].map(u32::from).iter().sum::<u32>() + 2) / 4) as u8)
    }
}

/// Of plain numbers.
struct OfFloats;

impl Mean for OfFloats {
    type Texel = [f32; 4];

    fn of(&self, texels: impl Iterator<Item = [f32; 4]>) -> [f32; 4] {
        let (mut sum, mut count) = (Vec4::ZERO, 0_u32);
        for texel in texels {
            sum += Vec4::from(texel);
            count += 1;
        }
        (sum / count as f32).to_array()
    }
}

/// Appends a copy, each texel of which is the mean of those at its place. Of odd sides, the copy's texels are a little more than two wide:
/// they share some.
fn shrink<M: Mean>(mean: &M, texels: &mut Vec<M::Texel>, from: Level, to: Level) {
    let [width, height] = to.size;
    let span = |i: u32, axis: usize| {
        let (i, many, few) = (u64::from(i), u64::from(from.size[axis]), u64::from(to.size[axis]));
        (i * many / few) as usize..((i + 1) * many).div_ceil(few) as usize
    };
    texels.resize(to.first + width as usize * height as usize, M::Texel::default());
    let (done, made) = texels.split_at_mut(to.first);
    let wide = from.size[0] as usize;
    let row = |row: usize| &done[from.first + row * wide..][..wide];
    let halved = from.size == [2 * width, 2 * height];
    for (y, out) in (0..height).zip(made.chunks_mut(width as usize)) {
        let rows = span(y, 1);
        if halved {
            let [above, below] = [rows.start, rows.start + 1].map(|y| row(y).as_chunks::<2>().0);
            for ((out, &[a, b]), &[c, d]) in out.iter_mut().zip(above).zip(below) {
                *out = mean.of_four([a, b, c, d]);
            }
            continue;
        }
        for (x, out) in (0..width).zip(out) {
            let columns = span(x, 0);
            *out = mean.of(rows.clone().flat_map(|y| row(y)[columns.clone()].iter().copied()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(size: [u32; 2], of: impl Fn(u32, u32) -> [u8; 4]) -> Picture {
        let texels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| of(x, y)).collect();
        Picture::new(size, Texels::Bytes(texels)).unwrap()
    }

    #[test]
    fn bytes_survive_their_means() {
        let gray = |i: u32| bytes([16, 16], move |_, _| [i as u8, i as u8 / 2, 255 - i as u8, 200]);
        for i in 0..256 {
            for encoding in [Encoding::Srgb, Encoding::Linear] {
                let texture = Texture::new(gray(i), encoding);
                let [fine, coarse] = [0.0, 1.0].map(|area| texture.sample([0.3, 0.6], area, [Wrap::Repeat; 2]));
                assert!((fine - coarse).abs().max_element() < 1e-6, "{i} {encoding:?}: {fine} {coarse}");
            }
        }
    }

    #[test]
    fn texels_are_where_they_belong() {
        // Rows from above; places from below.
        let texture = Texture::new(bytes([4, 2], |x, y| [x as u8 * 60, y as u8 * 200, 0, 255]), Encoding::Linear);
        let byte = |place: [f32; 2], wrap| (texture.sample(place, 0.0, [wrap; 2]) * 255.0).round().to_array();
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            assert_eq!(byte([0.125, 0.75], wrap), [0.0, 0.0, 0.0, 255.0]);
            assert_eq!(byte([0.875, 0.25], wrap), [180.0, 200.0, 0.0, 255.0]);
            assert_eq!(byte([0.5, 0.75], wrap), [90.0, 0.0, 0.0, 255.0], "half way");
        }
        assert_eq!(byte([1.125, 0.75], Wrap::Repeat), [0.0, 0.0, 0.0, 255.0]);
        assert_eq!(byte([1.125, 0.75], Wrap::Mirror), [180.0, 0.0, 0.0, 255.0]);
        assert_eq!(byte([1.125, 0.75], Wrap::Clamp), [180.0, 0.0, 0.0, 255.0]);
        assert_eq!(byte([0.0, 0.75], Wrap::Repeat), [90.0, 0.0, 0.0, 255.0], "between the last and the first");
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                assert!(texture.sample([odd, odd], 1.0, [wrap; 2]).is_finite());
                assert!(texture.sample([0.5, 0.5], odd, [wrap; 2]).is_finite());
            }
        }
    }

    #[test]
    fn wide_footprints_see_means() {
        // A checkerboard of texels is grey from afar, linear in light; of any size.
        for (size, error) in [([64, 64], 0.01), ([64, 1], 0.01), ([37, 5], 0.2), ([1, 9], 0.2), ([33, 32], 0.1)] {
            let board = bytes(size, |x, y| [[0, 255][(x + y) as usize % 2]; 4].map(|byte: u8| byte.max(1)));
            let texture = Texture::new(board, Encoding::Linear);
            let all = texture.sample([0.4, 0.4], 1.0, [Wrap::Repeat; 2]);
            assert!((all.x - 0.5).abs() < error, "{size:?}: {all}");
        }
        let board = bytes([64, 64], |x, y| [[0, 0, 0, 255], [255; 4]][(x + y) as usize % 2]);
        let texture = Texture::new(board, Encoding::Srgb);
        for area in [1.0, 2.0, 1e9, f32::INFINITY] {
            let all = texture.sample([0.4, 0.4], area, [Wrap::Repeat; 2]);
            assert!((all.x - 0.5).abs() < 0.01, "{area}: {all}");
        }
        // One that covers a texel sees it whole, and so on, without jumps.
        let mut before = texture.sample([0.5 / 64.0, 0.5 / 64.0], 0.0, [Wrap::Repeat; 2]).x;
        for i in 0..200 {
            let area = 1.06_f32.powi(i) / (64.0 * 64.0);
            let now = texture.sample([0.5 / 64.0, 0.5 / 64.0], area, [Wrap::Repeat; 2]).x;
            assert!((now - before).abs() < 0.05, "{area}: {before} {now}");
            before = now;
        }
    }

    #[test]
    fn what_is_transparent_gives_no_colour() {
        let leaf = bytes([8, 8], |x, _| if x % 2 == 0 { [0, 0, 0, 0] } else { [80, 200, 40, 255] });
        let texture = Texture::new(leaf, Encoding::Srgb);
        let far = texture.sample([0.5, 0.5], 1.0, [Wrap::Repeat; 2]);
        assert!((far.y - SRGB[200]).abs() < 0.02 && (far.w - 0.5).abs() < 0.01, "{far}");
    }
}
