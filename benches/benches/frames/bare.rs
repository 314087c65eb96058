//! The bare loop around Embree: what somebody would write who wants one kind of frame and nothing else.

use glam::Vec3;
use mobula::camera::View;
use mobula::color::to_pixels;
use mobula::sampler::morton;
use mobula::tone::Tone;
use mobula_benches::embree::{Interface, Scene};
use mobula_benches::rays::{Found, NOTHING, RaySet};
use mobula_benches::secondary::{cosine_weighted, unit};
use mobula_core::rays::set_vec3;
use mobula_core::simd::{AnyToken, Task, Token};
use mobula_core::{Column, Columns3};

use super::surfaces::Surfaces;
use super::{AMBIENT, OCCLUSION_RAYS, Shown};

const TILE: usize = 16;
/// Rays of a tile.
const RAYS: usize = TILE * TILE;

/// The bare loop, one thread.
pub(crate) struct Bare<'a> {
    token: AnyToken,
    scene: &'a Scene<'a>,
    surfaces: &'a Surfaces<'a>,
    view: View,
    /// Pixels a side.
    side: usize,
    light: Vec3,
    /// How far rays go that ask whether the sky is open.
    reach: f32,
    /// Which of Embree's functions is called.
    pub(crate) interface: Interface,
    rays: RaySet,
    found: Found,
    shadow: RaySet,
    upward: RaySet,
    blocked: Found,
    /// Directions around z, distributed by the cosine: for each of a pixel's rays those of a tile's pixels.
    directions: Vec<Vec3>,
    pub(crate) picture: Vec<u32>,
}

/// Rays that start at one point and go nowhere yet.
fn rays_from(origin: Vec3) -> RaySet {
    let mut rays = RaySet::default();
    (0..RAYS).for_each(|_| rays.push(origin.into(), [0.0; 3], f32::INFINITY));
    rays
}

/// Every pixel of a tile has its own directions, one in each cell of a grid on the unit square.
fn directions() -> Vec<Vec3> {
    let side = OCCLUSION_RAYS.isqrt() as usize;
    let cell = |ray: usize, i: usize| {
        let at = 2 * (ray * RAYS + i) as u32;
        [(ray % side) as f32 + unit(at), (ray / side) as f32 + unit(at + 1)].map(|x| x / side as f32)
    };
    let of = |ray| (0..RAYS).map(move |i| Vec3::from(cosine_weighted([0.0, 0.0, 1.0], cell(ray, i))));
    (0..OCCLUSION_RAYS as usize).flat_map(of).collect()
}

impl<'a> Bare<'a> {
    pub(crate) fn new(
        token: AnyToken,
        scene: &'a Scene<'a>,
        surfaces: &'a Surfaces<'a>,
        view: View,
        (side, light, reach): (usize, Vec3, f32),
        interface: Interface,
    ) -> Self {
        let mut found = Found::new(RAYS);
        found.uv = surfaces.are_textured().then(|| [0, 1].map(|_| vec![0.0; RAYS]));
        Self {
            token,
            scene,
            surfaces,
            view,
            side,
            light,
            reach,
            interface,
            rays: rays_from(view.eye),
            found,
            shadow: rays_from(light),
            upward: rays_from(Vec3::ZERO),
            blocked: Found::new(RAYS),
            directions: directions(),
            picture: vec![0; side * side],
        }
    }

    /// Renders a frame, compiled for the level as a whole.
    pub(crate) fn frame(&mut self, shown: Shown) {
        self.token.run(Frame { bare: self, shown });
    }

    #[inline(always)]
    fn aim(&mut self, slope: f32, [right, up, forward]: [Vec3; 3], pixel: impl Fn(usize) -> [usize; 2]) {
        let [dx, dy, dz] = &mut self.rays.direction;
        let per_pixel = 2.0 / self.side as f32;
        for i in 0..RAYS {
            let [x, y] = pixel(i);
            let sx = ((x as f32 + 0.5) * per_pixel - 1.0) * slope;
            let sy = (1.0 - (y as f32 + 0.5) * per_pixel) * slope;
            let d = forward + right * sx + up * sy;
            let d = d * (1.0 / d.dot(d).sqrt());
            (dx[i], dy[i], dz[i]) = (d.x, d.y, d.z);
        }
    }

    /// Direction, position and normal at the hit of a ray.
    #[inline(always)]
    fn hit(&self, i: usize) -> [Vec3; 3] {
        let (origin, direction) = self.rays.ray(i);
        let (origin, direction) = (Vec3::from(origin), Vec3::from(direction));
        let normal = self.surfaces.normal(self.found.primitive[i] as usize, direction);
        [direction, origin + direction * self.found.t[i], normal]
    }

    /// A place as far off the surface as Mobula's shading goes.
    #[inline(always)]
    fn off(&self, i: usize, position: Vec3, normal: Vec3, distance: f32) -> Vec3 {
        let size = position.abs().max_element().max(self.found.t[i]).max(distance);
        position + normal * (size * (1.0 / 262_144.0))
    }

