//! What a packet promises: ranges, properties, derived values, at any width.

use std::ops::Range;

use mobula_core::glam::Vec3;
use mobula_core::simd::{AnyToken, Scalar, Task, Token};
use mobula_core::{AnyHitPacket, NO_HIT, Properties, RayPacket, Rays};
use proptest::prelude::*;

fn filled<const N: usize>(range: Range<usize>) -> RayPacket<N> {
    let mut packet = RayPacket::default();
    packet.reset(range.clone());
    for i in range {
        packet.set_ray(i, Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.0, 0.6, 0.8));
        packet.hits.primitive[i] = 7;
    }
    packet
}

fn any_width<const N: usize>(start: usize, end: usize) {
    let range = start * N / 1024..(end * N).div_ceil(1024);
    let mut packet = filled::<N>(range.clone());
    assert_eq!(packet.range(), range);
    assert_eq!(size_of::<Rays<N>>() % 64, 0);
    for i in 0..N {
        assert_eq!(packet.was_hit(i), range.contains(&i));
    }
    packet.reset_hits();
    assert_eq!(packet.hits.primitive[..], [NO_HIT; N]);
    // Derivations touch the active rays only.
    for token in AnyToken::available() {
        struct Derive<'a, const N: usize>(&'a mut RayPacket<N>);
        impl<const N: usize> Task for Derive<'_, N> {
            type Output = ();
            #[inline(always)]
            fn run<T: Token>(self, token: T) {
                self.0.inverse_directions(token);
            }
        }
        let mut derived = packet.clone();
        token.run(Derive(&mut derived));
        let inverse = derived.inverse_directions(Scalar::new());
        for i in 0..N {
            let expected = if range.contains(&i) { 1.0 / 0.8 } else { 0.0 };
            assert_eq!(inverse[2][i], expected, "{token:?} width {N} ray {i} of {range:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20, ..ProptestConfig::default() })]

    #[test]
    fn a_packet_of_any_width_has_any_range(start in 0usize..1024, length in 0usize..1024) {
        let end = (start + length).min(1024);
        any_width::<1>(start, end);
        any_width::<3>(start, end);
        any_width::<64>(start, end);
        any_width::<1000>(start, end);
        any_width::<1024>(start, end);
    }

    #[test]
    fn normalized_directions_have_length_one_and_may_be_promised(x in -9f32..9.0, y in -9f32..9.0, z in 0.1f32..9.0) {
        let mut packet = filled::<3>(0..3);
        packet.set_ray(1, Vec3::ZERO, Vec3::new(x, y, z));
        packet.normalize(Scalar::new());
        prop_assert!(packet.properties().contains(Properties::NORMALIZED_DIRECTIONS));
        packet.check();
        prop_assert!((packet.ray(1).1.length() - 1.0).abs() < 1e-6);
    }
}

const OF_RAYS: Properties = Properties::OF_ORIGIN.union(Properties::OF_DIRECTION);

/// A packet of which everything is said that debug builds cannot refute.
fn promised() -> RayPacket<64> {
    let mut packet = filled::<64>(0..64);
    packet.inverse_directions(Scalar::new());
    packet.shears(Scalar::new());
    packet.promise(OF_RAYS);
    packet
}

#[test]
fn each_setter_clears_what_it_could_make_false_and_no_more() {
    use Properties as P;
    type Setter = fn(&mut RayPacket<64>);
    let setters: [(Setter, P, P); 8] = [
        (|p| p.set_ray(3, Vec3::ZERO, Vec3::X), P::empty(), P::OF_ORIGIN | P::OF_DIRECTION),
        (|p| p.origins_mut()[0][3] = 9.0, P::HAVE_SHEARS | P::NORMALIZED_DIRECTIONS, P::OF_ORIGIN),
        (|p| p.directions_mut()[0][3] = 9.0, P::COMMON_ORIGIN, P::OF_DIRECTION),
        (|p| p.set_common_origin(Vec3::X), P::COMMON_ORIGIN, P::empty()),
        (|p| p.normalize(Scalar::new()), P::NORMALIZED_DIRECTIONS | P::COMMON_ORIGIN, P::HAVE_SHEARS),
        (|p| p.set_range(3..9), OF_RAYS, P::empty()),
        (|p| p.reset(0..64), P::empty(), P::all()),
        (RayPacket::reset_hits, OF_RAYS, P::empty()),
    ];
    for (which, (set, kept, cleared)) in setters.into_iter().enumerate() {
        let mut packet = promised();
        set(&mut packet);
        packet.check();
        assert!(packet.properties().contains(kept), "setter {which} cleared {:?}", kept - packet.properties());
        assert!(!packet.properties().intersects(cleared), "setter {which} kept {:?}", packet.properties() & cleared);
    }
}

#[test]
fn widening_the_range_forgets_what_is_known_of_the_narrow_one() {
    let mut packet = filled::<64>(0..64);
    packet.set_ray(40, Vec3::ZERO, Vec3::new(-1.0, 0.1, 0.1));
    packet.set_range(0..16);
    packet.set_common_origin(Vec3::new(1.0, 2.0, 3.0));
    packet.inverse_directions(Scalar::new());
    packet.set_range(0..64);
    packet.check();
    assert_eq!(packet.inverse_directions(Scalar::new())[0][40], -1.0);
    assert!(!packet.properties().intersects(Properties::COMMON_ORIGIN | Properties::CONSTANT_SIGNS));
}

#[test]
fn an_any_hit_packet_holds_rays_and_what_they_met_and_nothing_else() {
    assert_eq!(size_of::<AnyHitPacket<64>>(), size_of::<Rays<64>>() + 64 * size_of::<u32>());
    let mut packet = AnyHitPacket::<64>::default();
    packet.reset(5..9);
    assert_eq!((packet.range(), packet.properties()), (5..9, Properties::empty()));
    assert!(!packet.occluded(5));
    packet.t_max[5] = f32::NEG_INFINITY;
    assert!(packet.occluded(5));
}

#[test]
#[should_panic(expected = "rays 3..65 of a packet of 64")]
fn a_range_beyond_the_width_is_refused() {
    RayPacket::<64>::default().reset(3..65);
}

/// One test for each false promise that debug builds must catch.
macro_rules! false_promises {
    ($($name:ident: $property:ident, $origin:expr, $direction:expr;)+) => {$(
        #[test]
        #[cfg(debug_assertions)]
        #[should_panic(expected = "is set but false")]
        fn $name() {
            let mut packet = filled::<64>(0..64);
            packet.set_ray(9, $origin, $direction);
            packet.promise(Properties::$property);
        }
    )+};
}

const ORIGIN: Vec3 = Vec3::new(1.0, 2.0, 3.0);

false_promises! {
    a_false_common_origin_is_caught: COMMON_ORIGIN, Vec3::new(1.0, 2.0, 4.0), Vec3::Z;
    false_normalized_directions_are_caught: NORMALIZED_DIRECTIONS, ORIGIN, Vec3::new(0.0, 0.6, 0.9);
    false_constant_signs_are_caught: CONSTANT_SIGNS, ORIGIN, Vec3::new(-0.0, 0.6, 0.8);
    inverse_directions_that_are_not_there_are_caught: HAVE_INVERSE_DIRECTIONS, ORIGIN, Vec3::Z;
    shears_that_are_not_there_are_caught: HAVE_SHEARS, ORIGIN, Vec3::Z;
}
