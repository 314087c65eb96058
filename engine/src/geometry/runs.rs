//! Rays that hit, in runs of one geometry and material.

use std::sync::Arc;

use mobula_core::NO_HIT;

use super::Geometry;
use crate::packet::{Found, Run};

/// Splits the rays into runs of one geometry of the list, and one material. Indices of materials above `last` count as that.
pub(super) fn split(list: &[Arc<dyn Geometry>], found: &mut Found<'_>, last: u32) {
    let Found { geometries, primitives, materials, runs, .. } = found;
    runs.clear();
    let mut start = 0;
    while let Some(&geometry) = geometries.get(start) {
        let end = start + leading(&geometries[start..], |other| other == geometry);
        if geometry == NO_HIT {
            runs.push(Run { rays: start..end, hit: None });
            start = end;
            continue;
        }
        let materials = &mut materials[start..end];
        if let Some(all) = list[geometry as usize].materials(&primitives[start..end], materials) {
            runs.push(Run { rays: start..end, hit: Some((geometry, all.min(last))) });
            start = end;
            continue;
        }
        let mut left = &*materials;
        while let Some(&material) = left.first() {
            let material = material.min(last);
            let count = leading(left, |other| other.min(last) == material);
            runs.push(Run { rays: start..start + count, hit: Some((geometry, material)) });
            start += count;
            left = &left[count..];
        }
    }
}

/// How many of the first values are alike.
#[inline(always)]
fn leading(values: &[u32], alike: impl Fn(u32) -> bool) -> usize {
    /// Values that are compared at once.
    const AT_ONCE: usize = 16;
    let mut end = 0;
    while values.get(end..end + AT_ONCE).is_some_and(|some| some.iter().fold(true, |all, &value| all & alike(value))) {
        end += AT_ONCE;
    }
    end + values[end..].iter().take_while(|&&value| alike(value)).count()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn equal_values_are_counted(values in prop::collection::vec(0..2_u32, 0..80)) {
            let first = values.first().copied().unwrap_or(0);
            let expected = values.iter().take_while(|&&value| value == first).count();
            prop_assert_eq!(leading(&values, |value| value == first), expected);
        }
    }
}
