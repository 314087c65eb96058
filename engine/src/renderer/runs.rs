//! Runs: neighbouring rays of a packet that hit the same material, or nothing (paper Figure 6).

use std::ops::Range;

use mobula_core::{NO_HIT, RayPacket};

/// The next run of the active rays from `begin` on: its material (`None`: no hit) and its rays. `None` at the end.
pub(super) fn next_run<const N: usize>(packet: &RayPacket<N>, begin: usize) -> Option<(Option<u32>, Range<usize>)> {
    let all = packet.range();
    if begin >= all.end {
        return None;
    }
    let key = |i: usize| if packet.was_hit(i) { packet.hits.material[i] } else { NO_HIT };
    let first = key(begin);
    let end = (begin + 1..all.end).find(|&i| key(i) != first).unwrap_or(all.end);
    Some((packet.was_hit(begin).then_some(first), begin..end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn runs_are_maximal_and_cover_all_rays(
            materials in prop::collection::vec(prop::option::of(0..3_u32), 16),
            begin in 0..8_usize,
            end in 8..=16_usize,
        ) {
            let mut packet = RayPacket::<16>::default();
            packet.reset(begin..end);
            for (i, material) in materials.iter().enumerate() {
                packet.hits.primitive[i] = material.map_or(NO_HIT, |m| m + 7);
                packet.hits.material[i] = material.unwrap_or(1);
            }
            let mut at = begin;
            let mut last = None;
            while let Some((material, range)) = next_run(&packet, at) {
                prop_assert_eq!(range.start, at);
                prop_assert!(!range.is_empty());
                prop_assert!(range.clone().all(|i| materials[i] == material));
                prop_assert!(last != Some(material), "two runs that should be one");
                last = Some(material);
                at = range.end;
            }
            prop_assert_eq!(at, end);
        }
    }
}