    #[inline(always)]
    fn base_color(&self, i: usize, slope: f32) -> Vec3 {
        let uv = self.found.uv.as_ref().map_or([0.0; 2], |[u, v]| [u[i], v[i]]);
        let width = 2.0 * slope / self.side as f32 * self.found.t[i];
        self.surfaces.color(self.found.primitive[i] as usize, uv, width, self.rays.ray(i).1.into())
    }

    /// How much of the point light is scattered at each hit; nothing where something is in the way.
    #[inline(always)]
    fn lit(&mut self) -> [f32; RAYS] {
        let mut facing = [0u8; RAYS];
        let mut lit = [0.0f32; RAYS];
        let mut count = 0;
        self.shadow.t_max.clear();
        for i in 0..RAYS {
            if self.found.primitive[i] == NOTHING {
                continue;
            }
            let [_, position, normal] = self.hit(i);
            let to_light = self.light - position;
            let distance = to_light.dot(to_light).sqrt();
            let cosine = to_light.dot(normal) * (1.0 / distance);
            if cosine > 0.0 {
                let v = self.off(i, position, normal, distance) - self.light;
                let distance = v.length();
                for axis in 0..3 {
                    self.shadow.direction[axis][count] = v[axis] * (1.0 / distance);
                }
                self.shadow.t_max.push(distance);
                (facing[count], lit[i]) = (i as u8, cosine);
                count += 1;
            }
        }
        self.scene.occluded(self.interface, &self.shadow, &mut self.blocked);
        for (k, &i) in facing[..count].iter().enumerate() {
            if self.blocked.hit(k, true) {
                lit[usize::from(i)] = 0.0;
            }
        }
        lit
    }

    /// How open the sky is above each hit; 1 where nothing was hit. The first rays of all go together, then the second ones.
    #[inline(always)]
    fn open(&mut self) -> [f32; RAYS] {
        let mut open = [1.0f32; RAYS];
        let mut from = [0u8; RAYS];
        let mut frames = [[Vec3::ZERO; 3]; RAYS];
        let mut count = 0;
        for i in 0..RAYS {
            if self.found.primitive[i] == NOTHING {
                continue;
            }
            let [_, position, normal] = self.hit(i);
            let start = self.off(i, position, normal, 0.0);
            (0..3).for_each(|axis| self.upward.origin[axis][count] = start[axis]);
            let (x, y) = normal.any_orthonormal_pair();
            (frames[count], from[count]) = ([x, y, normal], i as u8);
            count += 1;
        }
        self.upward.t_max.clear();
        self.upward.t_max.resize(count, self.reach);
        for directions in self.directions.chunks(RAYS) {
            let [dx, dy, dz] = &mut self.upward.direction;
            for (k, ([x, y, z], &i)) in frames[..count].iter().zip(&from).enumerate() {
                let d = directions[usize::from(i)];
                let d = *x * d.x + *y * d.y + *z * d.z;
                (dx[k], dy[k], dz[k]) = (d.x, d.y, d.z);
            }
            self.scene.occluded(self.interface, &self.upward, &mut self.blocked);
            for (k, &i) in from[..count].iter().enumerate() {
                if self.blocked.hit(k, true) {
                    open[usize::from(i)] -= 1.0 / OCCLUSION_RAYS as f32;
                }
            }
        }
        open
    }

    /// Writes the pixels of a tile's colours, by the same kernel as Mobula.
    fn write(&mut self, shown: &Columns3<RAYS>, pixel: impl Fn(usize) -> [usize; 2]) {
        let mut pixels = [0; RAYS];
        to_pixels(self.token, Tone::default(), shown.each_ref().map(|column| &column[..]), RAYS, &mut pixels);
        for (i, &color) in pixels.iter().enumerate() {
            let [x, y] = pixel(i);
            self.picture[y * self.side + x] = color;
        }
    }
}

struct Frame<'a, 'b> {
    bare: &'a mut Bare<'b>,
    shown: Shown,
}

impl Task for Frame<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, _: T) {
        let Self { bare, shown } = self;
        let places: [[u32; 2]; RAYS] = std::array::from_fn(|i| morton::decode(i as u32));
        let (slope, basis) = (bare.view.slope(), bare.view.basis());
        let across = bare.side / TILE;
        for tile in 0..across.pow(2) {
            let corner = [tile % across * TILE, tile / across * TILE];
            let pixel = |i: usize| [corner[0] + places[i][0] as usize, corner[1] + places[i][1] as usize];
            bare.aim(slope, basis, pixel);
            bare.scene.intersect(bare.interface, &bare.rays, &mut bare.found);
            let mut colors = [Column::splat(0.0); 3];
            let light = match shown {
                Shown::Primary => [1.0; RAYS],
                Shown::Shadows => bare.lit().map(|lit| AMBIENT + lit),
                Shown::Occlusion => bare.open(),
            };
            for i in 0..RAYS {
                let color = match shown {
                    Shown::Occlusion => Vec3::ONE,
                    _ if bare.found.primitive[i] == NOTHING => Vec3::ZERO,
                    _ => bare.base_color(i, slope),
                };
                set_vec3(&mut colors, i, color * light[i]);
            }
            bare.write(&colors, pixel);
        }
    }
}
