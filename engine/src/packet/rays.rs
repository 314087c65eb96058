//! Rays of a packet, whatever its width: packets of `mobula-core` behind one enum, which only intersection takes apart.

use glam::Vec3;
use mobula_core::simd::AnyToken;
use mobula_core::sink::Opacity;
use mobula_core::traverse::Paths;
use mobula_core::{AnyHitPacket, Properties, RayPacket};

use super::intersect::{EveryWidth, Intersect};
use super::width::packet_widths;

/// The rays of a packet as slices with one row a ray. A ray is the half-open interval `(t_min, t_max]` of
/// `origin + t * direction`.
pub trait Rays {
    /// Number of rays.
    fn len(&self) -> usize;

    /// Are there none?
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What is known of all rays.
    fn properties(&self) -> Properties;

    /// States that `properties` are true of all rays. The caller promises it; debug builds check.
    fn promise(&mut self, properties: Properties);

    /// Takes `properties` back, so that general paths are taken. Always allowed.
    fn forget(&mut self, properties: Properties);

    /// In debug builds, panics if a property of the rays is set but false.
    fn check(&self);

    /// Origins, one slice an axis.
    fn origins(&self) -> [&[f32]; 3];

    /// Origins to write; clears the properties that this could make false.
    fn origins_mut(&mut self) -> [&mut [f32]; 3];

    /// Gives every ray the same origin, and says so.
    fn set_common_origin(&mut self, origin: Vec3);

    /// Directions, one slice an axis.
    fn directions(&self) -> [&[f32]; 3];

    /// Directions to write; clears the properties that this could make false.
    fn directions_mut(&mut self) -> [&mut [f32]; 3];

    /// Near ends of the intervals.
    fn t_min(&self) -> &[f32];

    /// Near ends of the intervals, to write.
    fn t_min_mut(&mut self) -> &mut [f32];

    /// Far ends of the intervals: after intersection the distances of the hits, after occlusion `-inf` where nothing gets through.
    fn t_max(&self) -> &[f32];

    /// Far ends of the intervals, to write.
    fn t_max_mut(&mut self) -> &mut [f32];
}

/// The active rays are always the first ones.
impl<const N: usize> Rays for mobula_core::Rays<N> {
    fn len(&self) -> usize {
        self.range().end
    }

    fn properties(&self) -> Properties {
        self.properties()
    }

    fn promise(&mut self, properties: Properties) {
        self.promise(properties);
    }

    fn forget(&mut self, properties: Properties) {
        self.forget(properties);
    }

    fn check(&self) {
        self.check();
    }

    fn origins(&self) -> [&[f32]; 3] {
        let [x, y, z] = self.origins();
        let end = self.range().end;
        [&x[..end], &y[..end], &z[..end]]
    }

    fn origins_mut(&mut self) -> [&mut [f32]; 3] {
        let end = self.range().end;
        let [x, y, z] = self.origins_mut();
        [&mut x[..end], &mut y[..end], &mut z[..end]]
    }

    fn set_common_origin(&mut self, origin: Vec3) {
        self.set_common_origin(origin);
    }

    fn directions(&self) -> [&[f32]; 3] {
        let [x, y, z] = self.directions();
        let end = self.range().end;
        [&x[..end], &y[..end], &z[..end]]
    }

    fn directions_mut(&mut self) -> [&mut [f32]; 3] {
        let end = self.range().end;
        let [x, y, z] = self.directions_mut();
        [&mut x[..end], &mut y[..end], &mut z[..end]]
    }

    fn t_min(&self) -> &[f32] {
        &self.t_min()[..self.range().end]
    }

    fn t_min_mut(&mut self) -> &mut [f32] {
        let end = self.range().end;
        &mut self.t_min_mut()[..end]
    }

    fn t_max(&self) -> &[f32] {
        &self.t_max[..self.range().end]
    }

    fn t_max_mut(&mut self) -> &mut [f32] {
        let end = self.range().end;
        &mut self.t_max[..end]
    }
}

macro_rules! stored {
    ($($name:ident $rays:literal $shape:literal,)+) => {
        /// A packet of rays and their hits, of any width.
        #[derive(Clone, Debug)]
        pub(super) enum Stored {
            $($name(Box<RayPacket<$rays>>),)+
        }

        impl Stored {
            /// A packet for so many rays.
            ///
            /// # Panics
            /// If there are no packets so wide.
            pub(super) fn new(width: usize) -> Self {
                match width {
                    $(0..=$rays => Self::$name(Box::default()),)+
                    _ => panic!("no packets hold {width} rays"),
                }
            }

            /// Makes the first `count` rays the active ones: full intervals, no hits, no properties.
            pub(super) fn reset(&mut self, count: usize) {
                match self {
                    $(Self::$name(packet) => packet.reset(0..count),)+
                }
            }

            pub(super) fn reset_hits(&mut self) {
                match self {
                    $(Self::$name(packet) => packet.reset_hits(),)+
                }
            }

            pub(super) fn rays(&self) -> &dyn Rays {
                match self {
                    $(Self::$name(packet) => &***packet,)+
                }
            }

            pub(super) fn rays_mut(&mut self) -> &mut dyn Rays {
                match self {
                    $(Self::$name(packet) => &mut ***packet,)+
                }
            }

            /// The rays with the ids that the last intersection left.
            pub(super) fn rays_and_ids(&mut self) -> (&mut dyn Rays, &mut [u32]) {
                match self {
                    $(Self::$name(packet) => {
                        let (rays, hits) = packet.split();
                        let end = rays.range().end;
                        (rays, &mut hits.primitive[..end])
                    })+
                }
            }

            pub(super) fn intersect<S: EveryWidth + ?Sized>(&mut self, token: AnyToken, structure: &S) -> Paths {
                match self {
                    $(Self::$name(packet) => Intersect::<$rays>::intersect(structure, token, packet),)+
                }
            }
        }

        /// A packet of any-hit rays, of any width.
        #[derive(Clone, Debug)]
        pub(super) enum StoredAnyHit {
            $($name(Box<AnyHitPacket<$rays>>),)+
        }

        impl StoredAnyHit {
            /// As [`Stored::new`].
            pub(super) fn new(width: usize) -> Self {
                match width {
                    $(0..=$rays => Self::$name(Box::default()),)+
                    _ => panic!("no packets hold {width} rays"),
                }
            }

            pub(super) fn reset(&mut self, count: usize) {
                match self {
                    $(Self::$name(packet) => packet.reset(0..count),)+
                }
            }

            pub(super) fn rays(&self) -> &dyn Rays {
                match self {
                    $(Self::$name(packet) => &***packet,)+
                }
            }

            pub(super) fn rays_mut(&mut self) -> &mut dyn Rays {
                match self {
                    $(Self::$name(packet) => &mut ***packet,)+
                }
            }

            /// The optical depths of what the rays have met.
            pub(super) fn depths(&self) -> &[u32] {
                match self {
                    $(Self::$name(packet) => &packet.depth()[..packet.range().end],)+
                }
            }

            pub(super) fn occlude<S: EveryWidth + ?Sized>(
                &mut self,
                token: AnyToken,
                structure: &S,
                opacity: Option<&dyn Opacity>,
            ) -> Paths {
                match self {
                    $(Self::$name(packet) => Intersect::<$rays>::occlude(structure, token, packet, opacity),)+
                }
            }
        }
    };
}
packet_widths!(stored);
