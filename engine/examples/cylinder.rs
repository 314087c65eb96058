//! A kind of geometry that Mobula does not know: upright cylinders, with a kernel, a tree, and a picture, `cylinder.png`.

use bytemuck::Zeroable;
use mobula::accel::Build;
use mobula::display::png::write_png;
use mobula::geometry::{Census, Geometry, InTree, Item, Structure, Tree};
use mobula::packet::{Hits, PacketWidth, Surface};
use mobula::prelude::*;
use mobula_core::kernel::few::FewRays;
use mobula_core::leaf::{BLOCK, Block, Bounds};
use mobula_core::simd::{F32Lanes, Token};
use mobula_core::vector::{load3, splat3, sub};
use mobula_core::{NO_HIT, Rays};

/// `[x, y, z, height, radius]` of each, around its middle; half its height. Open at both ends.
#[derive(Clone, Debug)]
struct Cylinders(Vec<[f32; 5]>);

/// Four cylinders: a row of each number.
#[derive(Clone, Copy, Debug, Zeroable)]
struct FourCylinders([[f32; BLOCK]; 5], [u32; BLOCK]);

/// Ray against cylinder, relative to the ray's origin: the nearer of two sides whose height is right. A NaN hits nothing.
#[inline(always)]
fn cylinder<T: Token>(
    [x, y, z]: [T::F32; 3],
    [height, radius]: [T::F32; 2],
    [dx, dy, dz]: [T::F32; 3],
    [t_min, t_max]: [T::F32; 2],
) -> (T::Mask, T::F32) {
    let square = dx * dx + dz * dz;
    let closest = (x * dx + z * dz) / square;
    // Where the ray is closest to the axis: more precise than b * b - a * c far away.
    let (off_x, off_z) = (dx.mul_sub(closest, x), dz.mul_sub(closest, z));
    let half = ((radius * radius - (off_x * off_x + off_z * off_z)) / square).sqrt();
    let side = |t: T::F32| (dy.mul_sub(t, y).abs().le(height) & t.gt(t_min) & t.le(t_max), t);
    let ((near, t_near), (far, t_far)) = (side(closest - half), side(closest + half));
    (near | far, t_near.select(near, t_far))
}

impl Block for FourCylinders {
    type Primitive = [f32; 5];
    type Prepared = [[f32; BLOCK]; 5];
    const EMPTY: Self = Self([[f32::NAN; BLOCK]; 5], [NO_HIT; BLOCK]);
    const NOWHERE: [f32; 5] = [f32::NAN; 5];
    fn bounds(&[x, y, z, height, r]: &[f32; 5]) -> Option<Bounds> {
        let bounds = Bounds::of_points(&[[x - r, y - height, z - r], [x + r, y + height, z + r]]);
        (bounds.low.iter().chain(&bounds.high).all(|x| x.is_finite()) && height > 0.0 && r > 0.0)
            .then(|| bounds.outward())
    }
    fn set(&mut self, place: usize, id: u32, cylinder: &[f32; 5]) {
        self.0.iter_mut().zip(cylinder).for_each(|(row, &value)| row[place] = value);
        self.1[place] = id;
    }
    fn whole(&self) -> Bounds {
        let mut whole = Bounds::EMPTY;
        (0..BLOCK).filter_map(|i| Self::bounds(&self.0.map(|row| row[i]))).for_each(|bounds| whole.merge(&bounds));
        whole
    }
    fn ids(&self, _number: usize) -> [u32; BLOCK] {
        self.1
    }
    #[inline(always)]
    fn prepare<const N: usize, const COMMON_ORIGIN: bool>(&self, rays: &Rays<N>) -> [[f32; BLOCK]; 5] {
        let (mut rows, first) = (self.0, rays.range().start);
        for (row, origin) in rows.iter_mut().zip(rays.origins()).filter(|_| COMMON_ORIGIN) {
            row.iter_mut().for_each(|x| *x -= origin[first]);
        }
        rows
    }
    #[inline(always)]
    fn test<T: Token, const N: usize, const COMMON_ORIGIN: bool, const OWN_AXES: bool>(
        token: T,
        rows: &[[f32; BLOCK]; 5],
        i: usize,
        _axis: usize,
        rays: &Rays<N>,
        at: usize,
        among: T::Mask,
    ) -> (T::Mask, T::F32) {
        let middle = splat3(token, [rows[0][i], rows[1][i], rows[2][i]]);
        let middle = if COMMON_ORIGIN { middle } else { sub(middle, load3(token, rays.origins(), at)) };
        let interval = [token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at)];
        let size = [3, 4].map(|row| token.splat(rows[row][i]));
        let (hit, t) = cylinder::<T>(middle, size, load3(token, rays.directions(), at), interval);
        (hit & among, t)
    }
    #[inline(always)]
    fn test_few<T: Token>(&self, token: T, rays: &FewRays<T>, i: usize) -> (T::Mask, T::F32) {
        let [x, y, z, height, radius] = self.0.each_ref().map(|row| token.repeat(row, i));
        cylinder::<T>(sub([x, y, z], rays.origin), [height, radius], rays.direction, [rays.t_min, rays.t_max])
    }
}

impl InTree for Cylinders {
    type Leaf = FourCylinders;
    fn primitive(&self, i: usize) -> Option<[f32; 5]> {
        self.0.get(i).copied().filter(|cylinder| FourCylinders::bounds(cylinder).is_some())
    }
}

impl Geometry for Cylinders {
    fn primitives(&self) -> usize {
        self.0.len()
    }
    fn census(&self) -> Census {
        let mut census = Census::default();
        census.add(Item::primitives("cylinders", "cylinder", "cylinders"), self.0.len() as u64);
        let corners = self.0.iter().filter_map(FourCylinders::bounds).flat_map(|bounds| [bounds.low, bounds.high]);
        corners.for_each(|corner| census.include(Vec3::from_slice(&corner), 0.0));
        census
    }
    fn shift_materials(self: Arc<Self>, _: u32) -> Arc<dyn Geometry> {
        self
    }
    fn structure(&self, members: &[Arc<dyn Geometry>], build: &Build) -> Box<dyn Structure> {
        Box::new(Tree::<Self>::build(members, build))
    }
}

impl Surface for Cylinders {
    fn geometric_normals(&self, hits: &Hits<'_>, mut out: [&mut [f32]; 3], error_scales: &mut [f32]) {
        for (i, &k) in hits.primitives.iter().enumerate() {
            let [x, _, z, top, radius] = self.0[k as usize];
            let from_axis = hits.position(i) - Vec3::new(x, 0.0, z);
            set_vec3(&mut out, i, Vec3::new(from_axis.x, 0.0, from_axis.z) / radius);
            error_scales[i] = top.max(radius);
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut scene, size) = (mobula::builtin::scene(), Size::new(640, 480)?);
    scene.add(Cylinders(vec![[-3.6, 1.0, -3.0, 1.3, 0.35], [0.0, 1.2, -3.0, 1.5, 0.3]]));
    let mut pictures = Vec::new();
    for &width in PacketWidth::ALL {
        let components = Components { width, ..Components::build(&scene, size)? };
        let mut pipeline = components.pipeline(size, Config::default())?;
        pipeline.run(1)?;
        let picture = pipeline.picture(0).expect("a picture").1;
        write_png("cylinder.png".as_ref(), picture)?;
        pictures.push(picture.to_rgba8());
    }
    assert!(pictures.windows(2).all(|two| two[0] == two[1]), "one picture at every packet width");
    println!("wrote cylinder.png: the same picture with packets of {} rays", PacketWidth::list());
    Ok(())
}
