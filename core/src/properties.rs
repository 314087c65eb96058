//! What is known of all rays of a packet (paper 5.1.3).
//!
//! A property selects special-case code or says that a derived value is there. Each says what it promises, who sets it,
//! who may rely on it, and what clears it. A property that is set but false is a bug: debug builds check the promises
//! about rays ([`Rays::check`](crate::Rays::check)) on entry to an acceleration structure.

bitflags::bitflags! {
    /// Flags of a packet. [`Rays::set_ray`](crate::Rays::set_ray) clears all that its change could make false.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Properties: u32 {
        /// All rays start at the same point, bit for bit. Set by who makes the rays (pinhole cameras, lights that send
        /// rays from themselves). Kernels and traversal hoist work out of the ray loop. Cleared by a new origin.
        const COMMON_ORIGIN = 1 << 0;
        /// All rays start at the camera's eye. Set by cameras, with `COMMON_ORIGIN`. Shaders may hoist the view vector.
        /// Cleared by a new origin.
        const CONSTANT_EYE = 1 << 1;
        /// The image coordinates of every sample are there. Set by pixel samplers; cameras rely on it. Cleared by `reset`.
        const HAVE_IMAGE_COORDINATES = 1 << 2;
        /// Every direction has length 1 up to rounding (1e-5). Set by cameras or by
        /// [`Rays::normalize`](crate::Rays::normalize). Sphere kernels skip the length; t is a distance. Cleared by a new direction.
        const NORMALIZED_DIRECTIONS = 1 << 3;
        /// The hit positions are there. Set by [`RayPacket::positions`](crate::RayPacket::positions). Cleared by new rays or hits.
        const HAVE_HIT_POSITIONS = 1 << 4;
        /// Only whether there is a hit is asked, not which. Set by [`AnyHitPacket`](crate::AnyHitPacket). Cleared by `reset`.
        const ANY_HIT = 1 << 5;
        /// Two texture coordinates a hit are there. Set by the surface that was hit. Cleared by new hits.
        const HAVE_TEXTURE_COORDINATES_2 = 1 << 6;
        /// Three texture coordinates a hit are there. Set by the surface that was hit. Cleared by new hits.
        const HAVE_TEXTURE_COORDINATES_3 = 1 << 7;
        /// Shading normals are there. Set by the surface that was hit. Cleared by new hits.
        const HAVE_NORMALS = 1 << 8;
        /// The shading normals have length 1 up to rounding. Set with `HAVE_NORMALS` or after it. Cleared with it.
        const HAVE_UNIT_NORMALS = 1 << 9;
        /// The shading normals face the ray's origin. Set by [`SubPacket::forward_normals`](crate::SubPacket::forward_normals). Cleared with `HAVE_NORMALS`.
        const HAVE_FORWARD_NORMALS = 1 << 10;
        /// Geometric normals are there (unit length). Set by the surface that was hit. Cleared by new hits.
        const HAVE_GEOMETRIC_NORMALS = 1 << 11;
        /// The reciprocals of the directions are there. Set by
        /// [`Rays::inverse_directions`](crate::Rays::inverse_directions). Cleared by a new direction.
        const HAVE_INVERSE_DIRECTIONS = 1 << 12;
        /// The sign masks of the directions are there. Set with `HAVE_INVERSE_DIRECTIONS`. Cleared with it.
        const HAVE_SIGNS = 1 << 13;
        /// On each axis all directions have the same sign bit. Set with `HAVE_SIGNS` where true. Packet traversal relies
        /// on it. Cleared by a new direction.
        const CONSTANT_SIGNS = 1 << 14;
        /// The packet is a rectangle of an image plane whose corner rays bound all others. Set by samplers together with
        /// a pinhole camera. Cleared by a new ray.
        const HAVE_CORNER_RAYS = 1 << 15;
        /// Position derivatives along the surface are there. Set by the surface that was hit. Cleared by new hits.
        const HAVE_SURFACE_DERIVATIVES = 1 << 16;
        /// All samples fall into one region of the sample square. Set by samplers. Cleared by `reset`.
        const CONSTANT_SAMPLE_REGION = 1 << 17;
        /// All rays belong to one pixel. Set by samplers. Cleared by `reset`.
        const CONSTANT_PIXEL = 1 << 18;
        /// Somebody wants to hear about this packet. Set by the user; any component may log. Cleared by `reset`.
        const DEBUG = 1 << 19;
        /// The shears of the watertight triangle test are there (Woop et al. 2013). Set by
        /// [`Rays::shears`](crate::Rays::shears). Cleared by a new direction.
        const HAVE_SHEARS = 1 << 20;
        /// All directions have the same dominant axis. Set with `HAVE_SHEARS` where true. Triangle kernels rely on it.
        /// Cleared by a new direction.
        const CONSTANT_AXIS = 1 << 21;

        /// What a new origin makes unknown.
        const OF_ORIGIN = Self::COMMON_ORIGIN.bits() | Self::CONSTANT_EYE.bits() | Self::HAVE_CORNER_RAYS.bits();
        /// What a new direction makes unknown.
        const OF_DIRECTION = Self::NORMALIZED_DIRECTIONS.bits() | Self::HAVE_INVERSE_DIRECTIONS.bits()
            | Self::HAVE_SIGNS.bits() | Self::CONSTANT_SIGNS.bits() | Self::HAVE_SHEARS.bits()
            | Self::CONSTANT_AXIS.bits() | Self::HAVE_CORNER_RAYS.bits();
        /// What new hits make unknown.
        const OF_HITS = Self::HAVE_HIT_POSITIONS.bits() | Self::HAVE_TEXTURE_COORDINATES_2.bits()
            | Self::HAVE_TEXTURE_COORDINATES_3.bits() | Self::HAVE_NORMALS.bits() | Self::HAVE_UNIT_NORMALS.bits()
            | Self::HAVE_FORWARD_NORMALS.bits() | Self::HAVE_GEOMETRIC_NORMALS.bits()
            | Self::HAVE_SURFACE_DERIVATIVES.bits();
    }
}
