//! Frusta around the groups of a packet that travel together, so that boxes can be dismissed for all their rays at once.
//!
//! After Reshetov, Soupikov and Hurley, "Multi-Level Ray Tracing Algorithm", SIGGRAPH 2005. All directions have the same
//! dominant axis z and go the same way along it. From the plane `z = start`, at or before all origins, a ray runs along
//! `x = base + slope * (z - start)`, with the slopes that the triangle test shears by. So a group is two intervals of bases
//! and two of slopes: four planes, and nothing has to be divided. With a common origin the intervals of bases are points and
//! the four planes are a frustum; parallel rays have points for slopes, and their planes are a prism. A box meets all groups in
//! one vector, a group a lane.
//!
//! Boxes are widened by the margin of [`super::margin`], so no group that has a ray that hits something in a box is dismissed.
//!
//! - NaN: rays of NaN are in no group that has a class, or passed over.
//! - Degenerate boxes: an empty one (low above high) may be met or not, and nothing is in it.

use mobula_simd::{F32Lanes, MaskLanes, Token};

use super::boxes::{Planes, row};
use super::group_bounds::GroupBounds;
use super::group_shears::{GroupShears, Parallel};
use super::groups::{GROUPS, Row, greatest, group_lanes, group_size, least};
use super::margin::{Frame, PAD};
use crate::rays::AXES;
use crate::vector::load3;
use crate::{Column, Rays};

/// The groups of a packet that travel together.
#[derive(Clone, Copy, Debug)]
pub struct Frusta {
    /// The farthest that any ray of each group may still hit; `-inf` for groups that do not travel.
    reach: Row,
    /// The farthest of them.
    farthest: f32,
    /// Where the first ray of each group starts, from the first of all, in the measure of [`NodeDistances::far`].
    start: Row,
    /// x from below, y from below, x from above, y from above.
    side: [Side; 4],
    /// The planes of a box that the rays meet first, from the last origin, and last, from the first origin.
    near: Plane,
    far: Plane,
    /// The reciprocal of the direction along z that is least in size, of all.
    least_inverse: f32,
    /// The same of each group.
    inverse: Row,
    /// The dominant axis.
    axis: usize,
    /// By how much boxes are widened.
    margin: f32,
    /// Groups whose rays go so far apart that bounds say little of them.
    diverged: u32,
    /// Boxes that are no wider have few rays through them: of rays from one origin, per depth.
    spacing: f32,
    /// For the edges of triangles, if the rays have an origin or a direction in common.
    shears: Option<GroupShears>,
}

/// A side of all frusta: of a box, the corner that is farthest inside has the coordinate in row `x` of the planes, and z
/// in that of `depth`.
#[derive(Clone, Copy, Debug)]
struct Side {
    x: usize,
    depth: Plane,
    slope: Row,
    base: Row,
    /// Of all together.
    outer_slope: f32,
    outer_base: f32,
}

/// A row of planes, and what to subtract from it: where the rays start, moved outwards by the margin.
#[derive(Clone, Copy, Debug)]
struct Plane {
    row: usize,
    start: f32,
}

impl Plane {
    const NONE: Self = Self { row: 0, start: 0.0 };

    /// The depths of these planes of the boxes from `at`.
    #[inline(always)]
    fn depths<T: Token>(self, token: T, planes: &Planes, at: usize) -> T::F32 {
        token.load(row(planes, self.row), at) - token.splat(self.start)
    }
}

/// How frusta pass eight boxes.
#[derive(Clone, Copy, Debug)]
pub struct NodeDistances {
    /// Where they enter each box at the earliest.
    pub near: [f32; 8],
    /// Where they leave it at the latest, less the least distance to it.
    far: [f32; 8],
    /// The depth of its near plane, and of the corner that is farthest inside on each side.
    depth: [[f32; 8]; 5],
}

impl NodeDistances {
    /// Of nothing.
    pub const NONE: Self = Self { near: [0.0; 8], far: [0.0; 8], depth: [[0.0; 8]; 5] };
}

/// Groups of rays whose slopes differ by more than this (a tile of 4x4 pixels is a few thousandths wide) have diverged.
const WIDE: f32 = 1.0 / 160.0;
/// Boxes that are no wider than so many times the distance of neighbouring rays have few rays through them.
const SPACINGS: f32 = 2.0;
/// How many times as wide as the slopes the bases may be, as a share of what the scene's frame holds.
const SPREAD: f32 = 2.0;

