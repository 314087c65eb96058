//! Ray packets, intersection kernels, and packet traversal of a wide bounding volume hierarchy. `no_std` + `alloc`; knows
//! no thread and no file.
//!
//! A packet holds up to `N` rays as a structure of arrays, their hits, and *properties*: flags of what is known of all of
//! them, which choose special-case code. The tree is built once; each packet then enters an instruction set once and is
//! traced in it:
//!
//! ```
//! use mobula_core::bvh::Serial;
//! use mobula_core::leaf::TriangleBlock;
//! use mobula_core::glam::Vec3;
//! use mobula_core::simd::AnyToken;
//! use mobula_core::{Bvh, RayPacket};
//!
//! // Two triangles: a floor of 20 x 20 at y = 0.
//! let floor = [
//!     [[-10.0, 0.0, -10.0], [10.0, 0.0, -10.0], [10.0, 0.0, 10.0]],
//!     [[-10.0, 0.0, -10.0], [10.0, 0.0, 10.0], [-10.0, 0.0, 10.0]],
//! ];
//! let bvh = Bvh::<TriangleBlock>::triangles(floor.len(), 0, &Serial, |i| floor[i]);
//!
//! // 64 rays from one eye.
//! let mut packet = RayPacket::<64>::default();
//! packet.reset(0..64);
//! for i in 0..64 {
//!     packet.set_ray(i, Vec3::ZERO, Vec3::new((i % 8) as f32 / 2.0, -5.0, (i / 8) as f32 / 2.0));
//! }
//! packet.set_common_origin(Vec3::new(0.0, 10.0, 0.0));
//!
//! // The best instruction set that this machine has; the hits are the same at each of one numeric family.
//! let paths = bvh.intersect(AnyToken::detect(), &mut packet);
//! assert_eq!(paths.common_origin, 64);
//! for i in 0..64 {
//!     assert!(packet.was_hit(i));
//!     assert_eq!(packet.t_max[i], 2.0);
//!     assert!(packet.hits.primitive[i] < 2);
//! }
//! ```
//!
//! Who has rays one by one uses [`query`], which makes packets of them:
//!
//! ```
//! use mobula_core::query::{Hit, Mesh, Ray};
//!
//! let positions = [[-10.0, 0.0, -10.0], [10.0, 0.0, -10.0], [10.0, 0.0, 10.0], [-10.0, 0.0, 10.0]];
//! let scene = Mesh::new(&positions, &[[0, 1, 2], [0, 2, 3]]).build()?;
//! let rays: Vec<Ray> = (0..100).map(|i| Ray::new([0.0, 10.0, 0.0], [0.1 * i as f32, -5.0, 0.0])).collect();
//! let mut hits = vec![Hit::NONE; rays.len()];
//! scene.intersect(&rays, &mut hits);
//! assert_eq!((hits[7].t, hits[7].geometry, hits[7].normal), (2.0, 0, [0.0, -1.0, 0.0]));
//! assert_eq!(scene.occluded_one(&rays[99]), hits[99].is_hit());
//! # Ok::<(), mobula_core::query::BuildError>(())
//! ```
//!
//! A packet's width is any number from 1 to 1024, fixed when the program is compiled:
//!
//! ```compile_fail,E0080
//! let packet = mobula_core::RayPacket::<0>::default();
//! ```
//! ```compile_fail,E0080
//! let packet = mobula_core::AnyHitPacket::<1025>::default();
//! ```
//!
//! # Map
//!
//! Each module uses only what stands below it in this table.
//!
//! | module | idea |
//! |---|---|
//! | `lab` | the kernel lab: registry, proof, measurement (feature `lab`) |
//! | [`query`] | meshes in, rays in, hits out: no packet to be seen |
//! | [`oracle`] | what is true: naive `f64` tests with a margin, which tests hold everything else against |
//! | [`traverse`] | how packets, streams and single rays find what they hit |
//! | [`cloud`] | particles: spheres with attributes, cropped by their values |
//! | [`volume`] | grids of samples, and the surfaces of equal value in them |
//! | [`bvh`] | the tree of eight children a node, and its builders |
//! | [`leaf`] | what is in a leaf: blocks of triangles or spheres, and your own kind |
//! | [`sink`] | what becomes of hits: the nearest, any, or a part of the light |
//! | [`kernel`] | the tests that walks make: node against packet, stream and ray; triangle, sphere, box |
//! | [`packet`], [`any_hit`] | rays with their hits; rays of which only is asked whether they hit |
//! | [`rays`] | origins, directions, intervals, and what is derived from them alone |
//! | [`vector`] | three lanes: x, y, z |
//! | [`properties`] | what may be known of all rays of a packet, who says so, who relies on it, what ends it |
//! | [`column`](mod@column) | one value of every ray, aligned for any vector |
//! | [`simd`] | the crate below: lanes, levels, tokens |
#![no_std]

extern crate alloc;

pub mod any_hit;
pub mod bvh;
pub mod cloud;
pub mod column;
pub mod kernel;
// Unit tests do without it: it would be compiled for them a second time.
#[cfg(all(feature = "lab", not(test)))]
pub mod lab;
pub mod leaf;
pub mod oracle;
pub mod packet;
pub mod properties;
pub mod query;
pub mod rays;
pub mod sink;
pub mod traverse;
pub mod vector;
pub mod volume;

pub use any_hit::AnyHitPacket;
pub use bvh::Bvh;
pub use column::{Column, Columns3};
pub use glam;
pub use mobula_simd as simd;
pub use packet::{Hits, NO_HIT, RayPacket};
pub use properties::Properties;
pub use rays::Rays;
