//! How far particles are apart, from which a radius can be guessed.

use super::{ParticleStep, Particles};

/// So many particles are looked at.
const SAMPLES: usize = 4096;

impl ParticleStep {
    /// The mean distance of neighbours, if particles fill their bounds evenly; `None` if that says nothing. A few particles far from
    /// the rest do not count.
    pub fn spacing(&self) -> Option<f32> {
        let count = self.centers.len();
        let step = count.div_ceil(SAMPLES).max(1);
        let sizes = [0, 1, 2].map(|k| {
            let all = self.centers.iter().step_by(step).map(|center| f64::from(center[k]));
            let mut all: Vec<f64> = all.filter(|x| x.is_finite()).collect();
            all.sort_unstable_by(f64::total_cmp);
            if all.is_empty() {
                return 0.0;
            }
            // What is between the first and the last sixteenth, as if the rest went on like that.
            let at = |share: usize| all[(all.len() - 1) * share / 16];
            let [inner, outer] = [(at(15) - at(1)) * 16.0 / 14.0, at(16) - at(0)];
            if inner > 0.0 { inner.min(outer) } else { outer }
        });
        // A sheet and a line fill no volume.
        let most = sizes.into_iter().fold(0.0, f64::max);
        let filled: Vec<f64> = sizes.into_iter().filter(|size| *size > most * 1e-4).collect();
        if filled.is_empty() {
            return None;
        }
        let root = 1.0 / filled.len() as f64;
        let spacing = filled.iter().map(|size| size.powf(root)).product::<f64>() / (count as f64).powf(root);
        Some(spacing as f32).filter(|spacing| spacing.is_normal())
    }
}

impl Particles {
    /// A radius for particles that have none: half of the mean distance of neighbours in the step with the most particles, so that it
    /// is the same in all steps; 1 where that says nothing.
    pub fn guessed_radius(&self) -> f32 {
        let longest = self.read().max_by_key(|step| step.centers.len());
        longest.and_then(|step| step.spacing()).map_or(1.0, |spacing| spacing / 2.0)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    fn radius(centers: impl Iterator<Item = [f32; 3]>) -> f32 {
        let step = ParticleStep { centers: centers.collect(), ..ParticleStep::default() };
        Particles::in_memory("", vec![Arc::default(), Arc::new(step)]).guessed_radius()
    }

    #[test]
    fn radii_are_guessed_from_what_is_filled() {
        let grid = |n: usize| (0..n * n * n).map(move |i| [i % n, i / n % n, i / n / n].map(|x| x as f32 * 2.0));
        assert!((0.8..1.2).contains(&radius(grid(20))), "{}", radius(grid(20)));
        let stray = radius(grid(20).chain([[1e9; 3], [f32::NAN; 3]]));
        assert!((0.8..1.2).contains(&stray), "{stray}");
        let sheet = radius((0..2500).map(|i| [(i % 50) as f32, (i / 50) as f32, 7.0]));
        assert!((0.4..0.6).contains(&sheet), "{sheet}");
        let line = radius((0..100).map(|i| [0.0, 3.0 * i as f32, 0.0]));
        assert!((1.2..1.8).contains(&line), "{line}");
        assert_eq!([radius([[5.0; 3]].into_iter()), radius([].into_iter())], [1.0; 2]);
    }
}
