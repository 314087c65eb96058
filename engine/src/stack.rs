//! The rendering stack: the traits of its interchangeable components (paper 5.4, Figure 5), and the scene that they meet.
//!
//! image traverser -> load balancer -> pixel sampler -> renderer -> acceleration structure -> material / background / medium.
//! Every component is chosen at run time and called once per packet or fragment, never once per ray. None depends on the packet
//! width: they see columns, as slices with one row a ray.

use std::any::Any;
use std::cell::Cell;
use std::fmt::Debug;
use std::sync::Arc;

use glam::Vec3;
use mobula_core::simd::AnyToken;
use mobula_core::sink::OPAQUE;
use mobula_core::traverse::Paths;
pub use mobula_core::volume::Segments;

use crate::geometry::{Geometries, Geometry, Meeting, Translucent};
use crate::image::FrameBuffer;
pub use crate::lighting::{Illumination, Lit, Receivers};
use crate::packet::{AnyHitPacket, Columns3, Hits, Packet, Rays, SubPacket, optical_depth, part, set_vec3, vec3};
use crate::pipeline::fault::scope;
use crate::scratch::{Lent, lend};
use crate::texture::{Maps, OpacityMap};
use crate::tone::Tone;
pub use crate::traverse::Fragment;
use crate::view::{Up, View};

