//! Points as lights see them: where they are, and what lights choose at random for them.

use mobula_core::simd::{AnyToken, F32Lanes, Task, Token};

use super::Points;
use crate::sequence::{Set, point};

/// Points that light is to reach: one row a point. A light with extent looks for each of them at one point of itself, which follows from
/// the sample that the point belongs to, so that the samples of a pixel together see all of the light evenly.
#[derive(Clone, Copy, Debug)]
pub struct Receivers<'a> {
    positions: [&'a [f32]; 3],
    normals: Option<[&'a [f32]; 3]>,
    /// The samples that they belong to, and the set of a light's own; `None`: they belong to none.
    samples: Option<([&'a [u32]; 2], Set)>,
}

impl<'a> Receivers<'a> {
    /// Points that belong to no samples: what is in their middle is chosen for all of them.
    pub fn new(positions: [&'a [f32]; 3]) -> Self {
        Self { positions, normals: None, samples: None }
    }

    /// Hits, for the light of this number in a scene's list; `depth` is how many reflections or refractions they are behind.
    pub(crate) fn of_points(points: &'a Points, light: usize, depth: u32) -> Self {
        let normals = Some(points.normals());
        Self { normals, ..Self::with_samples(points.positions(), points.samples(), light, depth) }
    }

    /// As [`of_points`](Self::of_points): `samples` are pixel seeds and sample numbers.
    pub(crate) fn with_samples(positions: [&'a [f32]; 3], samples: [&'a [u32]; 2], light: usize, depth: u32) -> Self {
        Self { positions, normals: None, samples: Some((samples, Set::light(light, depth))) }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.positions[0].len()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where they are.
    pub fn positions(&self) -> [&'a [f32]; 3] {
        self.positions
    }

    /// Unit shading normals on the side that is seen, if they are points of surfaces.
    pub fn normals(&self) -> Option<[&'a [f32]; 3]> {
        self.normals
    }

    /// Fills a row for each of them with a point of the unit square: where in the light it is to be looked. The same at every level.
    pub fn choose(&self, token: AnyToken, out: [&mut [f32]; 2]) {
        token.run(Choose { receivers: *self, out });
    }

    /// As [`choose`](Self::choose), for a vector of points, the first of which is `at`.
    #[inline(always)]
    pub(crate) fn square<T: Token>(&self, token: T, at: usize) -> [T::F32; 2] {
        match self.samples {
            Some(([seeds, numbers], set)) => point(token, token.load_u32(seeds, at), token.load_u32(numbers, at), set),
            None => [token.splat(0.5); 2],
        }
    }
}

struct Choose<'a, 'b> {
    receivers: Receivers<'a>,
    out: [&'b mut [f32]; 2],
}

impl Task for Choose<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { receivers, out: [u, v] } = self;
        for at in (0..receivers.len()).step_by(T::LANES) {
            let [x, y] = receivers.square(token, at);
            x.store(u, at);
            y.store(v, at);
        }
    }
}
