//! The inputs of the tests, and the comparison of what comes out.

use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

/// Numbers per case: a multiple of every lane width.
pub(crate) const N: usize = 64;

/// A case: three packets of bit patterns, which a test reads as floats or as integers, and one number for all lanes.
#[derive(Clone, Debug)]
pub(crate) struct Input {
    pub(crate) a: [u32; N],
    pub(crate) b: [u32; N],
    pub(crate) c: [u32; N],
    pub(crate) n: u32,
}

/// Bit patterns of all kinds of floats: every one of them now and then, the edges often.
pub(crate) fn lane() -> impl Strategy<Value = u32> {
    const EDGES: [f32; 20] = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        f32::MIN_POSITIVE,
        -f32::MIN_POSITIVE,
        f32::MAX,
        f32::MIN,
        f32::EPSILON,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        // Around the ends of i32, and of the integers that f32 holds exactly.
        2_147_483_648.0,
        -2_147_483_648.0,
        2_147_483_520.0,
        -2_147_483_904.0,
        16_777_216.0,
        8_388_607.5,
        0.999_999_94,
    ];
    const PATTERNS: [u32; 9] =
        [1, 0x8000_0001, 0x007f_ffff, 0x7f80_0001, 0xff80_0001, 0x7fc0_1234, 0xffff_ffff, 0x7fff_ffff, 0x8000_0000];
    prop_oneof![
        3 => proptest::num::f32::ANY.prop_map(f32::to_bits),
        2 => any::<u32>(),
        3 => (-32i8..=32).prop_map(|n| (f32::from(n) * 0.25).to_bits()),
        2 => prop::sample::select(&EDGES[..]).prop_map(f32::to_bits),
        2 => prop::sample::select(&PATTERNS[..]),
        1 => proptest::num::f32::SUBNORMAL.prop_map(f32::to_bits),
        1 => (1e30f32..3e38).prop_map(f32::to_bits),
        1 => (-4i32..=4).prop_map(|n| n as u32),
    ]
}

/// Cases of [`lane`]s.
pub(crate) fn inputs() -> impl Strategy<Value = Input> {
    let packet = || prop::collection::vec(lane(), N).prop_map(|lanes| <[u32; N]>::try_from(lanes).unwrap());
    (packet(), packet(), packet(), 0u32..32).prop_map(|(a, b, c, n)| Input { a, b, c, n })
}

/// Runs `test` on many cases; proptest shrinks the one that fails.
pub(crate) fn check<S: Strategy>(strategy: S, test: impl Fn(S::Value)) {
    let config = Config { failure_persistence: None, ..Config::default() };
    let outcome = TestRunner::new(config).run(&strategy, |value| {
        test(value);
        Ok(())
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
}

/// Does a result that the hardware computed agree with what it should be?
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Agree {
    /// Bit for bit.
    Exactly,
    /// Bit for bit, except that one NaN is as good as another: the arithmetic operations.
    UpToNan,
}

impl Agree {
    /// Panics where two packets differ.
    pub(crate) fn assert(self, got: &[u32; N], want: &[u32; N], input: &Input) {
        for i in 0..N {
            let nan = self == Self::UpToNan && f32::from_bits(got[i]).is_nan() && f32::from_bits(want[i]).is_nan();
            assert!(
                nan || got[i] == want[i],
                "lane {i}: got {:#010x}, want {:#010x}, of a={:#010x} b={:#010x} c={:#010x} n={}",
                got[i],
                want[i],
                input.a[i],
                input.b[i],
                input.c[i],
                input.n
            );
        }
    }
}
