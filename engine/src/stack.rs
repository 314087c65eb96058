//! The rendering stack: the traits of its interchangeable components (paper 5.4, Figure 5).
//!
//! image traverser -> load balancer -> pixel sampler -> renderer -> acceleration structure -> material / background.
//! Every component is chosen at run time and called once per packet or fragment, never once per ray. `N` is the packet
//! width, fixed at compile time; everything above the pixel sampler does not know it.

use core::ops::Range;
use std::cell::Cell;

use glam::Vec3;
use mobula_core::rays::{set_vec3, vec3};
use mobula_core::traverse::Paths;
use mobula_core::{AnyHitPacket, Column, Columns3, RayPacket, SubPacket};
use mobula_simd::AnyToken;

use crate::image::FrameBuffer;
use crate::scene::{Geometry, Scene};
pub use crate::traverse::Fragment;

/// What a thread carries through the stack while it renders a fragment: nothing above the renderer, the renderer and
/// all that it needs below.
#[derive(Clone, Copy)]
pub struct Context<'a, const N: usize> {
    /// The level whose kernels run.
    pub token: AnyToken,
    /// What is rendered.
    pub scene: &'a Scene<N>,
    /// Who traces secondary rays.
    pub renderer: &'a dyn Renderer<N>,
    /// This thread's counters.
    pub statistics: &'a Statistics,
    /// The number of the frame: samplers jitter by it. Keep it at 0 for pictures that must repeat.
    pub frame: u32,
}

/// Counters of one thread and one frame. Kept in cells: a thread owns its counters while it renders.
#[derive(Clone, Debug, Default)]
pub struct Statistics {
    /// Rays from the camera.
    pub primary: Cell<u64>,
    /// Any-hit rays towards lights.
    pub shadow: Cell<u64>,
    /// All other rays.
    pub secondary: Cell<u64>,
    /// Which paths they took through acceleration structures; a ray counts once for each structure that it met.
    pub paths: Cell<Paths>,
}

impl Statistics {
    /// Counts the active rays of a packet that a renderer is about to trace.
    pub fn count_rays<const N: usize>(&self, packet: &RayPacket<N>) {
        let counter = if packet.depth == 0 { &self.primary } else { &self.secondary };
        counter.set(counter.get() + packet.range().len() as u64);
    }

    /// Adds another thread's counters.
    pub fn add(&self, other: &Self) {
        for (mine, theirs) in
            [(&self.primary, &other.primary), (&self.shadow, &other.shadow), (&self.secondary, &other.secondary)]
        {
            mine.set(mine.get() + theirs.get());
        }
        self.count_paths(other.paths.get());
    }

    /// Adds what an acceleration structure says of the rays that it traced.
    pub fn count_paths(&self, more: Paths) {
        let mut paths = self.paths.get();
        paths += more;
        self.paths.set(paths);
    }
}

/// Turns pixels into samples, samples into rays, and their colours into pixels. Packets live on its stack frame.
pub trait PixelSampler<const N: usize>: Send + Sync {
    /// Renders the pixels of `fragment` into `out`.
    fn render_fragment(&self, context: &Context<'_, N>, camera: &dyn Camera<N>, fragment: Fragment, out: &FrameBuffer);
}

/// Makes rays from image coordinates.
pub trait Camera<const N: usize>: Send + Sync {
    /// Fills origins and directions of the active rays from `packet.image` (pixels, of an image of `size`), and sets the
    /// properties that hold. A sampler whose samples are a rectangle with a sample in each corner sets
    /// [`HAVE_CORNER_RAYS`](mobula_core::Properties::HAVE_CORNER_RAYS) before; a camera under which the corner rays of
    /// such a rectangle bound all others keeps it, any other clears it.
    fn make_rays(&self, context: &Context<'_, N>, size: [u32; 2], packet: &mut RayPacket<N>);
}

/// Traces a packet whose rays are there, and leaves a colour in each (paper Figure 6).
pub trait Renderer<const N: usize>: Send + Sync {
    /// Traces the active rays and writes `packet.color` for each of them.
    fn trace(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>);
}

/// Finds hits. What the surface is like there, the scene's [`Geometry`] knows.
pub trait AccelerationStructure<const N: usize>: Send + Sync {
    /// Lowers `t_max` of each active ray to its nearest hit and sets the primitive there. On equal distance the lower
    /// primitive id wins. The material is the scene's to fill in.
    fn intersect(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>);

    /// Sets `t_max` of each active ray that hits anything to `-inf`.
    fn occlude(&self, context: &Context<'_, N>, packet: &mut AnyHitPacket<N>);

    /// Follows primitives that moved: the same ids, at new places. Much cheaper than to build anew, but rays get slower
    /// the more the primitives have changed places. What is not finite or has no area now is left out until it has.
    ///
    /// # Errors
    /// [`NeedsRebuild`] if there are other primitives, or some that were left out when it was built; then nothing has
    /// changed.
    fn refit(&mut self, geometry: &Geometry) -> Result<(), NeedsRebuild>;

    /// Least and greatest corner of everything in it; `(inf, -inf)` when empty.
    fn bounds(&self) -> (Vec3, Vec3);
}

/// An acceleration structure cannot follow: primitives have come or gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the scene has other primitives than its acceleration structure was built over: build it anew")]
pub struct NeedsRebuild;

/// Colours hits.
pub trait Material<const N: usize>: Send + Sync {
    /// Writes the colour of every ray of the sub-packet: all hit this material.
    fn shade(&self, context: &Context<'_, N>, hits: &mut SubPacket<'_, N>);

    /// One colour that stands for it, unlit: what a renderer without lights shows.
    fn base_color(&self) -> Vec3;
}

/// Colours rays that hit nothing.
pub trait Background<const N: usize>: Send + Sync {
    /// Writes the colour of every ray of the sub-packet: none hit anything.
    fn shade(&self, context: &Context<'_, N>, misses: &mut SubPacket<'_, N>);
}

/// What reaches a set of points from a light.
#[derive(Clone, Debug, Default)]
pub struct Illumination<const N: usize> {
    /// Unit vectors from the points to the light.
    pub direction: Columns3<N>,
    /// Radiance that arrives, linear RGB.
    pub radiance: Columns3<N>,
    /// Distance to the light, infinite for a directional one.
    pub distance: Column<f32, N>,
}

impl<const N: usize> Illumination<N> {
    /// Unit vector from point `i` to the light.
    #[inline(always)]
    pub fn direction(&self, i: usize) -> Vec3 {
        vec3(&self.direction, i)
    }

    /// Radiance that arrives at point `i`.
    #[inline(always)]
    pub fn radiance(&self, i: usize) -> Vec3 {
        vec3(&self.radiance, i)
    }

    /// Sets the radiance that arrives at point `i`.
    #[inline(always)]
    pub fn set_radiance(&mut self, i: usize, radiance: Vec3) {
        set_vec3(&mut self.radiance, i, radiance);
    }
}

/// Lights points.
pub trait Light<const N: usize>: Send + Sync {
    /// Fills the rows `range` of `out` for the points of the same rows, as if nothing were in the way.
    fn illuminate(&self, points: &Columns3<N>, range: Range<usize>, out: &mut Illumination<N>);

    /// The point that all its light comes from, if there is one: shadow rays then start there and share an origin.
    fn position(&self) -> Option<Vec3>;
}
