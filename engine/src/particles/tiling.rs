//! A periodic box, repeated along its edges.

use glam::Vec3;

use super::{Attribute, ParticleStep};

/// Why particles cannot be repeated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TilingError {
    /// Nobody says how large the box is.
    #[error("the edges of the periodic box are not known")]
    NoBox,
    /// More particles than can be counted with, or than there is memory for.
    #[error("{0} particles are too many")]
    TooMany(u128),
}

/// More particles have no numbers of 32 bits.
const MOST: u128 = u32::MAX as u128 - 1;

impl ParticleStep {
    /// The particles repeated so many times along each edge of their periodic box; first come those that are there, and the box grows
    /// with them.
    ///
    /// # Errors
    /// If there is no box, or there would be too many.
    pub fn tiled(&self, times: [u32; 3]) -> Result<Self, TilingError> {
        let copies: u128 = times.iter().map(|&n| u128::from(n)).product();
        if copies == 1 {
            return Ok(self.clone());
        }
        let cell = self.cell.ok_or(TilingError::NoBox)?;
        let count = copies.saturating_mul(self.centers.len() as u128);
        let mut centers = Vec::new();
        if count > MOST || centers.try_reserve_exact(count as usize).is_err() {
            return Err(TilingError::TooMany(count));
        }
        let edges = cell.map(Vec3::from);
        let [x, y, z] = times;
        for (k, j, i) in (0..z).flat_map(|k| (0..y).flat_map(move |j| (0..x).map(move |i| (k, j, i)))) {
            let shift = edges[0] * i as f32 + edges[1] * j as f32 + edges[2] * k as f32;
            centers.extend(self.centers.iter().map(|&center| (Vec3::from(center) + shift).to_array()));
        }
        let copies = copies as usize;
        let repeated = |attribute: &Attribute| attribute.repeated(copies);
        let longer = |k: usize| (edges[k] * times[k] as f32).to_array();
        Ok(Self {
            centers,
            radii: self.radii.repeat(copies),
            attributes: self.attributes.iter().map(repeated).collect(),
            cell: Some([0, 1, 2].map(longer)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::Values;

    fn step() -> ParticleStep {
        ParticleStep {
            centers: vec![[0.0; 3], [1.0, 2.0, 3.0]],
            radii: vec![0.5, 0.25],
            attributes: vec![Attribute { name: "kind".to_owned(), values: Values::U8(vec![3, 4]) }],
            cell: Some([[10.0, 0.0, 0.0], [5.0, 8.0, 0.0], [0.0, 0.0, 6.0]]),
        }
    }

    #[test]
    fn boxes_are_repeated_along_their_edges() {
        let tiled = step().tiled([2, 1, 3]).unwrap();
        assert_eq!(tiled.centers.len(), 12);
        assert_eq!(tiled.centers[2..6], [[10.0, 0.0, 0.0], [11.0, 2.0, 3.0], [0.0, 0.0, 6.0], [1.0, 2.0, 9.0]]);
        assert_eq!(tiled.radii[10..], [0.5, 0.25]);
        assert_eq!(tiled.attributes[0].values, Values::U8([3, 4].repeat(6)));
        assert_eq!(tiled.cell, Some([[20.0, 0.0, 0.0], [5.0, 8.0, 0.0], [0.0, 0.0, 18.0]]));
        assert_eq!(step().tiled([1, 2, 1]).unwrap().centers[3], [6.0, 10.0, 3.0]);
    }

    #[test]
    fn what_cannot_be_repeated_is_refused() {
        let without = ParticleStep { cell: None, ..step() };
        assert_eq!(without.tiled([1; 3]), Ok(without.clone()));
        assert_eq!(without.tiled([2, 1, 1]), Err(TilingError::NoBox));
        assert_eq!(step().tiled([u32::MAX; 3]), Err(TilingError::TooMany(2 * u128::from(u32::MAX).pow(3))));
        assert_eq!(step().tiled([0, 1, 1]).unwrap().centers.len(), 0);
    }
}
