//! Runs: neighbouring rays of a packet that hit the same material, or nothing (paper Figure 6).

use std::ops::Range;

use mobula_core::{NO_HIT, RayPacket};

/// Rays that are compared at once.
const AT_ONCE: usize = 16;

/// The next run of the active rays from `begin` on, whose hits and materials are filled in: its material (`None`: no hit) and
/// its rays. `None` at the end.
pub(super) fn next_run<const N: usize>(packet: &RayPacket<N>, begin: usize) -> Option<(Option<u32>, Range<usize>)> {
    let materials = &packet.hits.material[..packet.range().end];
    let first = *materials.get(begin)?;
    let same = |rays: &[u32]| rays.iter().fold(true, |same, &material| same & (material == first));
    let mut end = begin + 1;
    while materials.get(end..end + AT_ONCE).is_some_and(same) {
        end += AT_ONCE;
    }
    while materials.get(end).is_some_and(|&material| material == first) {
        end += 1;
    }
    Some(((first != NO_HIT).then_some(first), begin..end))
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
                packet.hits.material[i] = material.unwrap_or(NO_HIT);
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
