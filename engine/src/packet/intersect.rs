//! What finds hits at every packet width that the engine is built for.

use mobula_core::simd::AnyToken;
use mobula_core::sink::Opacity;
use mobula_core::traverse::Paths;
use mobula_core::{AnyHitPacket, RayPacket};

use super::width::packet_widths;

/// What finds the hits of packets of `N` rays. Implement it once, for all `N`.
pub trait Intersect<const N: usize> {
    /// Lowers `t_max` of each active ray to its nearest hit and sets the id of the primitive there. On equal distance the lower
    /// id wins, also over the one that the packet has.
    fn intersect(&self, token: AnyToken, packet: &mut RayPacket<N>) -> Paths;

    /// Sets `t_max` of each active ray that hits anything to `-inf`. With an `opacity`, which is asked by id, adds to each ray's
    /// optical depth what it meets, and stops it only where that is [`OPAQUE`](mobula_core::sink::OPAQUE).
    fn occlude(&self, token: AnyToken, packet: &mut AnyHitPacket<N>, opacity: Option<&dyn Opacity>) -> Paths;
}

macro_rules! every_width {
    ($($name:ident $rays:literal $shape:literal,)+) => {
        /// [`Intersect`] at every width: what implements it for all `N` has this for free.
        pub trait EveryWidth: $(Intersect<$rays> +)+ {}

        impl<T: $(Intersect<$rays> +)+> EveryWidth for T {}
    };
}
packet_widths!(every_width);
