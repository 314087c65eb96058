//! Scaling: what more threads buy on this machine, and what more processors would buy.
//!
//! Source: Bigler, Stephens and Parker 2006, section 6.1 and Figure 8. [`measure()`] times frames on the threads that
//! there are and takes the costs of a frame apart; [`project`] plays frames on the processors that there are not, with
//! the real load balancer and these costs; with the command, `plot::svg` draws both beside the paper's figures.

pub mod measure;
#[cfg(feature = "cli")]
pub mod plot;
pub mod simulate;

pub use measure::{Measurement, Plan, ThreadRun, measure};
pub use simulate::{Costs, Dealt, FrameCosts, Lost, Projection, project};

/// Processors and efficiency that the paper reports (section 6.1).
pub const PAPER: [(usize, f64); 2] = [(64, 0.92), (126, 0.82)];

/// Processors that the projection is for.
pub const PROCESSORS: [usize; 9] = [2, 4, 8, 16, 32, 64, 126, 256, 512];

/// The middle of some numbers; 0 of none.
pub(crate) fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let count = numbers.len();
    match count {
        0 => 0.0,
        _ if count % 2 == 1 => numbers[count / 2],
        _ => (numbers[count / 2 - 1] + numbers[count / 2]) / 2.0,
    }
}
