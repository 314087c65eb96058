//! What is seen behind hits that stop only a part of the light, as translucent particles do: layer by layer, from front to back, so that
//! thousands of layers take no more room than one.

use mobula_core::Properties;

use super::secondary::LEAST_WEIGHT;
use crate::packet::{Column, Packet, add_vec3, vec3};
use crate::scratch::{ForWidth, Lent, lend};
use crate::stack::Context;

/// Adds to the colours of a packet what comes [through](Packet::through) its hits. `trace` finds the next hits of rays behind them, and
/// leaves a colour in each.
///
/// A ray goes on as it is, from behind its hit: of primitives that it meets at the same distance only one counts.
pub fn see_through(context: &Context<'_>, packet: &mut Packet, trace: impl Fn(&mut Packet)) {
    if packet.through().is_none() {
        return;
    }
    let (mut layer, mut next): (Lent<Layer>, Lent<Layer>) = (lend(context.width), lend(context.width));
    let mut more = layer.follow(packet, |i| (i as u16, 1.0));
    while more {
        let Layer { packet: behind, rows, weights } = &mut *layer;
        trace(behind);
        for (k, (&row, &weight)) in rows.iter().zip(weights.iter()).take(behind.len()).enumerate() {
            add_vec3(&mut packet.color, row.into(), vec3(&behind.color, k) * weight);
        }
        more = next.follow(behind, |k| (rows[k], weights[k]));
        std::mem::swap(&mut layer, &mut next);
    }
}

/// The rays that go on behind some hits.
struct Layer {
    packet: Packet,
    /// The row of the first packet that each belongs to.
    rows: Column<u16>,
    /// How much of its colour arrives there.
    weights: Column<f32>,
}

impl ForWidth for Layer {
    fn for_width(width: usize) -> Self {
        Self { packet: Packet::new(width), rows: Column::new(width), weights: Column::new(width) }
    }
}

impl Layer {
    /// Becomes the rays that go on from those of a packet, each of which belongs to a row and has a weight. Says whether there are any.
    fn follow(&mut self, before: &Packet, of: impl Fn(usize) -> (u16, f32)) -> bool {
        let from: &mut Column<u16> = &mut lend(before.width());
        let mut count = 0;
        for (i, through) in before.through().into_iter().flatten().enumerate() {
            let (row, weight) = of(i);
            if weight * through >= LEAST_WEIGHT {
                (from[count], self.rows[count], self.weights[count]) = (i as u16, row, weight * through);
                count += 1;
            }
        }
        let packet = &mut self.packet;
        packet.reset(count);
        (packet.depth, packet.channel) = (before.depth, before.channel);
        let from = &from[..count];
        let gather = |to: &mut [f32], column: &[f32]| {
            to.iter_mut().zip(from).for_each(|(to, &i)| *to = column[usize::from(i)]);
        };
        let (old, new) = (before.rays(), packet.rays_mut());
        new.origins_mut().into_iter().zip(old.origins()).for_each(|(to, column)| gather(to, column));
        new.directions_mut().into_iter().zip(old.directions()).for_each(|(to, column)| gather(to, column));
        gather(new.t_min_mut(), old.t_max());
        new.promise(old.properties() & (Properties::COMMON_ORIGIN | Properties::NORMALIZED_DIRECTIONS));
        (packet.cone_spread, packet.cone_part) = (before.cone_spread, before.cone_part);
        gather(&mut packet.cone_widths[..count], &before.cone_widths);
        packet.image.iter_mut().zip(&before.image).for_each(|(to, column)| gather(&mut to[..count], column));
        for (to, column) in packet.samples.iter_mut().zip(&before.samples) {
            to.iter_mut().zip(from).for_each(|(to, &i)| *to = column[usize::from(i)]);
        }
        count > 0
    }
}
