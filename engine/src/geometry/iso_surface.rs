//! Surfaces of equal value in a volume, without triangles: a change of the value costs nothing.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use mobula_core::simd::AnyToken;
use mobula_core::sink::Opacity;
use mobula_core::traverse::{Local, Paths};
use mobula_core::volume::IsoTree;
use mobula_core::{AnyHitPacket, RayPacket};

use super::field::{Field, Series};
use super::gradient::Gradient;
use super::{Census, DEFAULT_MATERIAL, Geometry, Item, Structure, shift_material};
use crate::accel::Build;
use crate::math::normalize_or;
use crate::packet::{Hits, Intersect, PacketWidth, Surface, set_vec3};
use crate::scratch::{ForWidth, lend};
use crate::volume::{Grid, GridPlace};

/// Surfaces of equal value in a volume: primitive i is that of value i.
#[derive(Clone, Debug)]
pub struct IsoSurfaces {
    /// What people call them.
    pub name: String,
    /// The volume.
    pub series: Series,
    /// The values; of one that is NaN there is no surface.
    pub values: Vec<f64>,
    /// Index of the material of each surface; [`DEFAULT_MATERIAL`] where there is none.
    pub materials: Vec<u32>,
    /// Planes (a, b, c, d): where a x + b y + c z > d, nothing is seen.
    pub cuts: Vec<[f64; 4]>,
}

const SURFACES: Item = Item::primitives("iso_surfaces", "iso-surface", "iso-surfaces");
const VOXELS: Item = Item::detail("voxels", "voxel", "voxels");
const NOT_FINITE: Item =
    Item::left_out("non_finite_iso_values", "iso value that is no number", "iso values that are no numbers");

impl IsoSurfaces {
    /// Two shells around the middle of a small grid, the outer one cut.
    pub fn example(material: u32) -> Self {
        let value = |i: usize| {
            let p = DVec3::new((i % 17) as f64, (i / 17 % 17) as f64, (i / 289) as f64) / 8.0 - 1.0;
            (200.0 * (1.0 - p.length() + 0.05 * (9.0 * p.x).sin() * (7.0 * p.y).cos())).clamp(0.0, 255.0) as u8
        };
        let place = GridPlace { origin: DVec3::splat(-1.0), ..GridPlace::with_spacing([0.125; 3]) };
        let voxels = (0..17_usize.pow(3)).map(value).collect::<Vec<_>>();
        let grid = Grid::new([17; 3], voxels.into(), place, [1.0, 0.0]).expect("a sound grid");
        Self {
            name: "two shells".to_owned(),
            series: Series::new(vec![Arc::new(Field::new(Arc::new(grid)).expect("a small grid"))]),
            values: vec![30.5, 100.0],
            materials: vec![material; 2],
            cuts: vec![[0.8, 0.6, 0.0, 0.55]],
        }
    }

    fn field(&self) -> &Arc<Field> {
        self.series.field()
    }

    fn sound(&self) -> bool {
        self.values.iter().all(|value| value.is_finite())
    }

    /// The values in the samples' own numbers.
    fn voxels(&self) -> Vec<f32> {
        self.values.iter().map(|value| self.field().grid().voxel_of(*value) as f32 + 0.0).collect()
    }

    /// What finds the hits.
    fn finder(&self) -> Finder {
        let to_cells = self.field().to_cells();
        let row = |axis: usize| {
            let row = to_cells.matrix3.row(axis);
            [row.x, row.y, row.z, to_cells.translation[axis]]
        };
        let cuts = self.cuts.iter().map(|&[a, b, c, d]| [a, b, c, -d]).collect();
        Finder { field: self.field().clone(), values: self.voxels(), local: Local::new([row(0), row(1), row(2)], cuts) }
    }

    /// Normals point to where values are less.
    fn fill_normals(&self, hits: &Hits<'_>, how: Gradient, out: &mut [&mut [f32]; 3]) {
        let points = (0..hits.len()).map(|i| self.field().cells_of(hits.position(i)));
        let rising = self.field().grid().scale()[0] > 0.0;
        self.field().gradients(points, how, |i, gradient| {
            let down = if rising { -gradient } else { gradient };
            // Where it is flat: towards the ray.
            let towards = -hits.ray(i).1;
            let fallback = normalize_or(towards.to_array().map(f64::from), Vec3::Y);
            set_vec3(out, i, normalize_or(down.to_array().map(f64::from), fallback));
        });
    }
}

impl Geometry for IsoSurfaces {
    fn name(&self) -> &str {
        &self.name
    }

    fn primitives(&self) -> usize {
        self.values.len()
    }

    fn census(&self) -> Census {
        let mut census = Census::default();
        census.add(SURFACES, self.values.len() as u64);
        census.add(VOXELS, self.field().grid().voxels().len() as u64);
        if !self.sound() {
            let bad = self.values.iter().filter(|value| !value.is_finite()).count();
            census.add(NOT_FINITE, bad as u64);
        }
        self.field().corners().into_iter().for_each(|corner| census.include(corner, 0.0));
        census
    }

