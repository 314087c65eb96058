//! Every operation, at every level, against its one-lane twin bit for bit; and the twins against plain Rust.

use crate::cases::{Agree, Agree::*, Input, N, check, inputs};
use crate::levels::at_every_level;
use mobula_simd::{AnyToken, F32Lanes, I32Lanes, MaskLanes, Task, Token};

/// An operation on lanes; what it gives is read as bits.
trait Operation {
    const AGREE: Agree;
    /// Of a vector at any level.
    fn lanes<T: Token>(token: T, a: T::F32, b: T::F32, c: T::F32, n: u32) -> T::I32;
    /// Of one number, in plain Rust.
    fn plain(fused: bool, a: f32, b: f32, c: f32, n: u32) -> u32;
}

/// Does an operation to a whole case.
struct Apply<'a, O>(&'a Input, O);

impl<O: Operation> Task for Apply<'_, O> {
    type Output = [u32; N];
    #[inline(always)]
    fn run<T: Token>(self, token: T) -> [u32; N] {
        let mut out = [0; N];
        for at in (0..N).step_by(T::LANES) {
            let [a, b, c] = [&self.0.a, &self.0.b, &self.0.c].map(|x| token.load_u32(x, at).from_bits_f32());
            O::lanes(token, a, b, c, self.0.n).store(&mut out, at);
        }
        out
    }
}

/// A level against its twin, and the twin against plain Rust.
fn agrees<O: Operation + Copy>(token: AnyToken, operation: O) {
    check(inputs(), |input| {
        let plain = std::array::from_fn(|i| {
            let [a, b, c] = [input.a[i], input.b[i], input.c[i]].map(f32::from_bits);
            O::plain(token.fused(), a, b, c, input.n)
        });
        let twin = token.twin().run(Apply(&input, operation));
        O::AGREE.assert(&twin, &plain, &input);
        if token.lanes() > 1 {
            O::AGREE.assert(&token.run(Apply(&input, operation)), &twin, &input);
        }
    });
}

/// Names an operation and says it twice, on lanes and on one number; tests it at every level.
macro_rules! operations {
    ($($name:ident $agree:ident
        |$t:ident, $a:ident, $b:ident, $c:ident, $n:ident| $lanes:expr;
        |$fused:ident, $x:ident, $y:ident, $z:ident, $m:ident| $plain:expr;)+) => {$(
        fn $name(token: AnyToken) {
            #[derive(Clone, Copy)]
            struct This;
            impl Operation for This {
                const AGREE: Agree = $agree;
                #[inline(always)]
                fn lanes<T: Token>($t: T, $a: T::F32, $b: T::F32, $c: T::F32, $n: u32) -> T::I32 {
                    let _ = ($t, $a, $b, $c, $n);
                    $lanes
                }
                fn plain($fused: bool, $x: f32, $y: f32, $z: f32, $m: u32) -> u32 {
                    let _ = ($fused, $x, $y, $z, $m);
                    $plain
                }
            }
            agrees(token, This);
        }
        at_every_level!($name);
    )+};
}

/// A mask as lanes of -1 and 0.
#[inline(always)]
fn truth<T: Token>(token: T, mask: T::Mask) -> T::I32 {
    token.splat_i32(-1).select(mask, token.splat_i32(0))
}

fn plain_truth(x: bool) -> u32 {
    if x { u32::MAX } else { 0 }
}

fn fma(fused: bool, a: f32, b: f32, c: f32) -> u32 {
    if fused { a.mul_add(b, c) } else { a * b + c }.to_bits()
}

fn int(x: f32) -> i32 {
    x.to_bits() as i32
}

