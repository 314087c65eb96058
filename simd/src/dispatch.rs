//! Choosing a level at run time.

use core::fmt::{self, Display};

use crate::level::list;
#[cfg(target_arch = "x86_64")]
use crate::{Avx2, Fused};
use crate::{Level, Scalar, Task, Token};

/// A token of a level chosen at run time: one branch into a kernel family, once per packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AnyToken {
    /// One unfused lane.
    Scalar(Scalar),
    /// One fused lane: a twin, which detection never chooses.
    #[cfg(target_arch = "x86_64")]
    Fused(Fused),
    /// Eight fused lanes.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
}

/// Does `$body` with the token of whichever variant it is.
macro_rules! with_token {
    ($any:expr, $token:ident => $body:expr) => {
        match $any {
            AnyToken::Scalar($token) => $body,
            #[cfg(target_arch = "x86_64")]
            AnyToken::Fused($token) => $body,
            #[cfg(target_arch = "x86_64")]
            AnyToken::Avx2($token) => $body,
        }
    };
}

impl AnyToken {
    /// The best level that this machine has.
    #[must_use]
    pub fn detect() -> Self {
        Self::available().last().unwrap_or(Self::Scalar(Scalar::new()))
    }

    /// The token of one level.
    ///
    /// # Errors
    /// [`Unavailable`], if this machine does not have it.
    pub fn for_level(level: Level) -> Result<Self, Unavailable> {
        match level {
            Level::Scalar => Some(Self::Scalar(Scalar::new())),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => Avx2::detect().map(Self::Avx2),
            _ => None,
        }
        .ok_or(Unavailable(level))
    }

    /// The levels that this machine has, least first. The fused twin is not among them: see [`twin`](Self::twin).
    pub fn available() -> impl Iterator<Item = Self> {
        Level::ALL.into_iter().filter_map(|level| Self::for_level(level).ok())
    }

    /// Its level. The fused twin's is [`Level::Avx2`], whose instructions it needs.
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
    pub fn twin(self) -> Self {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Fused(token) => Self::Fused(token),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(token) => Self::Fused(token.fused()),
            _ => Self::Scalar(Scalar::new()),
        }
    }

    /// Runs `task` in a region compiled for this level.
    #[inline]
    pub fn run<K: Task>(self, task: K) -> K::Output {
        with_token!(self, token => token.run(task))
    }
}

/// A level that this machine does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unavailable(pub Level);

impl Display for Unavailable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "level {} is not available on this machine, which has ", self.0)?;
        list(f, AnyToken::available().map(AnyToken::level))
    }
}

impl core::error::Error for Unavailable {}