/// What a thread carries through the stack while it renders a fragment: nothing above the renderer, the renderer and
/// all that it needs below.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The level whose kernels run.
    pub token: AnyToken,
    /// Rays in a packet; at most [`PacketWidth::WIDEST`](crate::packet::PacketWidth::WIDEST).
    pub width: usize,
    /// What is rendered.
    pub scene: &'a Scene,
    /// Who traces secondary rays.
    pub renderer: &'a dyn Renderer,
    /// This thread's counters.
    pub statistics: &'a Statistics,
    /// How what arrives is shown.
    pub tone: Tone,
    /// Where the camera is, if it is at one place.
    pub eye: Option<Vec3>,
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
    /// Counts the rays of a packet that a renderer is about to trace.
    pub fn count_rays(&self, packet: &Packet) {
        let counter = if packet.depth == 0 { &self.primary } else { &self.secondary };
        counter.set(counter.get() + packet.len() as u64);
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

/// Turns pixels into samples, samples into rays, and their colours into pixels.
pub trait PixelSampler: Send + Sync {
    /// Renders the pixels of `fragment` into `out`.
    fn render_fragment(&self, context: &Context<'_>, camera: &dyn Camera, fragment: Fragment, out: &FrameBuffer);
}

/// Makes rays from image coordinates.
pub trait Camera: Send + Sync {
    /// Fills origins and directions of the rays from `packet.image` (pixels, of an image of `size`), and sets the properties that
    /// hold. What it makes of a sample must depend on that sample alone, and be the same bits at every level.
    fn make_rays(&self, context: &Context<'_>, size: [u32; 2], packet: &mut Packet);

    /// Where it is, for lights that go with it.
    fn eye(&self) -> Option<Vec3> {
        None
    }
}

/// Traces a packet whose rays are there, and leaves a colour in each (paper Figure 6).
pub trait Renderer: Send + Sync {
    /// Traces the rays and writes `packet.color` for each of them.
    fn trace(&self, context: &Context<'_>, packet: &mut Packet);
}

/// Colours hits.
pub trait Material: Any + Debug + Send + Sync {
    /// Writes the colour of every ray of the sub-packet: all hit this material. `lit` is what reaches the hits from the scene's lights.
    fn shade(&self, context: &Context<'_>, hits: &mut SubPacket<'_>, lit: Lit<'_>);

    /// Does light change it? If not, it is handed none, and none is looked for.
    fn is_lit(&self) -> bool {
        true
    }

    /// Its textures.
    fn maps(&self) -> &Maps {
        Maps::NONE
    }

    /// One colour that stands for it, unlit: what a renderer without lights shows.
    fn base_color(&self) -> Vec3;

    /// The colour of the surface at hits, unlit: sets the first rows of `out`.
    fn albedo(&self, hits: &mut SubPacket<'_>, out: &mut Columns3) {
        let (color, count) = (self.base_color(), hits.len());
        out.iter_mut().zip(color.to_array()).for_each(|(column, channel)| column[..count].fill(channel));
        for (column, own) in out.iter_mut().zip(hits.own_colors().into_iter().flatten()) {
            column.iter_mut().zip(own).for_each(|(channel, own)| *channel *= own);
        }
        if let Some(map) = &self.maps().color {
            hits.sample(map, |i, texel| set_vec3(out, i, vec3(out, i) * texel.truncate()));
        }
    }

    /// The fraction of the light towards a surface that it stops, 0 to 1: what is behind gets the rest. Asked when the material is put
    /// into the scene.
    fn opacity(&self) -> f32 {
        1.0
    }

    /// The same for a scene whose lengths are all multiplied by `scale`; `None` if it has no lengths.
    fn scaled(&self, _scale: f32) -> Option<Arc<dyn Material>> {
        None
    }

    /// What it looks like, in a few words for people.
    fn describe(&self) -> String;
}

impl dyn Material {
    /// The material as what it is, if it is of that type.
    pub fn downcast_ref<M: Material>(&self) -> Option<&M> {
        (self as &dyn Any).downcast_ref()
    }
}

/// Colours rays that hit nothing.
pub trait Background: Any + Debug + Send + Sync {
    /// Writes the colour of every ray of the sub-packet: none hit anything.
    fn shade(&self, context: &Context<'_>, misses: &mut SubPacket<'_>);

    /// How it lights a scene whose axis that is up is `up`; `None` if it does not. Asked when the scene is built.
    fn light(&self, _up: Up) -> Option<SkyLight> {
        None
    }
}

impl dyn Background {
    /// The background as what it is, if it is of that type.
    pub fn downcast_ref<B: Background>(&self) -> Option<&B> {
        (self as &dyn Any).downcast_ref()
    }
}

/// How a background lights a scene: instead of the usual light and the ambient light, and beside lights that the scene has.
#[derive(Clone, Debug)]
pub struct SkyLight {
    /// Lights.
    pub lights: Vec<Arc<dyn Light>>,
    /// Light that comes from everywhere.
    pub ambient: Arc<dyn AmbientLight>,
}

/// Lights points.
pub trait Light: Any + Debug + Send + Sync {
    /// Fills a row of `out` for each of the points, as if nothing were in the way. What is in rows behind them is lost. What it says of a
    /// point must depend on that point alone, with [what is chosen for it](Receivers::choose), and be the same at every level.
    fn illuminate(&self, context: &Context<'_>, points: Receivers<'_>, out: &mut Illumination);

    /// The point that all its light comes from, if there is one: shadow rays then start there and share an origin.
    fn position(&self, context: &Context<'_>) -> Option<Vec3>;
}

impl dyn Light {
    /// The light as what it is, if it is of that type.
    pub fn downcast_ref<L: Light>(&self) -> Option<&L> {
        (self as &dyn Any).downcast_ref()
    }
}

/// Light that comes from everywhere, without shadows.
pub trait AmbientLight: Any + Debug + Send + Sync {
    /// Fills a row of `out` with the radiance that a surface gets, for each of the unit `normals`. `up` points up.
    /// The results are the same at every level.
    fn illuminate(&self, token: AnyToken, up: Vec3, normals: [&[f32]; 3], out: [&mut [f32]; 3]);
}

/// What is between surfaces. What it says of a segment must depend on that segment alone, and be the same bits at every level of a numeric
/// family.
pub trait Medium: Any + Debug + Send + Sync {
    /// For each segment: the radiance that the medium adds, as it arrives at the beginning, linear RGB; and the fraction of the light
    /// from the end that arrives there.
    fn march(
        &self,
        context: &Context<'_>,
        segments: &Segments<'_>,
        radiance: [&mut [f32]; 3],
        transmittance: &mut [f32],
    );

    /// For each segment, the fraction of the light that gets through.
    fn transmittance(&self, context: &Context<'_>, segments: &Segments<'_>, out: &mut [f32]);

    /// The part of each segment that may be in the medium; nothing of it where the second is not greater. All of it, if the medium is
    /// everywhere.
    fn clip(&self, segments: &Segments<'_>, t0: &mut [f32], t1: &mut [f32]) {
        t0.copy_from_slice(segments.t0);
        t1.copy_from_slice(segments.t1);
    }

    /// Within such a length nothing of it changes much: where media overlap, they are mixed in parts of this length. Infinite, if it is
    /// the same everywhere.
    fn grain(&self) -> f32 {
        f32::INFINITY
    }

    /// Calls `visit` with points around all of it; with none, if it has no end.
    fn extremes(&self, _visit: &mut dyn FnMut(Vec3)) {}
}

impl dyn Medium {
    /// The medium as what it is, if it is of that type.
    pub fn downcast_ref<M: Medium>(&self) -> Option<&M> {
        (self as &dyn Any).downcast_ref()
    }
}

/// A material and what people call it.
#[derive(Clone, Debug)]
pub struct NamedMaterial {
    /// Its name.
    pub name: String,
    /// The material.
    pub material: Arc<dyn Material>,
}

/// The materials of a scene, by index.
#[derive(Clone, Debug)]
pub struct Materials {
    list: Vec<NamedMaterial>,
    /// What faults in them are called.
    scopes: Vec<String>,
    /// How deep their surfaces are for light that wants through.
    depths: Vec<u32>,
    /// The indices of those that let light through.
    transparent: Vec<u32>,
    /// Are textures holes of any?
    has_holes: bool,
}

impl Materials {
    /// These materials; the last is the default one, which every index that is out of range means.
    ///
    /// # Panics
    /// If there is none.
    pub fn new(list: Vec<NamedMaterial>) -> Self {
        assert!(!list.is_empty(), "there is a default material");
        let scopes = list.iter().map(|named| format!("material {}", named.name)).collect();
        let mut materials = Self { list, scopes, depths: Vec::new(), transparent: Vec::new(), has_holes: false };
        materials.measure();
        materials
    }

    /// Finds which of them let light through.
    fn measure(&mut self) {
        let holes = |named: &NamedMaterial| named.material.maps().opacity.is_some();
        self.depths = self.list.iter().map(|named| optical_depth(named.material.opacity())).collect();
        let transparent = (0..).zip(self.list.iter().zip(&self.depths));
        self.transparent = transparent
            .filter(|(_, (named, depth))| **depth < OPAQUE || holes(named))
            .map(|(index, _)| index)
            .collect();
        self.has_holes = self.list.iter().any(holes);
    }

    /// What faults in the material of an index are called.
    pub fn scope(&self, index: u32) -> &str {
        &self.scopes[index.min(self.last()) as usize]
    }

    /// The index of the default material.
    pub fn last(&self) -> u32 {
        (self.list.len() - 1) as u32
    }

    /// All of them.
    pub fn list(&self) -> &[NamedMaterial] {
        &self.list
    }

    /// The material of an index.
    pub fn get(&self, index: u32) -> &dyn Material {
        &*self.list[index.min(self.last()) as usize].material
    }

    /// Replaces a material. Does nothing if there is no such index.
    pub fn set(&mut self, index: u32, material: Arc<dyn Material>) {
        if let Some(place) = self.list.get_mut(index as usize) {
            place.material = material;
            self.measure();
        }
    }

    /// How deep a surface of a material is that stops itself so much of the light.
    fn depth(&self, index: u32, opacity: f32) -> u32 {
        if opacity < 1.0 {
            return optical_depth(opacity * self.get(index).opacity());
        }
        self.depths[index.min(self.last()) as usize]
    }
}

/// What keeps light that comes from everywhere away from surfaces is looked for with so many rays a hit, as far as that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occlusion {
    /// Rays a hit, at least 1. Samples of a pixel share their work: of 16 samples, one ray each is enough.
    pub rays: u32,
    /// What is farther away than this keeps no light away.
    pub distance: f32,
}

impl Default for Occlusion {
    /// A few rays, however far.
    fn default() -> Self {
        Self { rays: 4, distance: f32::INFINITY }
    }
}

/// All that rays meet: geometry, materials, lights, background. Any of it may be replaced between frames.
#[derive(Debug)]
pub struct Scene {
    /// What rays hit.
    pub geometry: Geometries,
    /// What its surfaces look like.
    pub materials: Materials,
    /// Where light comes from.
    pub lights: Vec<Arc<dyn Light>>,
    /// Light that comes from everywhere.
    pub ambient: Arc<dyn AmbientLight>,
    /// How what keeps that light away is looked for; `None`: it is not.
    pub occlusion: Option<Occlusion>,
    /// What is seen where nothing is.
    pub background: Arc<dyn Background>,
    /// What is between surfaces.
    pub media: Vec<Arc<dyn Medium>>,
    /// Are lights tested for what stands before them?
    pub shadows: bool,
    /// Which way is up.
    pub up: Up,
    /// By how many quarter turns around that axis the view that frames everything is turned from its usual direction.
    pub turns: u8,
    /// Where to look from; `None` frames everything.
    pub view: Option<View>,
    /// Bounds of geometry and media as the scene was built, less what was far from most of it: views and lights go by them.
    pub bulk: (Vec3, Vec3),
}

impl Scene {
    /// Finds the nearest hit of each ray, and splits the packet into runs of one geometry and material.
    pub fn intersect(&self, context: &Context<'_>, packet: &mut Packet) {
        packet.rays().check();
        let last = self.materials.last();
        let paths = scope("acceleration structure", || self.geometry.intersect(context.token, packet, last));
        context.statistics.count_paths(paths);
    }

    /// Finds which rays get through: those whose `t_max` is not `-inf` afterwards. Surfaces that let a part of the light through
    /// leave their [optical depth](AnyHitPacket::depths).
    pub fn occlude(&self, context: &Context<'_>, packet: &mut AnyHitPacket) {
        packet.rays().check();
        // What textures say of a hit depends on where it is, and the packet's own rays are taken while it is traced.
        let lines = self.materials.has_holes.then(|| Lines::of(packet.rays(), context.width));
        let token = context.token;
        let depth = |at: Meeting| {
            let mut material = [0];
            let geometry = self.geometry.get(at.geometry);
            let material = geometry.materials(&[at.primitive], &mut material).unwrap_or(material[0]);
            let opacity = geometry.opacity(at.primitive);
            match (&lines, &self.materials.get(material).maps().opacity) {
                (Some(lines), Some(holes)) => optical_depth(opacity * lines.opacity(token, geometry, at, holes)),
                _ => self.materials.depth(material, opacity),
            }
        };
        let light = Translucent { materials: &self.materials.transparent, last: self.materials.last(), depths: &depth };
        let paths = scope("acceleration structure", || self.geometry.occlude(context.token, packet, &light));
        context.statistics.count_paths(paths);
    }

    /// Calls `visit` with points around all that can be seen.
    pub fn extremes(&self, visit: &mut dyn FnMut(Vec3)) {
        self.geometry.extremes(visit);
        self.media.iter().for_each(|medium| medium.extremes(visit));
    }

    /// The bounds of all that can be seen; the first corner is not less where there is nothing.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        bounds(&self.geometry, &self.media)
    }

    /// Where to look from, for an image whose width is `aspect` times its height: as the scene says, or so that
    /// everything is seen.
    pub fn view(&self, aspect: f32) -> View {
        self.view.unwrap_or_else(|| self.framed(aspect))
    }

    /// The view that shows everything, but what is far from most of it.
    pub fn framed(&self, aspect: f32) -> View {
        let eye = View::usual_direction(self.up, self.turns);
        let toward = View { eye, at: Vec3::ZERO, up: self.up.vector(), fov: View::DEFAULT_FOV };
        self.fitted(&toward, aspect)
    }

    /// The same in the direction of a view.
    pub fn fitted(&self, view: &View, aspect: f32) -> View {
        view.fit(|visit| self.visit_bulk(visit), self.bulk, aspect)
    }

    /// Calls `visit` with points around most of the scene.
    fn visit_bulk(&self, visit: &mut dyn FnMut(Vec3)) {
        let (low, high) = self.bulk;
        self.extremes(&mut |point| {
            if point.cmpge(low).all() && point.cmple(high).all() {
                visit(point);
            }
        });
    }
}

/// Where any-hit rays go, beside their packet.
struct Lines {
    origins: Lent<Columns3>,
    directions: Lent<Columns3>,
}

impl Lines {
    fn of(rays: &dyn Rays, width: usize) -> Self {
        let copy = |from: [&[f32]; 3]| {
            let mut to: Lent<Columns3> = lend(width);
            to.iter_mut().zip(from).for_each(|(to, from)| to[..from.len()].copy_from_slice(from));
            to
        };
        Self { origins: copy(rays.origins()), directions: copy(rays.directions()) }
    }

    /// How opaque a surface is where a ray meets it, as a texture says.
    fn opacity(&self, token: AnyToken, geometry: &dyn Geometry, at: Meeting, holes: &OpacityMap) -> f32 {
        let row = at.ray..at.ray + 1;
        let (origins, directions) = (part(&self.origins, row.clone()), part(&self.directions, row));
        let hits = Hits { token, origins, directions, t: &[at.t], primitives: &[at.primitive] };
        let [mut u, mut v, mut w] = [[0.0]; 3];
        geometry.texture_coordinates(&hits, [&mut u, &mut v, &mut w]);
        holes.opacity(holes.map.sample([u[0], v[0]], 0.0))
    }
}

/// The bounds of geometry and media.
pub fn bounds(geometry: &Geometries, media: &[Arc<dyn Medium>]) -> (Vec3, Vec3) {
    let (mut low, mut high) = geometry.bounds();
    let mut include = |point: Vec3| (low, high) = (low.min(point), high.max(point));
    media.iter().for_each(|medium| medium.extremes(&mut include));
    (low, high)
}
