//! The rendering stack: the traits of its interchangeable components (paper 5.4, Figure 5).
//!
//! image traverser -> load balancer -> pixel sampler -> renderer -> acceleration structure -> material / background.
//! Every component is chosen at run time and called once per packet or fragment, never once per ray. `N` is the packet
//! width, fixed at compile time; everything above the pixel sampler does not know it.

use core::ops::Range;
use std::cell::Cell;

use glam::Vec3;
use mobula_core::{AnyHitPacket, Columns3, RayPacket, SubPacket, Surface};
use mobula_simd::AnyToken;

use crate::image::FrameBuffer;
use crate::scene::Scene;

/// What a thread carries through the stack while it renders a fragment. `C` is what may be called back: nothing above
/// the renderer, the renderer and all that it needs below.
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
    /// Packets that the acceleration structure traced along each path.
    pub paths: Cell<mobula_core::traverse::Paths>,
}

/// Part of a frame: pixels `[x0, x1) x [y0, y1)` of one channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fragment {
    /// Which viewpoint.
    pub channel: usize,
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// Column after the last.
    pub x1: u32,
    /// Row after the last.
    pub y1: u32,
}

/// Turns pixels into samples, samples into rays, and their colours into pixels. Packets live on its stack frame.
pub trait PixelSampler<const N: usize>: Send + Sync {
    /// Renders the pixels of `fragment` into `out`.
    fn render_fragment(&self, context: &Context<'_, N>, camera: &dyn Camera<N>, fragment: Fragment, out: &FrameBuffer);
}

/// Makes rays from image coordinates.
pub trait Camera<const N: usize>: Send + Sync {
    /// Fills origins and directions of the active rays from `packet.image` (pixels, of an image of `size`), and sets the
    /// properties that hold.
    fn make_rays(&self, context: &Context<'_, N>, size: [u32; 2], packet: &mut RayPacket<N>);
}

/// Traces a packet whose rays are there, and leaves a colour in each (paper Figure 6).
pub trait Renderer<const N: usize>: Send + Sync {
    /// Traces the active rays and writes `packet.color` for each of them.
    fn trace(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>);
}

/// Finds hits. Also knows the surfaces that it holds.
pub trait AccelerationStructure<const N: usize>: Surface<N> + Send + Sync {
    /// Lowers `t_max` of each active ray to its nearest hit and sets the primitive there. On equal distance the lower
    /// primitive id wins. Counts the path taken.
    fn intersect(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>);

    /// Sets `t_max` of each active ray that hits anything to `-inf`.
    fn occlude(&self, context: &Context<'_, N>, packet: &mut AnyHitPacket<N>);

    /// Least and greatest corner of everything in it; `(inf, -inf)` when empty.
    fn bounds(&self) -> (Vec3, Vec3);
}

/// Colours hits.
pub trait Material<const N: usize>: Send + Sync {
    /// Writes the colour of every ray of the sub-packet: all hit this material.
    fn shade(&self, context: &Context<'_, N>, hits: &mut SubPacket<'_, N>);
}

/// Colours rays that hit nothing.
pub trait Background<const N: usize>: Send + Sync {
    /// Writes the colour of every ray of the sub-packet: none hit anything.
    fn shade(&self, context: &Context<'_, N>, misses: &mut SubPacket<'_, N>);
}

/// What reaches a set of points from a light, before anything is in the way.
#[derive(Clone, Debug)]
pub struct Illumination<const N: usize> {
    /// Unit vectors from the points to the light.
    pub direction: Columns3<N>,
    /// Radiance that arrives, linear RGB.
    pub radiance: Columns3<N>,
    /// Distance to the light, infinite for a directional one.
    pub distance: mobula_core::Column<f32, N>,
}

/// Lights points.
pub trait Light<const N: usize>: Send + Sync {
    /// Fills the rows `range` of `out` for the points of the same rows.
    fn illuminate(&self, points: &Columns3<N>, range: Range<usize>, out: &mut Illumination<N>);

    /// The point that all its light comes from, if there is one: shadow rays then start there and share an origin.
    fn position(&self) -> Option<Vec3>;
}
