//! Choosing a level at run time.

use core::fmt::{self, Display};

#[cfg(feature = "sse2")]
use crate::Sse2;
#[cfg(feature = "std")]
use crate::UnknownLevel;
use crate::level::list;
use crate::{Level, Scalar, Task, Token};

#[cfg(all(target_arch = "x86_64", feature = "avx2"))]
use crate::Avx2;
#[cfg(all(target_arch = "x86_64", feature = "avx512"))]
use crate::Avx512;
#[cfg(all(target_arch = "x86_64", any(feature = "avx2", feature = "avx512")))]
use crate::Fused;

/// What runs a task in a region compiled for some level that is known at run time only.
pub trait Dispatch: Copy {
    /// Runs `task` there.
    fn dispatch<K: Task>(self, task: K) -> K::Output;
}

/// A token of a level chosen at run time: one branch into a kernel family, once per packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AnyToken {
    /// One unfused lane.
    Scalar(Scalar),
    /// Four unfused lanes.
    #[cfg(feature = "sse2")]
    Sse2(Sse2),
    /// Eight fused lanes.
    #[cfg(all(target_arch = "x86_64", feature = "avx2"))]
    Avx2(Avx2),
    /// Sixteen fused lanes.
    #[cfg(all(target_arch = "x86_64", feature = "avx512"))]
    Avx512(Avx512),
}

/// Does `$body` with the token of whichever variant it is.
macro_rules! with_token {
    ($any:expr, $token:ident => $body:expr) => {
        match $any {
            AnyToken::Scalar($token) => $body,
            #[cfg(feature = "sse2")]
            AnyToken::Sse2($token) => $body,
            #[cfg(all(target_arch = "x86_64", feature = "avx2"))]
            AnyToken::Avx2($token) => $body,
            #[cfg(all(target_arch = "x86_64", feature = "avx512"))]
            AnyToken::Avx512($token) => $body,
        }
    };
}

impl AnyToken {
    /// The best level that this machine has.
    #[must_use]
    pub fn detect() -> Self {
        Self::available().last().unwrap_or(Self::Scalar(Scalar::new()))
    }

    /// The level that the environment variable `MOBULA_ISA` names, in upper or lower case, or the best one if it is unset or empty.
    ///
    /// # Errors
    /// [`EnvError`], if it names no level, or one that this machine does not have.
    #[cfg(feature = "std")]
    pub fn from_env() -> Result<Self, EnvError> {
        match std::env::var_os(EnvError::VARIABLE) {
            Some(value) => Self::from_env_value(&value.to_string_lossy()),
            None => Ok(Self::detect()),
        }
    }

    #[cfg(feature = "std")]
    fn from_env_value(value: &str) -> Result<Self, EnvError> {
        if value.is_empty() {
            return Ok(Self::detect());
        }
        let level = value.parse().map_err(|error| EnvError::Unknown(value.into(), error))?;
        Self::for_level(level).map_err(EnvError::Unavailable)
    }

    /// The token of one level.
    ///
    /// # Errors
    /// [`Unavailable`], if this machine does not have it.
    pub fn for_level(level: Level) -> Result<Self, Unavailable> {
        match level {
            Level::Scalar => Some(Self::Scalar(Scalar::new())),
            #[cfg(feature = "sse2")]
            Level::Sse2 => Some(Self::Sse2(Sse2::new())),
            #[cfg(all(target_arch = "x86_64", feature = "avx2"))]
            Level::Avx2 => Avx2::detect().map(Self::Avx2),
            #[cfg(all(target_arch = "x86_64", feature = "avx512"))]
            Level::Avx512 => Avx512::detect().map(Self::Avx512),
            #[allow(unreachable_patterns, reason = "levels that this build or this processor family does not have")]
            _ => None,
        }
        .ok_or(Unavailable(level))
    }

    /// The levels that this machine has, least first.
    pub fn available() -> impl Iterator<Item = Self> {
        Level::ALL.into_iter().filter_map(|level| Self::for_level(level).ok())
    }

    /// Its level.
    #[must_use]
    pub fn level(self) -> Level {
        fn level<T: Token>(_: T) -> Level {
            T::LEVEL
        }
        with_token!(self, token => level(token))
    }

    /// Lanes per vector.
    #[must_use]
    pub fn lanes(self) -> usize {
        fn lanes<T: Token>(_: T) -> usize {
            T::LANES
        }
        with_token!(self, token => lanes(token))
    }

    /// Does `mul_add` round once?
    #[must_use]
    pub fn fused(self) -> bool {
        fn fused<T: Token>(_: T) -> bool {
            T::FUSED
        }
        with_token!(self, token => fused(token))
    }

