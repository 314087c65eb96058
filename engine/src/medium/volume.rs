//! A volume that glows, or is lit, and takes light, as a transfer function of its values says.

use std::sync::Arc;

use glam::{DMat3, DVec3, Vec3};
use mobula_core::Column as Row;
use mobula_core::kernel::classify::{Knot, Transfer};
pub use mobula_core::volume::Between;
use mobula_core::volume::{Field as _, LightRows, Lighting, March, Marched, Passages, WIDTH};

use crate::geometry::{Field, Series};
use crate::packet::{Columns3, part, set_vec3, vec3};
use crate::scratch::{ForWidth, lend};
use crate::stack::{Context, Illumination, Medium, Receivers, Segments};
use crate::volume::{TransferFunction, TransferPoint};

/// A volume as a medium. Steps along rays are equal within a brick of the grid, and the opacity is the same for any length of them.
#[derive(Clone, Debug)]
pub struct Volume {
    /// What people call it.
    pub name: String,
    /// What is between samples.
    pub between: Between,
    /// The longest step, in units of cells; at least [`LEAST_STEP`].
    pub step: f32,
    /// Is it lit by the lights of the scene, as surfaces across the gradient are? Else it glows in its colours.
    pub lit: bool,
    /// Planes (a, b, c, d): where a x + b y + c z > d, nothing is seen.
    pub cuts: Vec<[f64; 4]>,
    series: Series,
    function: Arc<TransferFunction>,
    window: [f64; 2],
    /// The function for values as they are stored.
    transfer: Arc<Transfer>,
}

/// Shorter steps, in units of cells, gain nothing.
pub const LEAST_STEP: f32 = 1.0 / 32.0;
/// Nothing is seen to change with shorter ones.
pub const DEFAULT_STEP: f32 = 0.5;
/// Gradients count as surfaces where the value changes by this part of all that is visible in one cell.
const FLAT: f64 = 1.0 / 64.0;

/// What a march needs: made once a thread.
#[derive(Default)]
struct Room {
    passages: Passages,
    marched: Marched,
    lighting: Lighting,
    t0: Row<f32, WIDTH>,
    t1: Row<f32, WIDTH>,
}

impl ForWidth for Box<Room> {
    fn for_width(_width: usize) -> Self {
        Self::default()
    }
}

impl Volume {
    /// A volume that glows as a transfer function says.
    pub fn new(name: impl Into<String>, series: Series, function: Arc<TransferFunction>) -> Self {
        let window = function.span(series.range());
        let transfer = Arc::new(transfer(&series, &function, window));
        let name = name.into();
        let (between, step) = (Between::Linear, DEFAULT_STEP);
        Self { name, between, step, lit: false, cuts: Vec::new(), series, function, window, transfer }
    }

    /// With another transfer function, as it is.
    pub fn with_function(&self, function: Arc<TransferFunction>) -> Self {
        let window = function.span(self.series.range());
        Self { function, ..self.clone() }.with_window(window)
    }

    /// With the transfer function moved and stretched along the values, so that its first and its last point are half the width from the
    /// level: `[level, width]`. A width that is not above 0, or a number that is not finite, changes nothing.
    pub fn with_window(&self, window: [f64; 2]) -> Self {
        if !(window[0].is_finite() && window[1].is_finite() && window[1] > 0.0) {
            return self.clone();
        }
        let transfer = Arc::new(transfer(&self.series, &self.function, window));
        Self { window, transfer, ..self.clone() }
    }

    /// At another step of time.
    pub fn at(&self, step: usize) -> Self {
        Self { series: self.series.at(step), ..self.clone() }.with_window(self.window)
    }

    /// The middle of the values that the transfer function is for, and how wide they are.
    pub fn window(&self) -> [f64; 2] {
        self.window
    }

    /// The transfer function.
    pub fn function(&self) -> &Arc<TransferFunction> {
        &self.function
    }

    /// The values.
    pub fn series(&self) -> &Series {
        &self.series
    }

    fn field(&self) -> &Field {
        self.series.field()
    }

    fn to_cells(&self) -> [[f64; 4]; 3] {
        let to_cells = self.field().to_cells();
        [0, 1, 2].map(|axis| {
            let row = to_cells.matrix3.row(axis);
            [row.x, row.y, row.z, to_cells.translation[axis]]
        })
    }

