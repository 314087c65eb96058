//! The load balancers that there are, by name.

use std::str::FromStr;

use super::{ByCost, ByThreads, Cyclic, LoadBalancer, Static, WorkQueue};

/// The balancers that can be chosen at run time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BalancerKind {
    /// `auto`: [`ByThreads`].
    #[default]
    Auto,
    /// `work-queue`, or `work-queue:G` with the granularity G: [`WorkQueue`].
    WorkQueue {
        /// See [`WorkQueue::new`].
        granularity: usize,
    },
    /// `by-cost`: [`ByCost`].
    ByCost,
    /// `cyclic`: [`Cyclic`].
    Cyclic,
    /// `static`: [`Static`].
    Static,
}

/// A name that is no balancer's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unknown load balancer '{0}': use auto, work-queue, work-queue:GRANULARITY (1 or more), by-cost, cyclic or static"
)]
pub struct UnknownBalancer(pub String);

impl BalancerKind {
    /// Makes the balancer.
    pub fn build(self) -> Box<dyn LoadBalancer> {
        match self {
            Self::Auto => Box::new(ByThreads::default()),
            Self::WorkQueue { granularity } => Box::new(WorkQueue::new(granularity)),
            Self::ByCost => Box::new(ByCost::default()),
            Self::Cyclic => Box::new(Cyclic::default()),
            Self::Static => Box::new(Static::default()),
        }
    }
}

impl FromStr for BalancerKind {
    type Err = UnknownBalancer;

    fn from_str(name: &str) -> Result<Self, UnknownBalancer> {
        let lower = name.to_ascii_lowercase();
        match &*lower {
            "auto" => Ok(Self::Auto),
            "work-queue" => Ok(Self::WorkQueue { granularity: WorkQueue::GRANULARITY }),
            "by-cost" => Ok(Self::ByCost),
            "cyclic" => Ok(Self::Cyclic),
            "static" => Ok(Self::Static),
            _ => {
                let granularity = lower.strip_prefix("work-queue:").and_then(|text| text.parse().ok());
                let granularity = granularity.filter(|&granularity| granularity > 0);
                granularity
                    .map(|granularity| Self::WorkQueue { granularity })
                    .ok_or_else(|| UnknownBalancer(name.to_owned()))
            }
        }
    }
}

impl std::fmt::Display for BalancerKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::WorkQueue { granularity: WorkQueue::GRANULARITY } => f.write_str("work-queue"),
            Self::WorkQueue { granularity } => write!(f, "work-queue:{granularity}"),
            Self::ByCost => f.write_str("by-cost"),
            Self::Cyclic => f.write_str("cyclic"),
            Self::Static => f.write_str("static"),
        }
    }
}
