//! Some of the particles of a step, which show how far all reach.

use super::{Attribute, ParticleStep, Values};

impl ParticleStep {
    /// About `most` of the particles, evenly from the first to the last, and those that are farthest out along each axis.
    pub fn sampled(&self, most: usize) -> Self {
        if self.centers.len() <= most {
            return self.clone();
        }
        let each = self.centers.len().div_ceil(most.max(1));
        let mut chosen: Vec<usize> = (0..self.centers.len()).step_by(each).collect();
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let reach = |at: usize| side * self.centers[at][axis] + self.radii.get(at).copied().unwrap_or(0.0);
                let finite = (0..self.centers.len()).filter(|&at| reach(at).is_finite());
                chosen.extend(finite.max_by(|&a, &b| reach(a).total_cmp(&reach(b))));
            }
        }
        let of = |Attribute { name, values }: &Attribute| {
            let values = match values {
                Values::F32(values) => Values::F32(some(values, &chosen)),
                Values::U8(values) => Values::U8(some(values, &chosen)),
            };
            Attribute { name: name.clone(), values }
        };
        Self {
            centers: some(&self.centers, &chosen),
            radii: some(&self.radii, &chosen),
            attributes: self.attributes.iter().map(of).collect(),
            cell: self.cell,
        }
    }
}

fn some<T: Copy>(values: &[T], chosen: &[usize]) -> Vec<T> {
    chosen.iter().filter_map(|&at| values.get(at).copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn those_farthest_out_are_among_the_sample() {
        let center = |i: usize| [(i * 37 % 1000) as f32, i as f32, -(i as f32)];
        let mut all = ParticleStep {
            centers: (0..1000).map(center).collect(),
            attributes: vec![Attribute {
                name: "i".to_owned(),
                values: Values::F32((0..1000).map(|i| i as f32).collect()),
            }],
            ..ParticleStep::default()
        };
        all.centers[5][0] = f32::NAN;
        let some = all.sampled(10);
        assert_eq!(some.centers.len(), 16);
        let range = |axis: usize| {
            let along = some.centers.iter().map(|center| center[axis]);
            along.fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
        };
        assert_eq!([0, 1, 2].map(range), [[0.0, 999.0], [0.0, 999.0], [-999.0, 0.0]]);
        for (center, i) in some.centers.iter().zip(some.attributes[0].values.to_f32().iter()) {
            assert_eq!(center[1], *i);
        }
        assert_eq!(all.sampled(1000).centers.len(), 1000);
    }
}