impl Frusta {
    /// Lets the groups of this class travel together.
    #[inline(always)]
    pub fn new<T: Token, const N: usize, const COMMON_ORIGIN: bool>(
        token: T,
        bounds: &GroupBounds,
        rays: &Rays<N>,
        class: u8,
    ) -> Self {
        let groups = bounds.of_class(class);
        let axis = usize::from(class / 2) % 3;
        let backward = class & 1 != 0;
        let way = if backward { -1.0 } else { 1.0 };
        let [x, y, z] = AXES[axis];
        let margin = bounds.away * PAD;
        let mut slope = [[0.0; 2]; 2];
        for k in 0..2 {
            slope[k][0] = least::<T, N>(token, &bounds.slope[0][k], groups);
            slope[k][1] = greatest::<T, N>(token, &bounds.slope[1][k], groups);
        }
        let depths =
            [least::<T, N>(token, &bounds.origin[0][z], groups), greatest::<T, N>(token, &bounds.origin[1][z], groups)];
        let (first, last) = if backward { (depths[1], depths[0]) } else { (depths[0], depths[1]) };
        let (near, far) = if backward { (z + 3, z) } else { (z, z + 3) };
        let bases = if COMMON_ORIGIN {
            [[bounds.origin[0][x], bounds.origin[0][y]]; 2]
        } else {
            bases::<T, N>(token, rays, &bounds.frame, groups, [x, y, z], first)
        };
        let mut base = [[0.0; 2]; 2];
        for k in 0..2 {
            base[k][0] = least::<T, N>(token, &bases[0][k], groups);
            base[k][1] = greatest::<T, N>(token, &bases[1][k], groups);
        }
        let least_inverse = if backward {
            greatest::<T, N>(token, &bounds.inverse, groups)
        } else {
            least::<T, N>(token, &bounds.inverse, groups)
        };
        let zero = Column::splat(0.0);
        let side = Side { x: 0, depth: Plane::NONE, slope: zero, base: zero, outer_slope: 0.0, outer_base: 0.0 };
        let mut frusta = Self {
            reach: zero,
            farthest: 0.0,
            start: zero,
            side: [side; 4],
            near: Plane { row: near, start: last + margin * way },
            far: Plane { row: far, start: first - margin * way },
            least_inverse,
            inverse: bounds.inverse,
            axis,
            margin,
            diverged: 0,
            spacing: 0.0,
            shears: None,
        };
        let first_near = Plane { row: near, start: first + margin * way };
        for k in 0..2 {
            // As they are in front of `first`: turned where z falls.
            let [below, above] = if backward { [-slope[k][1], -slope[k][0]] } else { slope[k] };
            // A side bounds slopes times depths that are not negative: at the near plane of a box or at the far one, by sign.
            // Where groups differ in it, those of the lesser size count as zero.
            let by_far = [below < 0.0, above >= 0.0];
            let rows = [[x, y][k] + 3, [x, y][k]];
            for (side, outer) in [below, above].into_iter().enumerate() {
                let bound = &mut frusta.side[k + 2 * side];
                bound.x = rows[side];
                bound.depth = if by_far[side] { frusta.far } else { first_near };
                bound.outer_slope = outer * way;
                bound.outer_base = base[k][side] + if side == 0 { -margin } else { margin };
            }
            let widths = token.splat(bounds.frame.size * (WIDE / SPREAD));
            let zero = token.splat(0.0);
            let mut at = 0;
            while at < group_lanes(N) {
                let (low, high) = (token.load(&bounds.slope[0][k][..], at), token.load(&bounds.slope[1][k][..], at));
                let bases = [token.load(&bases[0][k][..], at), token.load(&bases[1][k][..], at)];
                let wide = (high - low).gt(token.splat(WIDE)) | (bases[1] - bases[0]).gt(widths);
                frusta.diverged |= wide.bits() << at;
                let (mut below, mut above) = if backward { (-high, -low) } else { (low, high) };
                if by_far[0] {
                    below = below.min(zero);
                }
                if by_far[1] {
                    above = above.max(zero);
                }
                (below * token.splat(way)).store(&mut frusta.side[k].slope[..], at);
                (above * token.splat(way)).store(&mut frusta.side[k + 2].slope[..], at);
                (bases[0] - token.splat(margin)).store(&mut frusta.side[k].base[..], at);
                (bases[1] + token.splat(margin)).store(&mut frusta.side[k + 2].base[..], at);
                at += T::LANES;
            }
        }
        let mut at = 0;
        while at < group_lanes(N) {
            let travels = token.mask(groups >> at);
            let reach = token.load(&bounds.t_max[..], at).select(travels, token.splat(f32::NEG_INFINITY));
            reach.store(&mut frusta.reach[..], at);
            if !COMMON_ORIGIN {
                let start = token.load(&bounds.origin[usize::from(backward)][z][..], at) - token.splat(first);
                (start * token.splat(least_inverse)).store(&mut frusta.start[..], at);
            }
            at += T::LANES;
        }
        frusta.farthest = greatest::<T, N>(token, &frusta.reach, groups);
        let lanes = group_lanes(N);
        let count = groups.count_ones() as usize * group_size(N);
        if COMMON_ORIGIN {
            frusta.spacing = way * spacing(slope, count);
            frusta.shears = Some(GroupShears::new(token, &bounds.slope, slope, lanes, None));
        } else if slope[0][0] == slope[0][1] && slope[1][0] == slope[1][1] {
            let (center, away) = (bounds.frame.center, bounds.away);
            frusta.spacing = spacing(base, count);
            let parallel = Parallel { center, shear: [slope[0][0], slope[1][0]], start: first, away };
            frusta.shears = Some(GroupShears::new(token, &bases, base, lanes, Some(parallel)));
        }
        frusta.diverged = if frusta.shears.is_some() { frusta.diverged & groups } else { groups };
        frusta
    }

