//! The pixel samplers that there are, by name.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use super::{Adaptive, Filter, SingleSample, Sobol};
use crate::choice::UnknownName;
use crate::stack::PixelSampler;

/// A pixel sampler: `single`, or `sobol:N` with N samples a pixel (`sobol` alone: 16), or `sobol:N:FILTER`; or `adaptive:N:THRESHOLD` with
/// up to N.
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
    /// As many samples as a pixel needs.
    Adaptive {
        /// The most.
        samples: u32,
        /// The error at which a pixel is good enough, in millionths.
        threshold: u32,
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
            Self::Adaptive { samples, threshold, filter } => {
                Arc::new(Adaptive::new(samples, threshold as f32 * 1e-6, filter))
            }
        }
    }

    /// So many samples a pixel: one is in its middle.
    pub fn of_samples(samples: u32) -> Self {
        if samples <= 1 { Self::Single } else { Self::Sobol { samples, filter: Filter::default() } }
    }

    /// Up to so many samples a pixel, until its error is below a threshold, from 0.000001 to 1.
    pub fn adaptive(samples: u32, threshold: f64) -> Self {
        let threshold = (threshold * 1e6).round().clamp(1.0, 1e6) as u32;
        Self::Adaptive { samples, threshold, filter: Filter::default() }
    }

    /// How many samples a pixel has; the fewest, where that differs.
    pub fn samples(self) -> u32 {
        match self {
            Self::Single => 1,
            Self::Sobol { samples, .. } => samples,
            Self::Adaptive { .. } => Adaptive::BLOCK,
        }
    }

    /// What renders the same as it does once so many of its samples have been taken; the first one is in the middle of the pixel.
    pub fn after(self, samples: u32) -> Self {
        match self {
            Self::Sobol { samples: all, .. } if samples < all && samples <= 1 => Self::Single,
            Self::Sobol { samples: all, filter } => Self::Sobol { samples: samples.min(all), filter },
            Self::Single | Self::Adaptive { .. } => self,
        }
    }

    /// What pictures are refined with that get a sample more with each frame: as many for all pixels.
    pub fn refined(self) -> Self {
        match self {
            Self::Adaptive { samples, filter, .. } => Self::Sobol { samples, filter },
            other => other,
        }
    }

    /// The same with another filter, where there is one.
    pub fn with_filter(self, filter: Filter) -> Self {
        match self {
            Self::Single => self,
            Self::Sobol { samples, .. } => Self::Sobol { samples, filter },
            Self::Adaptive { samples, threshold, .. } => Self::Adaptive { samples, threshold, filter },
        }
    }

    /// The same with the filter of another, where both have one.
    pub fn filtered_as(self, other: Self) -> Self {
        match other {
            Self::Single => self,
            Self::Sobol { filter, .. } | Self::Adaptive { filter, .. } => self.with_filter(filter),
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
        let adaptive = |text: &str| {
            let mut parts = text.split(':');
            let most = samples(parts.next()?)?;
            let threshold = parts.next()?.parse().ok().filter(|t| (1e-6..=1.0).contains(t))?;
            let filter = parts.next().map_or(Ok(Filter::default()), str::parse).ok()?;
            parts.next().is_none().then(|| Self::adaptive(most, threshold).with_filter(filter))
        };
        let lower = name.to_ascii_lowercase();
        let found = match &*lower {
            "single" => Some(Self::Single),
            "sobol" => sobol("16"),
            name if name.starts_with("adaptive:") => adaptive(&name["adaptive:".len()..]),
            _ => lower.strip_prefix("sobol:").and_then(sobol),
        };
        found.ok_or_else(|| UnknownName {
            kind: "pixel sampler",
            name: name.to_owned(),
            known: format!(
                "single, sobol, sobol:N (N samples, from 1 to {}), sobol:N:FILTER (box, gaussian or mitchell), \
                 adaptive:N:THRESHOLD (up to N samples, until the error is below it)",
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
            Self::Adaptive { samples, threshold, filter } => {
                write!(f, "adaptive:{samples}:{}", f64::from(*threshold) / 1e6)?;
                if *filter == Filter::default() { Ok(()) } else { write!(f, ":{filter}") }
            }
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
        for name in [
            "single",
            "adaptive:256:0.005",
            "adaptive:64:0.000001:box",
            "sobol:1",
            "sobol:65536",
            "sobol:4:box",
            "sobol:5:mitchell",
        ] {
            assert_eq!(name.parse::<SamplerKind>().unwrap().to_string(), name);
        }
        for name in [
            "",
            "sobol:0",
            "sobol:65537",
            "sobol:x",
            "sobol:4:sinc",
            "sobol:4:",
            "adaptive",
            "adaptive:4",
            "adaptive:4:0",
        ] {
            assert!(name.parse::<SamplerKind>().unwrap_err().to_string().contains("sobol:N"));
        }
    }
}
