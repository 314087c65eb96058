//! The packet that goes through the rendering stack: rays, what they hit, and room for shading.

use std::ops::Range;

use mobula_core::NO_HIT;
use mobula_core::simd::{AnyToken, Scalar};
use mobula_core::traverse::Paths;

use super::column::{Column, Columns3, columns3, rows};
use super::intersect::EveryWidth;
use super::rays::{Rays, Stored};
use super::surface::Hits;

/// Neighbouring rays that hit the same geometry and material, or nothing (paper Figure 6).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// The rays.
    pub rays: Range<usize>,
    /// The number of the geometry and the index of the material; `None` where nothing was hit.
    pub hit: Option<(u32, u32)>,
}

/// Rays with their hits, image coordinates and colours, and room for derived values. Its width is how many rays it can hold;
/// the active rays are the first ones.
///
/// Make one a thread and [`reset`](Self::reset) it.
#[derive(Clone, Debug)]
pub struct Packet {
    width: usize,
    /// The level that its rays met a structure at, and that values are derived at.
    pub(super) token: AnyToken,
    pub(super) stored: Stored,
    /// Number of the geometry that each ray hit, `NO_HIT` where none.
    geometry: Column<u32>,
    /// Number of the primitive of that geometry.
    pub(super) primitive: Column<u32>,
    material: Column<u32>,
    runs: Vec<Run>,
    pub(super) derived: Derived,
    /// Image coordinates of each sample, in pixels (0.5, 0.5 is the middle of the first pixel).
    pub image: [Column<f32>; 2],
    /// Of each sample, the hash of its pixel, and its number there: what is chosen at random follows from these alone.
    pub samples: [Column<u32>; 2],
    /// How wide the cone is where each ray starts that stands for what the ray sees (Amanatides, "Ray Tracing with Cones", 1984).
    pub cone_widths: Column<f32>,
    /// By how much the cones become wider, for each unit of length.
    pub cone_spread: f32,
    /// How wide the cones are as a part of their pixel's: where pixels have several samples, each stands for a part.
    pub cone_part: f32,
    /// What of the light from behind the hits arrives where the rays start, and whether this is known.
    through: Column<f32>,
    has_through: bool,
    /// Colour of each ray, linear RGB: the result. Written by materials, backgrounds and media.
    pub color: Columns3,
    /// Index of the channel (viewpoint) that the packet belongs to.
    pub channel: u32,
    /// How many reflections or refractions the rays have behind them.
    pub depth: u32,
}

/// Values derived from rays and hits; sub-packets know which are there.
#[derive(Clone, Debug)]
pub(super) struct Derived {
    pub(super) position: Columns3,
    pub(super) normal: Columns3,
    pub(super) geometric_normal: Columns3,
    pub(super) error_scale: Column<f32>,
    pub(super) texture: Columns3,
    pub(super) derivatives: [Columns3; 2],
    pub(super) texture_area: Column<f32>,
    pub(super) color: Columns3,
}

impl Packet {
    /// A packet for so many rays. The first use is [`reset`](Self::reset).
    ///
    /// # Panics
    /// If there are no packets so wide: see [`PacketWidth::WIDEST`](super::PacketWidth::WIDEST).
    pub fn new(width: usize) -> Self {
        Self {
            width,
            token: AnyToken::Scalar(Scalar::new()),
            stored: Stored::new(width),
            geometry: Column::new(width),
            primitive: Column::new(width),
            material: Column::new(width),
            runs: Vec::new(),
            derived: Derived {
                position: columns3(width),
                normal: columns3(width),
                geometric_normal: columns3(width),
                error_scale: Column::new(width),
                texture: columns3(width),
                derivatives: [columns3(width), columns3(width)],
                texture_area: Column::new(width),
                color: columns3(width),
            },
            image: [Column::new(width), Column::new(width)],
            samples: [Column::new(width), Column::new(width)],
            cone_widths: Column::new(width),
            cone_spread: 0.0,
            cone_part: 1.0,
            through: Column::new(width),
            has_through: false,
            color: columns3(width),
            channel: 0,
            depth: 0,
        }
    }

    /// How many rays it can hold.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of active rays.
    pub fn len(&self) -> usize {
        self.rays().len()
    }

    /// Is no ray active?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Makes the first `count` rays the active ones: full intervals, no hits, no properties. Origins and directions keep their old
    /// values: set them.
    ///
    /// # Panics
    /// If there are more than the packet can hold.
    pub fn reset(&mut self, count: usize) {
        assert!(count <= self.width, "{count} rays in a packet of {}", self.width);
        self.stored.reset(count);
        self.geometry[..count].fill(NO_HIT);
        self.runs.clear();
        self.runs.push(Run { rays: 0..count, hit: None });
        self.depth = 0;
        self.has_through = false;
        self.cone_widths[..count].fill(0.0);
        self.cone_spread = 0.0;
        self.cone_part = 1.0;
    }

    /// Makes the cones of the active rays, which stood for whole pixels, a part of that wide.
    pub fn scale_cones(&mut self, by: f32) {
        self.cone_part = by;
        let count = self.len();
        self.cone_widths[..count].iter_mut().for_each(|width| *width *= by);
        self.cone_spread *= by;
    }

