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

    /// What renders the same as it does once so many of its samples have been taken; the first one is in the middle of the pixel.
    pub fn after(self, samples: u32) -> Self {
        match self {
            Self::Sobol { samples: all, .. } if samples < all && samples <= 1 => Self::Single,
            Self::Sobol { samples: all, filter } => Self::Sobol { samples: samples.min(all), filter },
            Self::Single => self,
        }
    }

    /// The same with another filter, where there is one.
    pub fn with_filter(self, filter: Filter) -> Self {
        match self {
            Self::Single => self,
            Self::Sobol { samples, .. } => Self::Sobol { samples, filter },
        }
    }

    /// The same with the filter of another, where both have one.
    pub fn filtered_as(self, other: Self) -> Self {
        match other {
            Self::Single => self,
            Self::Sobol { filter, .. } => self.with_filter(filter),
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
    fn part_of_the_samples_is_a_sampler_too() {
        let sampler: SamplerKind = "sobol:16:box".parse().unwrap();
        let names = [0, 1, 7, 16, 99].map(|samples| sampler.after(samples).to_string());
        assert_eq!(names, ["single", "single", "sobol:7:box", "sobol:16:box", "sobol:16:box"]);
        assert_eq!(SamplerKind::Single.after(7), SamplerKind::Single);
    }

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