// Floats.
operations! {
    add UpToNan |t, a, b, c, n| (a + b).to_bits(); |f, a, b, c, n| (a + b).to_bits();
    sub UpToNan |t, a, b, c, n| (a - b).to_bits(); |f, a, b, c, n| (a - b).to_bits();
    mul UpToNan |t, a, b, c, n| (a * b).to_bits(); |f, a, b, c, n| (a * b).to_bits();
    div UpToNan |t, a, b, c, n| (a / b).to_bits(); |f, a, b, c, n| (a / b).to_bits();
    mul_add UpToNan |t, a, b, c, n| a.mul_add(b, c).to_bits(); |f, a, b, c, n| fma(f, a, b, c);
    mul_sub UpToNan |t, a, b, c, n| a.mul_sub(b, c).to_bits(); |f, a, b, c, n| fma(f, a, b, -c);
    neg_mul_add UpToNan |t, a, b, c, n| a.neg_mul_add(b, c).to_bits(); |f, a, b, c, n| fma(f, -a, b, c);
    sqrt UpToNan |t, a, b, c, n| a.sqrt().to_bits(); |f, a, b, c, n| a.sqrt().to_bits();
    sqrt_of_positive UpToNan |t, a, b, c, n| a.abs().sqrt().to_bits(); |f, a, b, c, n| a.abs().sqrt().to_bits();
    neg Exactly |t, a, b, c, n| (-a).to_bits(); |f, a, b, c, n| a.to_bits() ^ 0x8000_0000;
    abs Exactly |t, a, b, c, n| a.abs().to_bits(); |f, a, b, c, n| a.to_bits() & 0x7fff_ffff;
    min Exactly |t, a, b, c, n| a.min(b).to_bits(); |f, a, b, c, n| if a < b { a } else { b }.to_bits();
    max Exactly |t, a, b, c, n| a.max(b).to_bits(); |f, a, b, c, n| if a > b { a } else { b }.to_bits();
    lt Exactly |t, a, b, c, n| truth(t, a.lt(b)); |f, a, b, c, n| plain_truth(a < b);
    le Exactly |t, a, b, c, n| truth(t, a.le(b)); |f, a, b, c, n| plain_truth(a <= b);
    gt Exactly |t, a, b, c, n| truth(t, a.gt(b)); |f, a, b, c, n| plain_truth(a > b);
    ge Exactly |t, a, b, c, n| truth(t, a.ge(b)); |f, a, b, c, n| plain_truth(a >= b);
    eq Exactly |t, a, b, c, n| truth(t, F32Lanes::eq(a, b)); |f, a, b, c, n| plain_truth(a == b);
    ne Exactly |t, a, b, c, n| truth(t, F32Lanes::ne(a, b)); |f, a, b, c, n| plain_truth(a != b);
    compare_with_self Exactly |t, a, b, c, n| truth(t, F32Lanes::eq(a, a)); |f, a, b, c, n| plain_truth(!a.is_nan());
    select Exactly |t, a, b, c, n| a.select(c.lt(b), b).to_bits(); |f, a, b, c, n| if c < b { a } else { b }.to_bits();
    to_bits Exactly |t, a, b, c, n| a.to_bits(); |f, a, b, c, n| a.to_bits();
    to_i32 Exactly |t, a, b, c, n| a.to_i32();
        |f, a, b, c, n| if (-2_147_483_648.0..2_147_483_648.0).contains(&a) { a as i32 as u32 } else { 0x8000_0000 };
    splat Exactly |t, a, b, c, n| t.splat(f32::from_bits(0x7f80_0001 + n)).to_bits(); |f, a, b, c, n| 0x7f80_0001 + n;
}