    /// Marches segments; what comes of it is left in the room. Says whether any of them meets the volume.
    fn run(&self, context: &Context<'_>, segments: &Segments<'_>, lit: bool, room: &mut Room) -> bool {
        let Room { passages, marched, lighting, t0, t1 } = room;
        let count = segments.t0.len();
        self.cut(segments, &mut t0[..count], &mut t1[..count]);
        let cut = Segments { t0: &t0[..count], t1: &t1[..count], ..*segments };
        if !passages.enter(&cut, &self.to_cells(), self.field().layout()) {
            return false;
        }
        if lit {
            self.light(context, segments, passages, lighting);
        }
        let march = March {
            field: self.field(),
            transfer: &self.transfer,
            between: self.between,
            step: self.step.max(LEAST_STEP),
            lighting: lit.then_some(lighting),
        };
        context.token.run(march.task(passages, marched));
        true
    }

    /// Cuts segments by the planes.
    fn cut(&self, segments: &Segments<'_>, t0: &mut [f32], t1: &mut [f32]) {
        t0.copy_from_slice(segments.t0);
        t1.copy_from_slice(segments.t1);
        for &[a, b, c, d] in &self.cuts {
            let normal = DVec3::new(a, b, c);
            for i in 0..t0.len() {
                let above = normal.dot(vec3(&segments.origins, i).as_dvec3()) - d;
                let slope = normal.dot(vec3(&segments.directions, i).as_dvec3());
                let t = (-above / slope) as f32;
                if slope > 0.0 {
                    t1[i] = t1[i].min(t);
                } else if slope < 0.0 {
                    t0[i] = t0[i].max(t);
                } else if above > 0.0 {
                    t1[i] = f32::NEG_INFINITY;
                }
            }
        }
    }

    /// What the lights of the scene are for each ray, where it enters the grid and where it leaves. Of lights with extent it is what is in their
    /// middle: volumes throw no shadows on themselves that could be soft.
    fn light(&self, context: &Context<'_>, segments: &Segments<'_>, passages: &Passages, out: &mut Lighting) {
        let scene = context.scene;
        let matrix = self.field().to_cells().matrix3;
        let into_cells = |v: Vec3| (matrix * v.as_dvec3()).as_vec3();
        let up = scene.up.vector();
        out.up = into_cells(up).to_array();
        out.ambient = ambient(context, up);
        let rows = matrix.transpose();
        let product = |a: usize, b: usize| rows.col(a).dot(rows.col(b)) as f32;
        out.metric = [product(0, 0), product(1, 1), product(2, 2), product(0, 1), product(1, 2), product(2, 0)];
        out.flat = self.flat(&matrix);
        out.lights.resize_with(scene.lights.len(), LightRows::default);
        let count = passages.len();
        let points: &mut Columns3 = &mut lend(context.width);
        let arriving: &mut Illumination = &mut lend(context.width);
        for (light, rows) in scene.lights.iter().zip(&mut out.lights) {
            let mut towards = [[Vec3::ZERO; 2]; WIDTH];
            for end in 0..2 {
                let t = if end == 0 { &passages.t0 } else { &passages.t1 };
                for i in 0..count {
                    set_vec3(points, i, vec3(&segments.origins, i) + vec3(&segments.directions, i) * t[i]);
                }
                light.illuminate(context, Receivers::new(part(points, 0..count)), arriving);
                for i in 0..count {
                    let distance = arriving.distance[i];
                    let length = if distance.is_finite() { distance } else { 1.0 };
                    towards[i][end] = vec3(&arriving.direction, i) * length;
                    set_vec3(&mut rows.towards[end], i, into_cells(towards[i][end]));
                    set_vec3(&mut rows.radiance[end], i, vec3(&arriving.radiance, i));
                }
            }
            for (i, [from, to]) in towards[..count].iter().enumerate() {
                set_vec3(&mut rows.squares, i, Vec3::new(from.dot(*from), from.dot(*to), to.dot(*to)));
            }
        }
    }

