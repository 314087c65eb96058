//! Any sequence of packet operations: what was derived is what a fresh packet derives, promises are true (debug builds
//! check them).
#![no_main]

use std::ops::Range;

use libfuzzer_sys::fuzz_target;
use mobula_core::lab::Dice;
use mobula_core::simd::{AnyToken, Task, Token};
use mobula_core::{Columns3, Properties, RayPacket, Rays};

const N: usize = 24;

#[derive(Clone, Copy)]
enum Operation {
    Inverse,
    Shears,
    Normalize,
}

struct Apply<'a>(&'a mut Rays<N>, Operation);

impl Task for Apply<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        match self.1 {
            Operation::Inverse => drop(self.0.inverse_directions(token)),
            Operation::Shears => drop(self.0.shears(token)),
            Operation::Normalize => self.0.normalize(token),
        }
    }
}

/// Bits of the active rows; NaN are all one.
fn bits<'a>(columns: impl IntoIterator<Item = &'a [f32; N]>, range: &Range<usize>) -> Vec<u32> {
    let canonical = |x: &f32| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() };
    columns.into_iter().flat_map(|column| column[range.clone()].iter().map(canonical)).collect()
}

fn rows(columns: &Columns3<N>, range: &Range<usize>) -> Vec<u32> {
    bits(columns.iter().map(|column| &column.0), range)
}

/// A packet of the same active rays that knows nothing.
fn fresh(packet: &RayPacket<N>) -> RayPacket<N> {
    let mut fresh = RayPacket::<N>::default();
    fresh.reset(packet.range());
    for i in packet.range() {
        let (origin, direction) = packet.ray(i);
        fresh.set_ray(i, origin, direction);
    }
    fresh
}

fn derived_is_fresh(token: AnyToken, packet: &RayPacket<N>) {
    let range = packet.range();
    let mut fresh = fresh(packet);
    if packet.properties().contains(Properties::HAVE_INVERSE_DIRECTIONS) {
        token.twin().run(Apply(&mut fresh, Operation::Inverse));
        assert_eq!(rows(packet.inverse_columns(), &range), rows(fresh.inverse_columns(), &range));
        // A narrower range may have more in common than what was found out about a wider one.
        let claims = packet.properties().contains(Properties::CONSTANT_SIGNS);
        assert!(!claims || fresh.properties().contains(Properties::CONSTANT_SIGNS));
    }
    if packet.properties().contains(Properties::HAVE_SHEARS) {
        token.twin().run(Apply(&mut fresh, Operation::Shears));
        assert_eq!(rows(packet.shear_columns(), &range), rows(fresh.shear_columns(), &range));
        assert_eq!(packet.axes()[range.clone()], fresh.axes()[range]);
    }
}

fuzz_target!(|bytes: &[u8]| {
    let mut dice = Dice::from_bytes(bytes);
    dice.draw_style();
    let tokens: Vec<AnyToken> = AnyToken::available().collect();
    let mut packet = RayPacket::<N>::default();
    let begin = dice.below(N);
    packet.reset(begin..begin + dice.below(N - begin + 1));
    for i in packet.range() {
        packet.set_ray(i, dice.point().into(), dice.point().into());
    }
    for _ in 0..dice.below(12) {
        let token = tokens[dice.below(tokens.len())];
        match dice.below(7) {
            0 => token.run(Apply(&mut packet, Operation::Inverse)),
            1 => token.run(Apply(&mut packet, Operation::Shears)),
            2 if in_range(&packet) => token.run(Apply(&mut packet, Operation::Normalize)),
            3 => packet.set_common_origin(dice.point().into()),
            4 if !packet.range().is_empty() => {
                let i = packet.range().start + dice.below(packet.range().len());
                packet.set_ray(i, dice.point().into(), dice.point().into());
            }
            5 => packet.forget(Properties::from_bits_truncate(u32::from(dice.byte()) << dice.below(20))),
            _ => {
                // Only narrower: rows that were never derived must not become active.
                let active = packet.range();
                let begin = active.start + dice.below(active.len() + 1);
                packet.set_range(begin..begin + dice.below(active.end - begin + 1));
            }
        }
        packet.check();
        derived_is_fresh(token, &packet);
    }
});

/// Lengths that squares of `f32` can tell: the promise of unit length is kept for those.
fn in_range(packet: &RayPacket<N>) -> bool {
    packet.range().all(|i| (1e-15..1e15).contains(&packet.ray(i).1.length()))
}
