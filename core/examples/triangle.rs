//! Traces one packet of 32 x 32 rays at a triangle and prints what it hit.
//!
//!     cargo run --release -p mobula-core --example triangle

use mobula_core::bvh::Serial;
use mobula_core::glam::Vec3;
use mobula_core::leaf::TriangleBlock;
use mobula_core::simd::AnyToken;
use mobula_core::{Bvh, RayPacket};

const SIZE: usize = 32;
/// To the lower left: a packet whose directions have constant signs stays together.
const EYE: Vec3 = Vec3::new(-1.5, -1.5, 4.0);

fn main() {
    let bvh =
        Bvh::<TriangleBlock>::triangles(1, 0, &Serial, |_| [[-0.9, -0.8, 0.0], [0.9, -0.5, -1.0], [0.1, 0.9, 1.0]]);
    let mut packet = RayPacket::<{ SIZE * SIZE }>::default();
    packet.reset(0..SIZE * SIZE);
    for i in 0..SIZE * SIZE {
        let (x, y) = ((i % SIZE) as f32 + 0.5, (i / SIZE) as f32 + 0.5);
        let target = Vec3::new(x, SIZE as f32 - y, 0.0) / (SIZE as f32 / 2.0) - Vec3::new(1.0, 1.0, 0.0);
        packet.set_ray(i, Vec3::ZERO, target - EYE);
    }
    packet.set_common_origin(EYE);
    let paths = bvh.intersect(AnyToken::detect(), &mut packet);

    // The nearer, the brighter.
    let shade = |i: usize| {
        if packet.was_hit(i) {
            [b'@', b'%', b'#', b'*', b'+', b'-'][(packet.t_max[i] * 8.0) as usize % 6]
        } else {
            b'.'
        }
    };
    for row in 0..SIZE {
        let line: String = (0..SIZE).map(|x| char::from(shade(row * SIZE + x))).collect();
        println!("{line}");
    }
    let hits = (0..SIZE * SIZE).filter(|&i| packet.was_hit(i)).count();
    println!("{hits} hits; {paths:?}");
    assert!(hits > 200 && paths.common_origin == (SIZE * SIZE) as u64);
}