    /// The dominant axis of all rays that travel together.
    #[inline(always)]
    pub fn axis(&self) -> usize {
        self.axis
    }

    /// By how much boxes are widened: see [`super::margin`].
    #[inline(always)]
    pub fn margin(&self) -> f32 {
        self.margin
    }

    /// The groups as the edges of triangles see them, if the rays have an origin or a direction in common.
    #[inline(always)]
    pub fn shears(&self) -> Option<&GroupShears> {
        self.shears.as_ref()
    }

    /// The groups that have diverged, or have neither an origin nor a direction in common: bounds say little of them, and their
    /// rays are better tested one by one.
    #[inline(always)]
    pub fn diverged(&self) -> u32 {
        self.diverged
    }

    /// Which of eight boxes are so small, for how far rays are apart there, that few meet them, a bit each; `distances` are what
    /// [`boxes`](Self::boxes) left. None if the rays have neither an origin nor a direction in common.
    #[inline(always)]
    pub fn small<T: Token, const COMMON_ORIGIN: bool>(
        &self,
        token: T,
        planes: &Planes,
        distances: &NodeDistances,
    ) -> u32 {
        let token = token.narrow();
        let [x, y, _] = AXES[self.axis % 3];
        let mut small = 0;
        let mut at = 0;
        while at < 8 {
            let mut spacing = token.splat(self.spacing);
            if COMMON_ORIGIN {
                spacing = spacing * token.load(&distances.depth[0], at);
            }
            let across = token.load(row(planes, x + 3), at) - token.load(row(planes, x), at);
            let along = token.load(row(planes, y + 3), at) - token.load(row(planes, y), at);
            small |= across.max(along).le(spacing).bits() << at;
            at += <T::Narrow as Token>::LANES;
        }
        small
    }

    /// Those of `groups` that may still hit something from `near` on.
    #[inline(always)]
    pub fn reaching<T: Token, const N: usize>(&self, token: T, groups: u32, near: f32) -> u32 {
        let mut reaching = 0;
        let mut at = 0;
        while at < group_lanes(N) {
            reaching |= token.splat(near).le(token.load(&self.reach[..], at)).bits() << at;
            at += T::LANES;
        }
        groups & reaching
    }

    /// Which of eight boxes any ray may meet, a bit each, and how they are passed.
    #[inline(always)]
    pub fn boxes<T: Token>(&self, token: T, planes: &Planes, distances: &mut NodeDistances) -> u32 {
        let token = token.narrow();
        let mut met = 0;
        let mut at = 0;
        while at < 8 {
            let depth = self.near.depths(token, planes, at);
            depth.store(&mut distances.depth[0], at);
            let near = depth * token.splat(self.least_inverse);
            near.store(&mut distances.near, at);
            let far = self.far.depths(token, planes, at) * token.splat(self.least_inverse);
            far.store(&mut distances.far, at);
            let mut inside = far.ge(token.splat(0.0)) & near.le(token.splat(self.farthest));
            for (k, side) in self.side.iter().enumerate() {
                let depth = side.depth.depths(token, planes, at);
                depth.store(&mut distances.depth[k + 1], at);
                let plane = depth.mul_add(token.splat(side.outer_slope), token.splat(side.outer_base));
                let x = token.load(row(planes, side.x), at);
                inside = inside & if k < 2 { x.ge(plane) } else { x.le(plane) };
            }
            met |= inside.bits() << at;
            at += <T::Narrow as Token>::LANES;
        }
        met
    }

