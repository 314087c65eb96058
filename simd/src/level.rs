//! The names of the instruction sets.

use core::fmt::{self, Display};
use core::str::FromStr;

/// An instruction set, least first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// One lane, unfused.
    Scalar,
    /// Four lanes, unfused: SSE2, and NEON or simd128 on processors that have those instead.
    Sse2,
    /// Eight lanes, fused: AVX2 and FMA.
    Avx2,
    /// Sixteen lanes, fused: AVX-512 F, BW, DQ and VL.
    Avx512,
}

impl Level {
    /// Every level, least first.
    pub const ALL: [Self; 4] = [Self::Scalar, Self::Sse2, Self::Avx2, Self::Avx512];

    /// Its name in lower case, as `MOBULA_ISA` and `--isa` spell it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Sse2 => "sse2",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }
}

impl Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Level {
    type Err = UnknownLevel;

    /// Its [`name`](Self::name), in upper or lower case.
    fn from_str(name: &str) -> Result<Self, UnknownLevel> {
        Self::ALL.into_iter().find(|level| level.name().eq_ignore_ascii_case(name)).ok_or(UnknownLevel)
    }
}

/// A name that no [`Level`] has. Its message lists those that exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownLevel;

impl Display for UnknownLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("unknown level: the levels are ")?;
        list(f, Level::ALL.into_iter())
    }
}

impl core::error::Error for UnknownLevel {}

/// `a, b, c`
pub(crate) fn list(f: &mut fmt::Formatter<'_>, levels: impl Iterator<Item = Level>) -> fmt::Result {
    for (i, level) in levels.enumerate() {
        f.write_str(if i == 0 { "" } else { ", " })?;
        f.write_str(level.name())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn names_round_trip() {
        for level in Level::ALL {
            assert_eq!(level.to_string().parse(), Ok(level));
        }
    }

    #[test]
    fn names_are_read_in_any_case() {
        for level in Level::ALL {
            assert_eq!(level.name().to_uppercase().parse(), Ok(level));
        }
        assert_eq!("Sse2".parse(), Ok(Level::Sse2));
    }

    #[test]
    fn unknown_names_list_the_valid_ones() {
        let error = "avx".parse::<Level>().unwrap_err();
        assert_eq!(error.to_string(), "unknown level: the levels are scalar, sse2, avx2, avx512");
        assert!("".parse::<Level>().is_err() && "AVX 2".parse::<Level>().is_err());
    }
}