// Integers: the bits of the same inputs.
operations! {
    i32_add Exactly |t, a, b, c, n| a.to_bits() + b.to_bits(); |f, a, b, c, n| int(a).wrapping_add(int(b)) as u32;
    i32_sub Exactly |t, a, b, c, n| a.to_bits() - b.to_bits(); |f, a, b, c, n| int(a).wrapping_sub(int(b)) as u32;
    i32_mul Exactly |t, a, b, c, n| a.to_bits() * b.to_bits(); |f, a, b, c, n| int(a).wrapping_mul(int(b)) as u32;
    i32_and Exactly |t, a, b, c, n| a.to_bits() & b.to_bits(); |f, a, b, c, n| a.to_bits() & b.to_bits();
    i32_or Exactly |t, a, b, c, n| a.to_bits() | b.to_bits(); |f, a, b, c, n| a.to_bits() | b.to_bits();
    i32_xor Exactly |t, a, b, c, n| a.to_bits() ^ b.to_bits(); |f, a, b, c, n| a.to_bits() ^ b.to_bits();
    i32_shl Exactly |t, a, b, c, n| a.to_bits().shl(n); |f, a, b, c, n| a.to_bits() << n;
    i32_shr Exactly |t, a, b, c, n| a.to_bits().shr(n); |f, a, b, c, n| a.to_bits() >> n;
    i32_shl_too_far Exactly |t, a, b, c, n| a.to_bits().shl(n + 32); |f, a, b, c, n| 0;
    i32_shr_too_far Exactly |t, a, b, c, n| a.to_bits().shr(u32::MAX - n); |f, a, b, c, n| 0;
    i32_eq Exactly |t, a, b, c, n| truth(t, a.to_bits().eq(b.to_bits())); |f, a, b, c, n| plain_truth(int(a) == int(b));
    i32_lt Exactly |t, a, b, c, n| truth(t, a.to_bits().lt(b.to_bits())); |f, a, b, c, n| plain_truth(int(a) < int(b));
    i32_lt_unsigned Exactly |t, a, b, c, n| truth(t, a.to_bits().lt_unsigned(b.to_bits()));
        |f, a, b, c, n| plain_truth(a.to_bits() < b.to_bits());
    i32_select Exactly |t, a, b, c, n| a.to_bits().select(c.lt(b), b.to_bits());
        |f, a, b, c, n| if c < b { a.to_bits() } else { b.to_bits() };
    i32_to_f32 Exactly |t, a, b, c, n| a.to_bits().to_f32().to_bits(); |f, a, b, c, n| (int(a) as f32).to_bits();
    i32_from_bits_f32 Exactly |t, a, b, c, n| a.to_bits().from_bits_f32().to_bits(); |f, a, b, c, n| a.to_bits();
    i32_splat Exactly |t, a, b, c, n| t.splat_i32(n as i32 - 7); |f, a, b, c, n| n.wrapping_sub(7);
}

// Masks: of comparisons.
operations! {
    mask_and Exactly |t, a, b, c, n| truth(t, a.lt(b) & b.lt(c)); |f, a, b, c, n| plain_truth(a < b && b < c);
    mask_or Exactly |t, a, b, c, n| truth(t, a.lt(b) | b.lt(c)); |f, a, b, c, n| plain_truth(a < b || b < c);
    mask_xor Exactly |t, a, b, c, n| truth(t, a.lt(b) ^ b.lt(c)); |f, a, b, c, n| plain_truth((a < b) ^ (b < c));
    mask_not Exactly |t, a, b, c, n| truth(t, !a.lt(b)); |f, a, b, c, n| plain_truth(a.partial_cmp(&b) != Some(std::cmp::Ordering::Less));
    mask_and_not Exactly |t, a, b, c, n| truth(t, a.lt(b).and_not(b.lt(c)));
        |f, a, b, c, n| plain_truth(a < b && b.partial_cmp(&c) != Some(std::cmp::Ordering::Less));
}

/// Folds each vector of a case, and again with one-lane operations in the order that the contract gives.
#[derive(Clone, Copy)]
struct Reduce<'a>(&'a Input);

impl Task for Reduce<'_> {
    type Output = Vec<[f32; 3]>;
    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Self::Output {
        let mut out = Vec::new();
        for at in (0..N).step_by(T::LANES) {
            let lanes = token.load_u32(&self.0.a, at).from_bits_f32();
            out.push([lanes.reduce_min(), lanes.reduce_max(), lanes.reduce_add()]);
        }
        out
    }
}

