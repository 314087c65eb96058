//! What a packet knows of its rays chooses the path that it takes: the same rays, told less and less.
//!
//!     cargo run --release -p mobula-core --example special_cases

use mobula_core::bvh::Serial;
use mobula_core::glam::Vec3;
use mobula_core::leaf::SphereBlock;
use mobula_core::simd::AnyToken;
use mobula_core::{Bvh, Properties, RayPacket};

fn main() {
    let bvh = Bvh::<SphereBlock>::spheres(100, 0, &Serial, |i| [(i % 10) as f32, (i / 10) as f32, 9.0, 0.45]);
    let token = AnyToken::detect();
    let mut packet = RayPacket::<64>::default();
    let mut hits = Vec::new();
    for known in [Properties::COMMON_ORIGIN, Properties::empty()] {
        packet.reset(0..64);
        for i in 0..64 {
            packet.set_ray(i, Vec3::ZERO, Vec3::new((i % 8) as f32 + 0.2, (i / 8) as f32 + 0.1, 9.0));
        }
        packet.promise(known);
        let paths = bvh.intersect(token, &mut packet);
        println!("{known:?}: {paths:?}");
        hits.push(packet.hits.primitive);
    }
    // One ray points the other way: its group has no common octant, so its rays go one by one.
    packet.reset(0..64);
    packet.set_ray(20, Vec3::ZERO, Vec3::NEG_ONE);
    println!("one ray astray: {:?}", bvh.intersect(token, &mut packet));
    assert_eq!(hits[0], hits[1], "a special case is a faster way to the same hits");
    assert_eq!(packet.hits.primitive[20], mobula_core::NO_HIT);
}
