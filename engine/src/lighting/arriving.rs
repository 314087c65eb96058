//! What arrives at points: from one light, and from all lights of a scene.

use std::ops::Range;

use glam::Vec3;

use super::Points;
use crate::packet::{Column, Columns3, columns3, part};
use crate::scratch::ForWidth;

/// What reaches a set of points from a light: one row a point.
#[derive(Clone, Debug)]
pub struct Illumination {
    /// Unit vectors from the points to the light.
    pub direction: Columns3,
    /// Radiance that arrives, linear RGB: of light from one direction, what a white surface across it scatters. Of a light with extent, that
    /// of a sample: its radiance over pi times the density of the direction, by solid angle, so that the mean over samples is what a white
    /// surface scatters of the whole light.
    pub radiance: Columns3,
    /// Distance to the light, infinite for a directional one.
    pub distance: Column<f32>,
}

impl ForWidth for Illumination {
    fn for_width(width: usize) -> Self {
        Self { direction: columns3(width), radiance: columns3(width), distance: Column::new(width) }
    }
}

/// Hits, and what reaches them from all lights.
#[derive(Debug)]
pub struct Lighting {
    width: usize,
    /// The hits.
    pub points: Points,
    /// What reaches them from everywhere: one row a point.
    pub ambient: Columns3,
    /// What reaches them from each light; those behind the lights of the scene are of no use.
    lights: Vec<Illumination>,
    count: usize,
}

impl ForWidth for Lighting {
    fn for_width(width: usize) -> Self {
        Self { width, points: Points::for_width(width), ambient: columns3(width), lights: Vec::new(), count: 0 }
    }
}

impl Lighting {
    /// The points, and room for what reaches them from so many lights.
    pub fn of_lights(&mut self, count: usize) -> (&Points, &mut [Illumination]) {
        while self.lights.len() < count {
            self.lights.push(Illumination::for_width(self.width));
        }
        self.count = count;
        (&self.points, &mut self.lights[..count])
    }

    /// What reaches some of the points.
    ///
    /// # Panics
    /// If there are not so many.
    pub fn lit(&self, rows: Range<usize>) -> Lit<'_> {
        assert!(rows.start <= rows.end && rows.end <= self.points.len(), "{rows:?} of {} points", self.points.len());
        Lit { lighting: self, first: rows.start, count: rows.len() }
    }
}

/// What reaches the hits of a sub-packet: one row a hit.
#[derive(Clone, Copy, Debug)]
pub struct Lit<'a> {
    lighting: &'a Lighting,
    first: usize,
    count: usize,
}

/// What reaches hits from one light, without what is in the way: one row a hit.
#[derive(Clone, Copy, Debug)]
pub struct Arriving<'a> {
    /// Unit vectors to the light.
    pub direction: [&'a [f32]; 3],
    /// Radiance, linear RGB; zero where the surface faces away or nothing of the light arrives.
    pub radiance: [&'a [f32]; 3],
}

impl<'a> Lit<'a> {
    /// Number of hits: those of the sub-packet; none, if no light changes the material.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    fn rows(&self) -> Range<usize> {
        self.first..self.first + self.count
    }

    /// Unit shading normals, on the side that the rays came from.
    pub fn normals(&self) -> [&'a [f32]; 3] {
        let [x, y, z] = self.lighting.points.normals();
        let rows = self.rows();
        [&x[rows.clone()], &y[rows.clone()], &z[rows]]
    }

    /// Unit shading normal, on the side that the ray came from.
    #[inline(always)]
    pub fn normal(&self, i: usize) -> Vec3 {
        self.lighting.points.normal(self.first + i)
    }

    /// Unit geometric normal, on the side that the ray came from.
    #[inline(always)]
    pub fn geometric_normal(&self, i: usize) -> Vec3 {
        self.lighting.points.geometric_normal(self.first + i)
    }

    /// Where rays that leave the surface start: see [`Points::offset`].
    #[inline(always)]
    pub fn offset(&self, i: usize, side: f32) -> Vec3 {
        self.lighting.points.offset(self.first + i, side, 0.0)
    }

    /// What arrives from everywhere, linear RGB.
    pub fn ambient(&self) -> [&'a [f32]; 3] {
        part(&self.lighting.ambient, self.rows())
    }

    /// What arrives from each light of the scene.
    pub fn lights(self) -> impl Iterator<Item = Arriving<'a>> {
        self.lighting.lights[..self.lighting.count].iter().map(move |light| Arriving {
            direction: part(&light.direction, self.rows()),
            radiance: part(&light.radiance, self.rows()),
        })
    }
}
