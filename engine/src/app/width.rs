//! Packet widths that can be chosen at run time: a number becomes a const generic.

use std::fmt;
use std::str::FromStr;

use mobula_simd::Level;

/// How many rays a packet holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum PacketWidth {
    /// Single rays.
    W1,
    /// 4 x 2 pixels.
    W8,
    /// 4 x 4 pixels.
    W16,
    /// 8 x 8 pixels.
    W64,
    /// 16 x 16 pixels.
    W256,
}

impl PacketWidth {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::W1, Self::W8, Self::W16, Self::W64, Self::W256];

    /// The fastest for whole frames at a level, as measured (`benches/record`).
    pub const fn best(level: Level) -> Self {
        match level {
            Level::Scalar | Level::Sse2 => Self::W64,
            Level::Avx2 | Level::Avx512 => Self::W256,
        }
    }

    /// The number of rays.
    pub const fn rays(self) -> usize {
        match self {
            Self::W1 => 1,
            Self::W8 => 8,
            Self::W16 => 16,
            Self::W64 => 64,
            Self::W256 => 256,
        }
    }
}

/// A packet width that the engine was not built for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("packets hold 1, 8, 16, 64 or 256 rays, not {0}")]
pub struct UnknownWidth(String);

impl FromStr for PacketWidth {
    type Err = UnknownWidth;

    fn from_str(text: &str) -> Result<Self, UnknownWidth> {
        let found = Self::ALL.into_iter().find(|width| text.parse() == Ok(width.rays()));
        found.ok_or_else(|| UnknownWidth(text.to_owned()))
    }
}

impl fmt::Display for PacketWidth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.rays())
    }
}

/// Evaluates an expression with a constant set to the rays of a [`PacketWidth`]:
/// `with_packet_width!(width, N => build::<N>())`. All arms must have one type.
#[macro_export]
macro_rules! with_packet_width {
    ($width:expr, $n:ident => $body:expr) => {
        $crate::with_packet_width!(@ $width, $n, $body, W1 1, W8 8, W16 16, W64 64, W256 256)
    };
    (@ $width:expr, $n:ident, $body:expr, $($variant:ident $rays:literal),+) => {
        match $width {
            $($crate::app::PacketWidth::$variant => {
                const $n: usize = $rays;
                $body
            })+
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_constants_and_numbers_agree() {
        for width in PacketWidth::ALL {
            assert_eq!(width.to_string().parse(), Ok(width));
            assert_eq!(with_packet_width!(width, N => [(); N].len()), width.rays());
        }
        for bad in ["", "0", "2", "64 ", "-1", "99999999999999999999"] {
            assert!(bad.parse::<PacketWidth>().is_err());
        }
    }
}