    /// Corners of the bricks that surfaces pass through: most of a volume may be empty.
    fn extremes(&self, visit: &mut dyn FnMut(Vec3)) {
        let mut any = false;
        self.field().visit_bricks(&self.voxels(), &mut |point| {
            any = true;
            visit(point);
        });
        if !any {
            self.field().corners().into_iter().for_each(visit);
        }
    }

    fn materials(&self, primitives: &[u32], out: &mut [u32]) -> Option<u32> {
        let material = |number: usize| self.materials.get(number).copied().unwrap_or(DEFAULT_MATERIAL);
        if self.values.len() == 1 {
            return Some(material(0));
        }
        for (out, &primitive) in out.iter_mut().zip(primitives) {
            *out = material(primitive as usize);
        }
        None
    }

    fn shift_materials(mut self: Arc<Self>, shift: u32) -> Arc<dyn Geometry> {
        let surfaces = Arc::make_mut(&mut self);
        surfaces.materials.iter_mut().for_each(|index| shift_material(index, shift));
        self
    }

    fn shares_structure(&self) -> bool {
        false
    }

    fn structure(&self, _members: &[Arc<dyn Geometry>], _build: &Build) -> Box<dyn Structure> {
        Box::new(self.finder())
    }
}

impl Surface for IsoSurfaces {
    /// The error scale is the extent of the grid.
    fn geometric_normals(&self, hits: &Hits<'_>, mut out: [&mut [f32]; 3], error_scales: &mut [f32]) {
        self.fill_normals(hits, Gradient::Exact, &mut out);
        let (grid, spacing) = (self.field().grid(), self.field().grid().place().spacing());
        let extent = (0..3).map(|axis| spacing[axis] * grid.dims()[axis] as f64).fold(0.0, f64::max);
        error_scales.fill(extent as f32);
    }

    fn normals(&self, hits: &Hits<'_>, mut out: [&mut [f32]; 3]) -> bool {
        self.fill_normals(hits, Gradient::Smooth, &mut out);
        true
    }

    /// The position in the grid, from 0 to 1.
    fn texture_coordinates(&self, hits: &Hits<'_>, mut out: [&mut [f32]; 3]) {
        let most = self.field().grid().dims().map(|n| n.saturating_sub(1).max(1) as f64);
        for i in 0..hits.len() {
            let at = self.field().cells_of(hits.position(i)) / DVec3::from(most);
            set_vec3(&mut out, i, at.as_vec3());
        }
    }
}

/// Finds the hits of iso-surfaces.
#[derive(Debug)]
struct Finder {
    field: Arc<Field>,
    /// The values as samples are stored.
    values: Vec<f32>,
    local: Local,
}

/// Room for the rays of any packet, moved into the grid.
#[derive(Default)]
struct Moved(Box<RayPacket<WIDEST>>);

/// The same for any-hit rays.
#[derive(Default)]
struct MovedAnyHit(Box<AnyHitPacket<WIDEST>>);

const WIDEST: usize = PacketWidth::WIDEST;

impl ForWidth for Moved {
    fn for_width(_width: usize) -> Self {
        Self::default()
    }
}

impl ForWidth for MovedAnyHit {
    fn for_width(_width: usize) -> Self {
        Self::default()
    }
}

impl<const N: usize> Intersect<N> for Finder {
    fn intersect(&self, token: AnyToken, packet: &mut RayPacket<N>) -> Paths {
        let moved: &mut Moved = &mut lend(WIDEST);
        self.local.intersect(&IsoTree::new(&*self.field, &self.values), token, packet, &mut moved.0)
    }

    fn occlude(&self, token: AnyToken, packet: &mut AnyHitPacket<N>, opacity: Option<&dyn Opacity>) -> Paths {
        let moved: &mut MovedAnyHit = &mut lend(WIDEST);
        self.local.occlude(&IsoTree::new(&*self.field, &self.values), token, packet, &mut moved.0, opacity)
    }
}

impl Structure for Finder {
    fn primitives(&self) -> usize {
        self.values.len()
    }

    fn bytes(&self) -> usize {
        self.field.bytes()
    }

    fn can_refit(&self, members: &[Arc<dyn Geometry>]) -> bool {
        members.len() == 1
            && members[0].downcast_ref::<IsoSurfaces>().is_some_and(|new| new.values.len() == self.values.len())
    }

    /// Other values, another step of time, other cuts: nothing has to be built.
    fn refit(&mut self, members: &[Arc<dyn Geometry>]) {
        if let Some(new) = members.first().and_then(|member| member.downcast_ref::<IsoSurfaces>()) {
            *self = new.finder();
        }
    }
}
