//! Lanes convert to and from the vectors of `wide` lane by lane.

use crate::levels::at_every_level;
use mobula_simd::{AnyToken, F32Lanes, Token, wide};

/// Bits that an operation on floats might not keep.
const LANES: [u32; 16] =
    [0, 0x8000_0000, 1, 0x7f80_0001, 0x7fc0_0123, 0xff80_0001, 6, 7, 8, 9, 10, 11, 12, 13, 14, 0xffff_ffff];

macro_rules! round_trip {
    ($token:expr, $vector:ty, $width:literal) => {{
        let token = $token;
        let lanes: [f32; $width] = std::array::from_fn(|i| f32::from_bits(LANES[i]));
        let mut stored = [0.0; $width];
        token.from_wide(<$vector>::new(lanes)).store(&mut stored, 0);
        assert_eq!(stored.map(f32::to_bits), lanes.map(f32::to_bits));
        assert_eq!(token.load(&lanes, 0).to_wide().to_array().map(f32::to_bits), lanes.map(f32::to_bits));
    }};
}

fn wide_round_trip(token: AnyToken) {
    match token {
        AnyToken::Sse2(token) => round_trip!(token, wide::f32x4, 4),
        #[cfg(target_arch = "x86_64")]
        AnyToken::Avx2(token) => round_trip!(token, wide::f32x8, 8),
        #[cfg(target_arch = "x86_64")]
        AnyToken::Avx512(token) => round_trip!(token, wide::f32x16, 16),
        // One lane is an f32.
        _ => assert_eq!(token.lanes(), 1),
    }
}
at_every_level!(wide_round_trip);
