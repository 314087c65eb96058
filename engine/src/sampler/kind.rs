//! The pixel samplers that there are, by name.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use super::{Filter, SingleSample, Sobol};
use crate::choice::UnknownName;
use crate::stack::PixelSampler;

/// A pixel sampler: `single`, or `sobol:N` with N samples a pixel (`sobol` alone: 16), or `sobol:N:FILTER`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SamplerKind {
    /// One sample in the middle of each pixel.
    #[default]
    Single,
    /// Several samples a pixel, spread evenly.
    Sobol {
        /// How many.
        samples: u32,
        /// What a pixel shows of the picture around it.
        filter: Filter,
    },
}

impl SamplerKind {
    /// Makes it.
    pub fn build(self) -> Arc<dyn PixelSampler> {
        match self {
            Self::Single => Arc::new(SingleSample),
            Self::Sobol { samples, filter } => Arc::new(Sobol::new(samples, filter)),
        }
    }

    /// So many samples a pixel: one is in its middle.
    pub fn of_samples(samples: u32) -> Self {
        if samples <= 1 { Self::Single } else { Self::Sobol { samples, filter: Filter::default() } }
    }

    /// How many samples a pixel has.
    pub fn samples(self) -> u32 {
        match self {
            Self::Single => 1,
            Self::Sobol { samples, .. } => samples,
        }
    }

    /// The same with another filter, where there is one.
    pub fn with_filter(self, filter: Filter) -> Self {
        match self {
            Self::Single => self,
            Self::Sobol { samples, .. } => Self::Sobol { samples, filter },
        }
    }
}

impl FromStr for SamplerKind {
    type Err = UnknownName;
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        let samples = |n: &str| n.parse().ok().filter(|n| (1..=Sobol::MOST).contains(n));
        let sobol = |text: &str| {
            let (n, filter) =
                text.split_once(':').map_or((text, Ok(Filter::default())), |(n, filter)| (n, filter.parse()));
            Some(Self::Sobol { samples: samples(n)?, filter: filter.ok()? })
        };
        let lower = name.to_ascii_lowercase();
        let found = match &*lower {
            "single" => Some(Self::Single),
            "sobol" => sobol("16"),
            _ => lower.strip_prefix("sobol:").and_then(sobol),
        };
        found.ok_or_else(|| UnknownName {
            kind: "pixel sampler",
            name: name.to_owned(),
            known: format!(
                "single, sobol, sobol:N (N samples, from 1 to {}), sobol:N:FILTER (box, gaussian or mitchell)",
                Sobol::MOST
            ),
        })
    }
}

impl fmt::Display for SamplerKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Single => f.write_str("single"),
            Self::Sobol { samples, filter } if *filter == Filter::default() => write!(f, "sobol:{samples}"),
            Self::Sobol { samples, filter } => write!(f, "sobol:{samples}:{filter}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_to_samplers_and_back() {
        for name in ["single", "sobol:1", "sobol:65536", "sobol:4:box", "sobol:5:mitchell"] {
            assert_eq!(name.parse::<SamplerKind>().unwrap().to_string(), name);
        }
        for name in ["", "sobol:0", "sobol:65537", "sobol:x", "sobol:4:sinc", "sobol:4:", "adaptive"] {
            assert!(name.parse::<SamplerKind>().unwrap_err().to_string().contains("sobol:N"));
        }
    }
}