fn reductions(token: AnyToken) {
    check(inputs(), |input| {
        let got = token.run(Reduce(&input));
        for (lanes, got) in input.a.chunks(token.lanes()).zip(got) {
            let fold = |f: fn(f32, f32) -> f32| {
                let mut lanes: Vec<f32> = lanes.iter().map(|&x| f32::from_bits(x)).collect();
                while lanes.len() > 1 {
                    let high = lanes.split_off(lanes.len() / 2);
                    lanes.iter_mut().zip(high).for_each(|(x, y)| *x = f(*x, y));
                }
                lanes[0]
            };
            assert_eq!(got[0].to_bits(), fold(|a, b| if a < b { a } else { b }).to_bits(), "min of {lanes:x?}");
            assert_eq!(got[1].to_bits(), fold(|a, b| if a > b { a } else { b }).to_bits(), "max of {lanes:x?}");
            let sum = fold(|a, b| a + b);
            assert!(got[2].to_bits() == sum.to_bits() || got[2].is_nan() && sum.is_nan(), "sum of {lanes:x?}");
        }
    });
}
at_every_level!(reductions);

/// A triple whose product needs more bits than an f32 has: (1 + 2^-12)^2 - (1 + 2^-11) is 2^-24, unless the square is
/// rounded first.
struct Triple;

impl Task for Triple {
    type Output = [f32; 3];
    #[inline(always)]
    fn run<T: Token>(self, token: T) -> [f32; 3] {
        let a = token.splat(std::hint::black_box(1.0 + 1.0 / 4096.0));
        let c = token.splat(std::hint::black_box(1.0 + 1.0 / 2048.0));
        [a.mul_add(a, -c).reduce_max(), a.mul_sub(a, c).reduce_max(), a.neg_mul_add(a, c).reduce_max()]
    }
}

fn the_family_says_whether_mul_add_fuses(token: AnyToken) {
    let tiny = 1.0 / 16_777_216.0;
    let want = if token.fused() { [tiny, tiny, -tiny] } else { [0.0, 0.0, 0.0] };
    assert_eq!(token.run(Triple), want);
    assert_eq!(token.twin().run(Triple), want);
}
at_every_level!(the_family_says_whether_mul_add_fuses);

/// Every mask of up to sixteen lanes: made of bits, read as bits, any, all, and as a choice.
struct EveryMask;

impl Task for EveryMask {
    type Output = ();
    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let all = (1u32 << T::LANES) - 1;
        for bits in 0..=all {
            // Bits beyond the last lane do not count.
            let mask = token.mask(bits | !all);
            assert_eq!(mask.bits(), bits);
            assert_eq!((!mask).bits(), !bits & all);
            assert_eq!(mask.any(), bits != 0);
            assert_eq!(mask.all(), bits == all);
            let mut lanes = [0; 16];
            token.splat_i32(1).select(mask, token.splat_i32(2)).store(&mut lanes, 0);
            let mut floats = [0.0; 16];
            token.splat(1.0).select(mask, token.splat(2.0)).store(&mut floats, 0);
            for i in 0..T::LANES {
                let want = if bits >> i & 1 == 1 { 1 } else { 2 };
                assert_eq!((lanes[i], floats[i]), (want, want as f32), "lane {i} of {bits:#b}");
            }
        }
        for n in (0..40).chain([usize::MAX]) {
            let want = if n >= T::LANES { all } else { (1 << n) - 1 };
            assert_eq!(token.first(n).bits(), want, "the first {n}");
        }
    }
}

fn every_mask(token: AnyToken) {
    token.run(EveryMask);
    token.twin().run(EveryMask);
}
at_every_level!(every_mask);

struct Iota;

impl Task for Iota {
    type Output = ([u32; 16], [f32; 16]);
    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Self::Output {
        let mut out = ([0; 16], [0.0; 16]);
        token.iota().store(&mut out.0, 0);
        token.iota().to_f32().store(&mut out.1, 0);
        out
    }
}

fn iota(token: AnyToken) {
    let (integers, floats) = token.run(Iota);
    for i in 0..token.lanes() {
        assert_eq!((integers[i], floats[i]), (i as u32, i as f32));
    }
}
at_every_level!(iota);