    /// The change of the stored value with a length in space from which a gradient counts as a surface.
    fn flat(&self, to_cells: &DMat3) -> f32 {
        let visible = self.transfer.visible();
        let [low, high] = self.field().range().map(|value| self.field().grid().voxel_of(value));
        let (low, high) = (low.min(high), low.max(high));
        let first = visible.first().map_or(low, |range| f64::from(range[0]).max(low));
        let last = visible.last().map_or(high, |range| f64::from(range[1]).min(high));
        let per_length = (to_cells.determinant().abs()).cbrt();
        ((last - first).max((high - low) * FLAT) * FLAT * per_length).max(f64::from(f32::MIN_POSITIVE)) as f32
    }
}

/// A function in a window, for values as they are stored.
fn transfer(series: &Series, function: &TransferFunction, window: [f64; 2]) -> Transfer {
    let grid = series.field().grid();
    let (spacing, dims) = (grid.place().spacing(), grid.dims());
    let side = (0..3).map(|axis| spacing[axis] * dims[axis].saturating_sub(1) as f64).fold(0.0, f64::max);
    let points = function.resolve(series.range(), side.max(f64::MIN_POSITIVE));
    let [middle, width] = function.span(series.range());
    let knot = |point: &TransferPoint| {
        let value = window[0] + (point.value - middle) / width * window[1];
        let extinction = point.extinction.min(f64::from(f32::MAX)) as f32;
        Knot { value: grid.voxel_of(value) as f32, color: point.color, extinction }
    };
    let mut knots: Vec<Knot> = points.iter().map(knot).collect();
    if grid.scale()[0] < 0.0 {
        knots.reverse();
    }
    Transfer::new(&knots)
}

/// What arrives from everywhere at a level surface, and how much more at one that faces up.
fn ambient(context: &Context<'_>, up: Vec3) -> [[f32; 3]; 2] {
    let ends = [up, -up].map(|v| v.to_array());
    let normals: [[f32; 2]; 3] = [0, 1, 2].map(|axis| [ends[0][axis], ends[1][axis]]);
    let mut out = [[0.0; 2]; 3];
    let [r, g, b] = &mut out;
    context.scene.ambient.illuminate(context.token, up, [&normals[0], &normals[1], &normals[2]], [r, g, b]);
    [out.map(|[above, below]| (above + below) * 0.5), out.map(|[above, below]| (above - below) * 0.5)]
}

impl Medium for Volume {
    fn march(
        &self,
        context: &Context<'_>,
        segments: &Segments<'_>,
        radiance: [&mut [f32]; 3],
        transmittance: &mut [f32],
    ) {
        let room: &mut Box<Room> = &mut lend(WIDTH);
        let count = transmittance.len();
        if self.run(context, segments, self.lit, room) {
            for (out, from) in radiance.into_iter().zip(&room.marched.radiance) {
                out.copy_from_slice(&from[..count]);
            }
            transmittance.copy_from_slice(&room.marched.transmittance[..count]);
        } else {
            radiance.into_iter().for_each(|column| column.fill(0.0));
            transmittance.fill(1.0);
        }
    }

    /// Where the scene has no shadows, volumes throw none.
    fn transmittance(&self, context: &Context<'_>, segments: &Segments<'_>, out: &mut [f32]) {
        let room: &mut Box<Room> = &mut lend(WIDTH);
        if context.scene.shadows && self.run(context, segments, false, room) {
            let count = out.len();
            out.copy_from_slice(&room.marched.transmittance[..count]);
        } else {
            out.fill(1.0);
        }
    }

    fn clip(&self, segments: &Segments<'_>, t0: &mut [f32], t1: &mut [f32]) {
        let room: &mut Box<Room> = &mut lend(WIDTH);
        self.cut(segments, t0, t1);
        room.passages.enter(&Segments { t0, t1, ..*segments }, &self.to_cells(), self.field().layout());
        let count = t0.len();
        t0.copy_from_slice(&room.passages.t0[..count]);
        t1.copy_from_slice(&room.passages.t1[..count]);
    }

    /// Two cells.
    fn grain(&self) -> f32 {
        2.0 * self.field().grid().place().spacing().into_iter().fold(f64::INFINITY, f64::min) as f32
    }

    fn extremes(&self, visit: &mut dyn FnMut(Vec3)) {
        self.field().corners().into_iter().for_each(visit);
    }
}