    /// The one-lane token of the same numeric family, whose results must be the same bits.
    #[must_use]
    pub fn twin(self) -> Twin {
        match self {
            Self::Scalar(_) => Twin::Scalar(Scalar::new()),
            #[cfg(feature = "sse2")]
            Self::Sse2(_) => Twin::Scalar(Scalar::new()),
            #[cfg(all(target_arch = "x86_64", feature = "avx2"))]
            Self::Avx2(token) => Twin::Fused(token.fused()),
            #[cfg(all(target_arch = "x86_64", feature = "avx512"))]
            Self::Avx512(token) => Twin::Fused(token.avx2().fused()),
        }
    }

    /// Runs `task` in a region compiled for this level.
    #[inline]
    pub fn run<K: Task>(self, task: K) -> K::Output {
        with_token!(self, token => token.run(task))
    }
}

impl Dispatch for AnyToken {
    #[inline]
    fn dispatch<K: Task>(self, task: K) -> K::Output {
        self.run(task)
    }
}

/// The one-lane token of a numeric family: what its levels are checked against. It is apart from [`AnyToken`] so that only
/// what is checked is compiled for one fused lane, which no program chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Twin {
    /// One unfused lane.
    Scalar(Scalar),
    /// One fused lane.
    #[cfg(all(target_arch = "x86_64", any(feature = "avx2", feature = "avx512")))]
    Fused(Fused),
}

impl Twin {
    /// Runs `task` in a region compiled for it.
    #[inline]
    pub fn run<K: Task>(self, task: K) -> K::Output {
        match self {
            Self::Scalar(token) => token.run(task),
            #[cfg(all(target_arch = "x86_64", any(feature = "avx2", feature = "avx512")))]
            Self::Fused(token) => token.run(task),
        }
    }
}

impl Dispatch for Twin {
    #[inline]
    fn dispatch<K: Task>(self, task: K) -> K::Output {
        self.run(task)
    }
}

/// A level that this machine does not have. Its message says which it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unavailable(pub Level);

impl Display for Unavailable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "level {} is not available on this machine, which has ", self.0)?;
        list(f, AnyToken::available().map(AnyToken::level))
    }
}

impl core::error::Error for Unavailable {}

/// What was wrong with the environment variable `MOBULA_ISA`.
#[cfg(feature = "std")]
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EnvError {
    /// Its value, which names no level.
    Unknown(std::string::String, UnknownLevel),
    /// It names a level that this machine does not have.
    Unavailable(Unavailable),
}

#[cfg(feature = "std")]
impl EnvError {
    /// The name of the variable.
    pub const VARIABLE: &'static str = "MOBULA_ISA";
}

#[cfg(feature = "std")]
impl Display for EnvError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(value, error) => write!(f, "{}={value:?}: {error}", Self::VARIABLE),
            Self::Unavailable(error) => write!(f, "{}={}: {error}", Self::VARIABLE, error.0),
        }
    }
}

#[cfg(feature = "std")]
impl core::error::Error for EnvError {}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn detection_chooses_the_best_available_level() {
        assert_eq!(AnyToken::available().last(), Some(AnyToken::detect()));
        assert!(AnyToken::available().map(AnyToken::level).is_sorted());
        assert_eq!(AnyToken::available().next(), Some(AnyToken::Scalar(Scalar::new())));
    }

    #[test]
    fn a_twin_has_one_lane_of_the_same_family() {
        struct Kind;
        impl Task for Kind {
            type Output = (usize, bool);
            #[inline(always)]
            fn run<T: Token>(self, _: T) -> (usize, bool) {
                (T::LANES, T::FUSED)
            }
        }
        for token in AnyToken::available() {
            assert_eq!(token.dispatch(Kind), (token.lanes(), token.fused()));
            assert_eq!(token.twin().dispatch(Kind), (1, token.fused()));
        }
    }

    #[test]
    fn a_level_is_available_or_says_what_is() {
        for level in Level::ALL {
            match AnyToken::for_level(level) {
                Ok(token) => assert_eq!(token.level(), level),
                Err(error) => {
                    let message = error.to_string();
                    assert!(message.contains(level.name()) && message.contains("which has scalar, sse2"), "{message}");
                }
            }
        }
    }

    #[cfg(feature = "std")]
    #[test]
    fn the_environment_chooses_a_level() {
        assert_eq!(AnyToken::from_env_value(""), Ok(AnyToken::detect()));
        for token in AnyToken::available() {
            assert_eq!(AnyToken::from_env_value(token.level().name()), Ok(token));
            assert_eq!(AnyToken::from_env_value(&token.level().name().to_uppercase()), Ok(token));
        }
    }

    #[cfg(feature = "std")]
    #[test]
    fn a_bad_environment_is_an_error_that_names_it() {
        let error = AnyToken::from_env_value("neon").unwrap_err();
        assert_eq!(error.to_string(), r#"MOBULA_ISA="neon": unknown level: the levels are scalar, sse2, avx2, avx512"#);
        let error = EnvError::Unavailable(Unavailable(Level::Avx512)).to_string();
        assert!(
            error.starts_with("MOBULA_ISA=avx512: level avx512 is not available on this machine, which has scalar"),
            "{error}"
        );
    }
}