    /// Which groups may meet box `slot`, a bit each; `distances` are what [`boxes`](Self::boxes) left.
    #[inline(always)]
    pub fn groups<T: Token, const N: usize, const COMMON_ORIGIN: bool>(
        &self,
        token: T,
        planes: &Planes,
        slot: usize,
        distances: &NodeDistances,
    ) -> u32 {
        let slot = slot % 8;
        let mut met = 0;
        let mut at = 0;
        while at < group_lanes(N) {
            let near = token.splat(distances.depth[0][slot]) * token.load(&self.inverse[..], at);
            let mut inside = near.le(token.load(&self.reach[..], at));
            if !COMMON_ORIGIN {
                inside = inside & token.splat(distances.far[slot]).ge(token.load(&self.start[..], at));
            }
            for (k, side) in self.side.iter().enumerate() {
                let (slope, base) = (token.load(&side.slope[..], at), token.load(&side.base[..], at));
                let plane = token.splat(distances.depth[k + 1][slot]).mul_add(slope, base);
                let x = token.splat(row(planes, side.x)[slot]);
                inside = inside & if k < 2 { x.ge(plane) } else { x.le(plane) };
            }
            met |= inside.bits() << at;
            at += T::LANES;
        }
        met
    }

    /// After hits in the groups of a mask: they, and so all together, reach no farther than their farthest ray.
    #[inline(always)]
    pub fn shorten<T: Token, const N: usize>(&mut self, token: T, rays: &Rays<N>, mut groups: u32) {
        let size = group_size(N);
        let minus_inf = token.splat(f32::NEG_INFINITY);
        while groups != 0 {
            let group = groups.trailing_zeros() as usize % GROUPS;
            groups &= groups - 1;
            let mut farthest = minus_inf;
            let mut at = group * size;
            while at < (group + 1) * size {
                let t = token.load(&rays.t_max[..], at).select(rays.active(token, at), minus_inf);
                // On the left of `max` a NaN is passed over: a ray without an interval reaches nowhere.
                farthest = t.max(farthest);
                at += T::LANES;
            }
            let farthest = token.splat(farthest.reduce_max());
            // A whole vector, though one value changes: what is stored in parts is not there for the next load.
            let mut at = 0;
            while at < GROUPS {
                farthest.store_masked(&mut self.reach[..], at, token.mask((1 << group) >> at));
                at += T::LANES;
            }
        }
        self.farthest = greatest::<T, N>(token, &self.reach, u32::MAX);
    }
}

/// How wide a box may be that few of so many rays meet, which are spread evenly between these ends, by x and y.
#[inline(always)]
fn spacing(ends: [[f32; 2]; 2], rays: usize) -> f32 {
    let area = (ends[0][1] - ends[0][0]) * (ends[1][1] - ends[1][0]);
    SPACINGS * libm::sqrtf(area / rays as f32)
}

/// Least and greatest x and y of the rays of each group at the depth `start`.
#[inline(always)]
fn bases<T: Token, const N: usize>(
    token: T,
    rays: &Rays<N>,
    frame: &Frame,
    groups: u32,
    [x, y, z]: [usize; 3],
    start: f32,
) -> [[Row; 2]; 2] {
    let size = group_size(N);
    let nan = token.splat(f32::NAN);
    let mut bases = [[Column::splat(0.0); 2]; 2];
    let mut left = groups;
    while left != 0 {
        let group = left.trailing_zeros() as usize % GROUPS;
        left &= left - 1;
        let mut least = [token.splat(f32::INFINITY); 2];
        let mut greatest = [token.splat(f32::NEG_INFINITY); 2];
        let mut at = group * size;
        while at < (group + 1) * size {
            let active = rays.active(token, at);
            let origin = frame.origins(token, load3(token, rays.origins(), at));
            let depth = token.splat(start) - origin[z];
            for (k, axis) in [x, y].into_iter().enumerate() {
                let slope = token.load(&rays.shear_columns()[k][..], at);
                let base = depth.mul_add(slope, origin[axis]).select(active, nan);
                (least[k], greatest[k]) = (base.min(least[k]), base.max(greatest[k]));
            }
            at += T::LANES;
        }
        for k in 0..2 {
            bases[0][k][group] = least[k].reduce_min();
            bases[1][k][group] = greatest[k].reduce_max();
        }
    }
    bases
}
