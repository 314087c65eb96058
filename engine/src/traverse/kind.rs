//! The traversers that can be chosen at run time, by name.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

use super::{Deadline, ImageTraverser, NullTraverser, Progressive, TileSize, Tiled};
use crate::balance::BalancerKind;

/// A traverser and its parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum TraverserKind {
    /// `tiled`: [`Tiled`].
    #[default]
    Tiled,
    /// `progressive`: [`Progressive`].
    Progressive,
    /// `deadline:MS`, a time limit in milliseconds: [`Deadline`].
    Deadline(Duration),
    /// `null`: [`NullTraverser`].
    Null,
}

/// A name that is no traverser's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown image traverser '{0}': use tiled, progressive, deadline:MILLISECONDS or null")]
pub struct UnknownTraverser(pub String);

impl TraverserKind {
    /// Makes the traverser.
    pub fn build(self, tile: TileSize, balancer: BalancerKind) -> Box<dyn ImageTraverser> {
        match self {
            Self::Tiled => Box::new(Tiled::new(tile, balancer.build())),
            Self::Progressive => Box::new(Progressive::new(tile, balancer.build(), Progressive::COARSEST)),
            Self::Deadline(limit) => Box::new(Deadline::new(tile, balancer.build(), limit)),
            Self::Null => Box::new(NullTraverser),
        }
    }
}

impl fmt::Display for TraverserKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tiled => f.write_str("tiled"),
            Self::Progressive => f.write_str("progressive"),
            Self::Deadline(limit) => write!(f, "deadline:{}", limit.as_secs_f64() * 1e3),
            Self::Null => f.write_str("null"),
        }
    }
}

impl FromStr for TraverserKind {
    type Err = UnknownTraverser;

    fn from_str(name: &str) -> Result<Self, UnknownTraverser> {
        let lower = name.to_ascii_lowercase();
        match &*lower {
            "tiled" => Ok(Self::Tiled),
            "progressive" => Ok(Self::Progressive),
            "null" => Ok(Self::Null),
            _ => {
                let limit = lower.strip_prefix("deadline:").and_then(|text| text.parse::<f64>().ok());
                let limit = limit.filter(|limit| *limit > 0.0);
                let limit = limit.and_then(|limit| Duration::try_from_secs_f64(limit / 1000.0).ok());
                limit.map(Self::Deadline).ok_or_else(|| UnknownTraverser(name.to_owned()))
            }
        }
    }
}
