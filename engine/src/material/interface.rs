//! Where smooth transparent boundaries send light: some is reflected, the rest goes through.

use glam::Vec3;

use super::gloss::{Gloss, outward};
use crate::math::normalize;
use crate::packet::{Column, Columns3, SubPacket, columns3, set_vec3, vec3};
use crate::scratch::{ForWidth, lend};
use crate::sequence::{Set, Shape, points};
use crate::shading::trace_weighted;
use crate::stack::{Context, Lit};

/// So many reflections and refractions deep both ways are followed; from there on one of them, chosen for each sample as often as it has
/// light: two rays a hit would double at each.
const DEEPEST_OF_BOTH: u32 = 0;

/// What becomes of light at hits: one row a hit.
pub(super) struct Interface {
    /// The fraction that is reflected.
    pub(super) reflected: Column<f32>,
    /// Where the rest goes: unit vectors. Nothing is said where all is reflected.
    pub(super) through: Columns3,
    /// What is left of light that is reflected, and of light that goes through.
    pub(super) tints: [Columns3; 2],
}

impl ForWidth for Interface {
    fn for_width(width: usize) -> Self {
        Self { reflected: Column::new(width), through: columns3(width), tints: [columns3(width), columns3(width)] }
    }
}

impl Interface {
    /// Sets the first rows of `out` to what comes from both sides.
    pub(super) fn look_both_ways(
        &mut self,
        context: &Context<'_>,
        hits: &SubPacket<'_>,
        lit: Lit<'_>,
        out: &mut Columns3,
    ) {
        let count = lit.len();
        out.iter_mut().for_each(|column| column[..count].fill(0.0));
        let [choice, rest]: [&mut Column<f32>; 2] = [&mut lend(context.width), &mut lend(context.width)];
        let one = hits.depth() > DEEPEST_OF_BOTH;
        if one {
            let set = Set::choice(hits.depth());
            points(context.token, hits.samples(), set, Shape::Square, [&mut choice[..count], &mut rest[..count]]);
        }
        for i in 0..count {
            let mut reflected = self.reflected[i];
            if one {
                reflected = if choice[i] < reflected { 1.0 } else { 0.0 };
            }
            for (tint, part) in self.tints.iter_mut().zip([reflected, 1.0 - reflected]) {
                let weight = vec3(tint, i) * part;
                set_vec3(tint, i, weight);
            }
        }
        let [back, through] = &self.tints;
        let directions = &hits.directions();
        let mirrored = |i| {
            let (direction, normal) = (normalize(vec3(directions, i)), lit.normal(i));
            outward(direction - normal * (2.0 * direction.dot(normal)), lit.geometric_normal(i))
        };
        trace_weighted(context, hits, |i| vec3(back, i), out, |i| lit.offset(i, 1.0), mirrored);
        let behind = |i| outward(vec3(&self.through, i), -lit.geometric_normal(i));
        trace_weighted(context, hits, |i| vec3(through, i), out, |i| lit.offset(i, -1.0), behind);
    }
}

/// Adds what a smooth boundary mirrors of lights, that reflects `reflectance` along the normal, where `of` says so.
pub(super) fn add_glints(
    context: &Context<'_>,
    hits: &SubPacket<'_>,
    lit: Lit<'_>,
    reflectance: f32,
    of: impl Fn(usize) -> bool,
    out: &mut Columns3,
) {
    let gloss: &mut Gloss = &mut lend(context.width);
    for i in 0..lit.len() {
        let part = if of(i) { 1.0 } else { 0.0 };
        let cosine = -normalize(vec3(&hits.directions(), i)).dot(lit.normal(i));
        let [_] = gloss.set(i, cosine, 0.0, [(part, Vec3::splat(reflectance))]);
    }
    gloss.add_lights(hits, lit, out);
}
