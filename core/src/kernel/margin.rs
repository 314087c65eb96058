//! How far boxes are widened, so that nothing is lost to rounding.
//!
//! The primitive tests decide what is hit. A box may not hide what they would accept. Let u = 2^-24 and s the greatest size of
//! a coordinate of the ray's origin or of the tree, so that coordinates relative to the origin are at most 2 s, sheared
//! ones 4 s. The triangle test moves a corner sideways when it subtracts the origin (2 us, and as much through the
//! depth), rounds the shear factor (two roundings, 4 us), and shears (fused one rounding, 4 us; unfused two, 6 us): 14 us.
//! It accepts weights whose point is off the ray by [`OFF`](super::triangle::OFF) of 4 s: 64 us. Weighing, dividing and
//! scaling the depth takes ten roundings of 2 us: 20 us. The slab test errs by three roundings, which move a plane by 6 us,
//! and moving the origin rounds once: 7 us. A frustum, which is tested in place of a slab, rounds its base (7 us), moves it by
//! the margin (3 us), and rounds the plane's depth, product and sum (8 us): 18 us; where a group starts rounds once more
//! (2 us). Together 118 us < 2^-17 s. So every box is widened by [`PAD`] s, at no cost: the origins that are subtracted are
//! moved instead.

/// Boxes are widened by this much of the greatest coordinate: see the [module](self).
pub const PAD: f32 = 1.0 / (1 << 17) as f32;
