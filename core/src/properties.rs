//! What is known of all rays of a packet (paper 5.1.3).
//!
//! A property selects special-case code or says that a derived value is there. Each says what it promises, who sets it,
//! who may rely on it, and what clears it. A property that is set but false is a bug: debug builds check the promises
//! ([`Rays::check`](crate::Rays::check)) on entry to an acceleration structure.
//!
//! Of the paper's properties only those are here that select code. What is derived from hits (positions, normals, texture
//! coordinates) is known to the shading packets of the engine, and which question is asked (closest or any hit) to the packet's type.

bitflags::bitflags! {
    /// Flags of a packet. [`Rays::set_ray`](crate::Rays::set_ray) clears all that its change could make false.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Properties: u32 {
        /// All rays start at the same point, bit for bit. Set by who makes the rays (pinhole cameras, lights that send
        /// rays from themselves). Kernels and traversal hoist work out of the ray loop. Cleared by a new origin.
        const COMMON_ORIGIN = 1 << 0;
        /// Every direction has length 1 up to rounding (1e-5). Set by cameras or by
        /// [`Rays::normalize`](crate::Rays::normalize). Sphere kernels skip the length; t is a distance. Cleared by a new direction.
        const NORMALIZED_DIRECTIONS = 1 << 1;
        /// The reciprocals of the directions are there. Set by
        /// [`Rays::inverse_directions`](crate::Rays::inverse_directions). Box tests rely on it. Cleared by a new direction.
        const HAVE_INVERSE_DIRECTIONS = 1 << 2;
        /// On each axis all directions have the same sign bit. Set with `HAVE_INVERSE_DIRECTIONS` where true. Tests of diverged
        /// groups rely on it. Cleared by a new direction.
        const CONSTANT_SIGNS = 1 << 3;
        /// The shears of the watertight triangle test are there (Woop et al. 2013). Set by
        /// [`Rays::shears`](crate::Rays::shears). Triangle tests and frusta rely on it. Cleared by a new direction.
        const HAVE_SHEARS = 1 << 4;

        /// What a new origin makes unknown.
        const OF_ORIGIN = Self::COMMON_ORIGIN.bits();
        /// What a new direction makes unknown.
        const OF_DIRECTION = Self::NORMALIZED_DIRECTIONS.bits() | Self::HAVE_INVERSE_DIRECTIONS.bits()
            | Self::CONSTANT_SIGNS.bits() | Self::HAVE_SHEARS.bits();
    }
}
