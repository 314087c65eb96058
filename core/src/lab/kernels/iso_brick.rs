//! Rays through a brick of a volume: see [`IsoTree`]. A test is a ray.

use alloc::string::String;
use alloc::vec::Vec;

use mobula_simd::{Dispatch, Scalar, Token};

use super::iso_cell::{Cell, IsoCell};
use crate::bvh::Serial;
use crate::lab::find::{ANY, CLOSEST, RayTest, verify};
use crate::lab::leaves::{PACKET, STREAM, any_agrees, test};
use crate::lab::{Dice, Draft, DraftRay, Kernel, Outcome, Work};
use crate::oracle::{ExactRay, Truth};
use crate::sink::AnyHit;
use crate::volume::{CELLS, GridField, IsoTree, Layout, Ranges};

/// A volume of one brick, with the surface where it is zero.
#[derive(Clone, Debug)]
pub struct Volume {
    voxels: Vec<f32>,
    layout: Layout,
    ranges: Ranges<f32>,
}

impl Volume {
    fn new(samples: [usize; 3], value: impl FnMut([usize; 3]) -> f32) -> Self {
        let [nx, ny, nz] = samples;
        let voxels: Vec<f32> = (0..nx * ny * nz).map(|i| [i % nx, i / nx % ny, i / (nx * ny)]).map(value).collect();
        let Ok(layout) = Layout::new(samples) else { unreachable!("a brick") };
        let ranges = Ranges::new(&layout, &voxels, &Serial);
        Self { voxels, layout, ranges }
    }

    fn field(&self) -> GridField<'_, f32> {
        GridField { voxels: &self.voxels, layout: &self.layout, ranges: &self.ranges }
    }

    /// A cell; `None` if one of its corners is no number.
    fn cell(&self, at: [usize; 3]) -> Option<Cell> {
        let [nx, ny, _] = self.layout.samples();
        let value = |corner: usize| {
            let [x, y, z] = [0, 1, 2].map(|axis| at[axis] + (corner >> axis & 1));
            self.voxels[(z * ny + y) * nx + x]
        };
        let values = [0, 1, 2, 3, 4, 5, 6, 7].map(value);
        values.iter().all(|value| value.is_finite()).then(|| Cell { low: at.map(|x| x as f32), size: 1.0, values })
    }

    /// What is true of the first cell that a ray hits for sure, unless one before may be hit too.
    fn truth(&self, ray: &ExactRay) -> Option<(Truth, f64)> {
        let [nx, ny, nz] = [0, 1, 2].map(|axis| self.layout.cells(axis));
        let cells = (0..nx * ny * nz).filter_map(|i| self.cell([i % nx, i / nx % ny, i / (nx * ny)]));
        let mut first = Some((Truth { t: None, margin: f64::INFINITY }, 0.0));
        for truth in cells.map(|cell| IsoCell::truth(&cell, 0, ray)) {
            let (truth, reach) = truth?;
            let nearest = first.and_then(|(first, _)| first.t).unwrap_or(f64::INFINITY);
            if truth.t.is_some_and(|t| t < nearest) {
                first = Some((truth, reach));
            }
        }
        first
    }
}

/// The test of a brick, looking for the closest hit or any.
#[derive(Debug)]
pub struct IsoBrick<const PATH: u8, const HIT: bool = CLOSEST>;

impl<const PATH: u8, const HIT: bool> Kernel for IsoBrick<PATH, HIT> {
    type Primitive = Volume;
    type General = IsoBrick<STREAM>;
    const PRIMITIVES: usize = 1;

    fn tests(rays: usize, _volumes: usize) -> usize {
        rays
    }

    fn draw(dice: &mut Dice<'_>) -> Volume {
        let whole = dice.one_in(2);
        let samples = CELLS.map(|cells| if whole { cells + 1 } else { 2 + dice.below(cells) });
        Volume::new(samples, |_| dice.value())
    }

    /// A case has one volume.
    fn number(volumes: &mut [Volume]) {
        if let [first, others @ ..] = volumes {
            others.iter_mut().for_each(|other| *other = first.clone());
        }
    }

    /// Some three rays side by side in a cell, in groups of 4 x 4, and a surface with hills across the brick.
    fn timed(draft: &mut Draft<Volume>) {
        let hill = |x: usize, by: f32| (x as f32 * by - 0.5) * (1.5 - x as f32 * by);
        draft.primitives =
            [Volume::new(CELLS.map(|cells| cells + 1), |[x, y, z]| y as f32 - 2.0 + hill(x, 0.25) + hill(z, 0.5))]
                .into();
        let origin = [-9.0, 16.0, 20.0];
        for (i, ray) in draft.rays.iter_mut().enumerate() {
            let (x, y) = (i / 16 % 4 * 4 + i % 4, i / 64 * 4 + i / 4 % 4);
            let target = [3.0 + 0.4 * x as f32, 1.5 + 0.2 * y as f32, 2.0 - 0.2 * y as f32];
            let direction = [0, 1, 2].map(|axis| target[axis] - origin[axis]);
            *ray = DraftRay { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        }
    }

    fn aim(dice: &mut Dice<'_>, volume: &Volume) -> [f32; 3] {
        let corner = dice.one_in(2);
        [0, 1, 2].map(|axis| {
            let cells = volume.layout.cells(axis);
            if corner { dice.below(cells + 1) as f32 } else { dice.unit() * cells as f32 }
        })
    }

    fn derive<const N: usize>(token: impl Dispatch, work: &mut Work<Volume, N>) {
        // The same bits at every level.
        work.rays.shears(Scalar::new());
        work.rays.inverse_directions(Scalar::new());
        let Some(volume) = work.primitives.first() else { return };
        work.frame = *volume.layout.frame();
        work.frusta = if PATH == PACKET { work.frusta::<false>(token) } else { None };
    }

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<Volume, N>) {
        let Work { rays, primitives, hits, frusta, .. } = work;
        let Some(volume) = primitives.first() else { return };
        let field = volume.field();
        let tree = IsoTree::new(&field, &[0.0]);
        if HIT == ANY {
            test::<T, N, _, _, PATH>(token, &tree, 0..1, rays, &mut AnyHit::opaque(), frusta);
        } else {
            test::<T, N, _, _, PATH>(token, &tree, 0..1, rays, hits, frusta);
        }
    }

    fn verify(draft: &Draft<Volume>, outcome: &Outcome) -> Result<(), String> {
        let Some(volume) = draft.primitives.first() else { return Ok(()) };
        verify(draft, outcome, HIT == ANY, IsoCell::GUARD, |ray| [volume.truth(ray)].into())
    }

    fn agrees(draft: &Draft<Volume>, outcome: &Outcome, general: &Outcome) -> Result<(), String> {
        if HIT == ANY { any_agrees(draft, outcome, general) } else { outcome.answers_equal(general) }
    }
}
