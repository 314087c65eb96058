//! The pixel samplers that there are, by name.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use super::{Jittered, SingleSample};
use crate::choice::UnknownName;
use crate::stack::PixelSampler;

/// A pixel sampler: `single`, or `jittered:K` with K x K samples a pixel (`jittered` alone: 3 x 3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SamplerKind {
    /// One sample in the middle of each pixel.
    #[default]
    Single,
    /// A grid of samples in each pixel, each jittered in its cell.
    Jittered {
        /// Samples along a pixel's side, 1 to 32.
        side: u32,
    },
}

impl SamplerKind {
    /// Makes it.
    pub fn build(self) -> Arc<dyn PixelSampler> {
        match self {
            Self::Single => Arc::new(SingleSample),
            Self::Jittered { side } => Arc::new(Jittered::new(side)),
        }
    }
}

impl FromStr for SamplerKind {
    type Err = UnknownName;
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        let side = |k: &str| k.parse().ok().filter(|k| (1..=Jittered::MOST).contains(k));
        let jittered = |k: &str| side(k).map(|side| Self::Jittered { side });
        let lower = name.to_ascii_lowercase();
        let found = match &*lower {
            "single" => Some(Self::Single),
            "jittered" => Some(Self::Jittered { side: 3 }),
            _ => lower.strip_prefix("jittered:").and_then(jittered),
        };
        found.ok_or_else(|| UnknownName {
            kind: "pixel sampler",
            name: name.to_owned(),
            known: format!("single, jittered, jittered:K (K x K samples, K from 1 to {})", Jittered::MOST),
        })
    }
}

impl fmt::Display for SamplerKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Single => f.write_str("single"),
            Self::Jittered { side } => write!(f, "jittered:{side}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_to_samplers_and_back() {
        for name in ["single", "jittered:1", "jittered:32"] {
            assert_eq!(name.parse::<SamplerKind>().unwrap().to_string(), name);
        }
        for name in ["", "jittered:0", "jittered:33", "jittered:x", "adaptive"] {
            assert!(name.parse::<SamplerKind>().unwrap_err().to_string().contains("jittered:K"));
        }
    }
}