    /// Of each active ray, the fraction of the light from behind its hit that arrives where it starts, beside what its colour has
    /// already; `None` if that is nothing.
    pub fn through(&self) -> Option<&[f32]> {
        self.has_through.then(|| &self.through[..self.len()])
    }

    /// As [`through`](Self::through), to write: 0 at first.
    pub fn through_mut(&mut self) -> &mut [f32] {
        let count = self.len();
        if !self.has_through {
            self.through[..count].fill(0.0);
            self.has_through = true;
        }
        &mut self.through[..count]
    }

    /// The active rays.
    #[inline(always)]
    pub fn rays(&self) -> &dyn Rays {
        self.stored.rays()
    }

    /// The active rays, to change.
    #[inline(always)]
    pub fn rays_mut(&mut self) -> &mut dyn Rays {
        self.stored.rays_mut()
    }

    /// What a camera needs: the rays to make, and the image coordinates that they belong to. The columns of these may be read up to
    /// their ends.
    pub fn rays_and_image(&mut self) -> (&mut dyn Rays, [&[f32]; 2]) {
        let [x, y] = &self.image;
        (self.stored.rays_mut(), [x, y])
    }

    /// The parts that a derivation reads, and the one that it writes.
    pub(super) fn parts(&mut self, range: &Range<usize>) -> (Hits<'_>, &mut Derived) {
        (hits(self.token, self.stored.rays(), &self.primitive, range), &mut self.derived)
    }

    /// The hits of some rays.
    pub(super) fn hits(&self, range: &Range<usize>) -> Hits<'_> {
        hits(self.token, self.stored.rays(), &self.primitive, range)
    }

    /// The rays, and the colours to write.
    pub(super) fn rays_and_color(&mut self) -> (&dyn Rays, &mut Columns3) {
        (self.stored.rays(), &mut self.color)
    }

    /// Did ray `i` hit anything?
    #[inline(always)]
    pub fn was_hit(&self, i: usize) -> bool {
        self.geometry[i] != NO_HIT
    }

    /// Which geometry each active ray hit, `NO_HIT` where none.
    pub fn geometries(&self) -> &[u32] {
        &self.geometry[..self.len()]
    }

    /// Which primitive of its geometry each active ray hit; nothing is said where it hit none.
    pub fn primitives(&self) -> &[u32] {
        &self.primitive[..self.len()]
    }

    /// What the active rays hit, as far as is known: every ray is in one run, runs come in order, and neighbouring runs hit
    /// different things.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// The runs, and the colours to write.
    pub fn runs_and_colors(&mut self) -> (&[Run], &mut Columns3) {
        (&self.runs, &mut self.color)
    }

    /// Forgets all hits and lets the rays meet the primitives of a structure. [`found`](Self::found) has the ids of what they hit.
    pub fn intersect<S: EveryWidth + ?Sized>(&mut self, token: AnyToken, structure: &S) -> Paths {
        self.token = token;
        self.stored.reset_hits();
        self.stored.intersect(token, structure)
    }

    /// As [`intersect`](Self::intersect), but the rays keep what they have. A hit at the distance that a ray has already counts
    /// only if its id is lower than what `ids` says of the ray.
    pub fn intersect_further<S: EveryWidth + ?Sized>(&mut self, token: AnyToken, structure: &S, ids: &[u32]) -> Paths {
        let (_, stored) = self.stored.rays_and_ids();
        let count = stored.len();
        stored.copy_from_slice(&ids[..count]);
        self.stored.intersect(token, structure)
    }

    /// What the last intersection left, and where to write what it stands for.
    pub fn found(&mut self) -> Found<'_> {
        let (rays, ids) = self.stored.rays_and_ids();
        let count = ids.len();
        Found {
            ids,
            t: rays.t_max(),
            geometries: &mut self.geometry[..count],
            primitives: &mut self.primitive[..count],
            materials: &mut self.material[..count],
            runs: &mut self.runs,
        }
    }
}

fn hits<'a>(token: AnyToken, rays: &'a dyn Rays, primitives: &'a [u32], range: &Range<usize>) -> Hits<'a> {
    Hits {
        token,
        origins: rows(rays.origins(), range.clone()),
        directions: rows(rays.directions(), range.clone()),
        t: &rays.t_max()[range.clone()],
        primitives: &primitives[range.clone()],
    }
}

/// What an intersection has found: one row a ray in every slice.
#[derive(Debug)]
pub struct Found<'a> {
    /// The ids of what was hit; `NO_HIT` where nothing was.
    pub ids: &'a [u32],
    /// The distances.
    pub t: &'a [f32],
    /// Which geometries were hit, `NO_HIT` where none.
    pub geometries: &'a mut [u32],
    /// Which primitives of these.
    pub primitives: &'a mut [u32],
    /// Room for the indices of materials.
    pub materials: &'a mut [u32],
    /// See [`Packet::runs`].
    pub runs: &'a mut Vec<Run>,
}
