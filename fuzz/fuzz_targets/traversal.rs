//! The tree finds what testing every primitive finds, bit for bit, at every level of this machine and three widths.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mobula_core::bvh::{Bvh, Serial};
use mobula_core::leaf::{Block, SphereBlock, TriangleBlock};
use mobula_core::lab::{Dice, Style};
use mobula_core::simd::AnyToken;
use mobula_core::{AnyHitPacket, Properties, RayPacket};

fn check<const N: usize, B: Block>(bvh: &Bvh<B>, dice: &mut Dice<'_>) {
    let mut packet = RayPacket::<N>::default();
    let begin = dice.below(N);
    let range = begin..begin + dice.below(N - begin + 1);
    packet.reset(range.clone());
    let common = dice.one_in(2).then(|| dice.point());
    for i in range.clone() {
        let origin = common.unwrap_or_else(|| dice.point());
        packet.set_ray(i, origin.into(), dice.point().into());
        if dice.one_in(4) {
            packet.set_interval(i, dice.value(), dice.value());
        }
    }
    if common.is_some() {
        packet.promise(Properties::COMMON_ORIGIN);
    }
    let mut of_family: [Option<RayPacket<N>>; 2] = [None, None];
    for token in AnyToken::available() {
        let (mut tree, mut all) = (packet.clone(), packet.clone());
        bvh.intersect(token, &mut tree);
        bvh.intersect_all(token, &mut all);
        let mut shadow = AnyHitPacket::<N>::default();
        shadow.reset(range.clone());
        for i in range.clone() {
            let (origin, direction) = packet.ray(i);
            shadow.set_ray(i, origin, direction);
            shadow.set_interval(i, packet.t_min()[i], packet.t_max[i]);
        }
        bvh.occlude(token, &mut shadow);
        let family = of_family[usize::from(token.fused())].get_or_insert_with(|| all.clone());
        for i in 0..N {
            let context = format!("{token:?} ray {i} of {range:?}: {:?}", packet.ray(i));
            for other in [&all, family] {
                assert_eq!(tree.hits.primitive[i], other.hits.primitive[i], "{context}");
                assert_eq!(tree.t_max[i].to_bits(), other.t_max[i].to_bits(), "{context}");
            }
            if range.contains(&i) && packet.t_max[i] != f32::NEG_INFINITY {
                assert_eq!(shadow.occluded(i), all.was_hit(i), "{context}");
            }
        }
    }
}

fn check_widths<B: Block>(bvh: &Bvh<B>, dice: &mut Dice<'_>) {
    check::<1, B>(bvh, dice);
    check::<24, B>(bvh, dice);
    check::<64, B>(bvh, dice);
}

fuzz_target!(|bytes: &[u8]| {
    let mut dice = Dice::from_bytes(bytes);
    // Primitives within the sizes that the tree is for; rays of any kind.
    let style = if dice.one_in(2) { Style::Grid } else { Style::Ordinary };
    dice.set_style(style);
    let count = dice.below(60);
    if dice.one_in(2) {
        let spheres: Vec<[f32; 4]> =
            (0..count).map(|_| [dice.value(), dice.value(), dice.value(), 0.3 * dice.value().abs()]).collect();
        dice.draw_style();
        check_widths(&Bvh::<SphereBlock>::spheres(count, 0, &Serial, |i| spheres[i]), &mut dice);
    } else {
        let triangles: Vec<[[f32; 3]; 3]> = (0..count).map(|_| [dice.point(), dice.point(), dice.point()]).collect();
        let bvh = Bvh::<TriangleBlock>::triangles(count, 0, &Serial, |i| triangles[i]);
        dice.draw_style();
        check_widths(&bvh, &mut dice);
    }
});
