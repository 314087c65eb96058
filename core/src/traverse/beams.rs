//! Bounds of the rays of a packet, a group of neighbours at a time, so that boxes can be dismissed for all of them at once.
//!
//! After Reshetov, Soupikov and Hurley, "Multi-Level Ray Tracing Algorithm", SIGGRAPH 2005. All directions of a group
//! have the same dominant axis z and go the same way along it. From the plane `z = start`, at or before all origins, a ray
//! runs along `x = base + slope * (z - start)`, with the slopes that the triangle test shears by. So a group is two intervals
//! of bases and two of slopes: four planes, and nothing has to be divided. With a common origin the intervals of bases are
//! points and the four planes are a frustum; parallel rays have points for slopes. An axis and a way make a class: groups of
//! one class travel together, and meet a box in one vector, a group a lane.

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

use super::PAD;
use crate::bvh::Node;
use crate::kernel::groups::{GROUPS, Groups, Parallel, Row, greatest, group_lanes, group_size, least};
use crate::rays::AXES;
use crate::{Column, Rays};

/// The class of a group whose rays have nothing in common: they go one by one.
pub(super) const MIXED: u8 = u8::MAX;

#[derive(Clone, Copy, Debug)]
pub(super) struct Beams {
    class: [u8; GROUPS],
    /// Least and greatest slopes, x then y, of each group.
    slope: [[Row; 2]; 2],
    /// The reciprocal of the direction along z that is least in size: it makes depths into the least distances.
    inverse: Row,
    /// Least and greatest origins.
    origin: [[Row; 3]; 2],
    /// The far end of each group's intervals.
    t_max: Row,
    /// The farthest that any ray of the groups that travel may still hit; `-inf` for others.
    reach: Row,
    /// Where the first ray of each group starts, from the first of all, in the measure of [`Passage::far`].
    start: Row,
    /// The greatest coordinate of the tree and of the origins.
    scale: f32,
    axis: usize,
    wide: u32,
    /// x from below, y from below, x from above, y from above, of those that travel together.
    side: [Side; 4],
    /// The planes of a box that the rays meet first, from the last origin, and last, from the first origin.
    near: Plane,
    far: Plane,
    /// Of all that travel.
    least_inverse: f32,
    farthest: f32,
    /// Have the rays an origin or a direction in common?
    alike: bool,
    /// For the edges of triangles, if so.
    groups: Groups,
}

/// A side of all beams: of a box, the corner that is farthest inside has the coordinate in row `x` of a node's planes, and z
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

/// A row of a node's planes, and what to subtract from it: where the rays start, moved outwards by the margin.
#[derive(Clone, Copy, Debug)]
struct Plane {
    row: usize,
    start: f32,
}

impl Plane {
    const NONE: Self = Self { row: 0, start: 0.0 };

    /// The depths of these planes of the children from `at`.
    #[inline(always)]
    fn depths<T: Token>(self, token: T, node: &Node, at: usize) -> T::F32 {
        token.load(node.row(self.row), at) - token.splat(self.start)
    }
}

/// How beams pass the children of a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    /// Where they enter each child at the earliest.
    pub(super) near: [f32; 8],
    /// Where they leave it at the latest, less the least distance to it.
    far: [f32; 8],
    /// The depth of its near plane, and of the corner that is farthest inside on each side.
    depth: [[f32; 8]; 5],
}

impl Passage {
    pub(super) const NONE: Self = Self { near: [0.0; 8], far: [0.0; 8], depth: [[0.0; 8]; 5] };
}

impl Beams {
    /// Looks at all groups of a packet, whose shears are derived.
    #[inline(always)]
    pub(super) fn new<T: Token, const N: usize, const COMMON_ORIGIN: bool>(
        token: T,
        rays: &Rays<N>,
        scale: f32,
    ) -> Self {
        let zero = Column::splat(0.0);
        let side = Side { x: 0, depth: Plane::NONE, slope: zero, base: zero, outer_slope: 0.0, outer_base: 0.0 };
        let mut beams = Self {
            class: [MIXED; GROUPS],
            slope: [[zero; 2]; 2],
            inverse: zero,
            origin: [[zero; 3]; 2],
            t_max: Column::splat(f32::NEG_INFINITY),
            reach: zero,
            start: zero,
            scale,
            axis: 0,
            wide: 0,
            side: [side; 4],
            near: Plane::NONE,
            far: Plane::NONE,
            least_inverse: 0.0,
            farthest: 0.0,
            alike: false,
            groups: Groups::default(),
        };
        let range = rays.range();
        let size = group_size(N);
        for group in range.start / size..range.end.div_ceil(size) {
            if range.start <= group * size && (group + 1) * size <= range.end {
                beams.look::<T, N, COMMON_ORIGIN, false>(token, rays, group % GROUPS);
            } else {
                beams.look::<T, N, COMMON_ORIGIN, true>(token, rays, group % GROUPS);
            }
        }
        if COMMON_ORIGIN {
            let (origin, _) = rays.ray(range.start);
            for (axis, x) in origin.to_array().into_iter().enumerate() {
                beams.origin[0][axis] = Column::splat(x);
                beams.origin[1][axis] = Column::splat(x);
                beams.scale = max(x.abs(), beams.scale);
            }
            if beams.scale > FARTHEST {
                beams.class = [MIXED; GROUPS];
            }
        } else {
            for group in range.start / size..range.end.div_ceil(size) {
                for axis in 0..if beams.class(group) == MIXED { 0 } else { 3 } {
                    let (least, greatest) =
                        (beams.origin[0][axis][group % GROUPS], beams.origin[1][axis][group % GROUPS]);
                    beams.scale = max(max(least.abs(), greatest.abs()), beams.scale);
                }
            }
        }
        beams
    }

    /// Groups of one class can travel together.
    #[inline(always)]
    pub(super) fn class(&self, group: usize) -> u8 {
        self.class[group % GROUPS]
    }

    /// Lets all groups of this class travel together, and says which they are.
    #[inline(always)]
    pub(super) fn gather<T: Token, const N: usize, const COMMON_ORIGIN: bool>(
        &mut self,
        token: T,
        rays: &Rays<N>,
        class: u8,
    ) -> u32 {
        let lanes = group_lanes(N);
        let mut groups = 0;
        for group in 0..lanes {
            groups |= u32::from(self.class[group] == class) << group;
        }
        let axis = usize::from(class / 2) % 3;
        let backward = class & 1 != 0;
        let way = if backward { -1.0 } else { 1.0 };
        let [x, y, z] = AXES[axis];
        let margin = self.margin();
        let mut slope = [[0.0; 2]; 2];
        for k in 0..2 {
            slope[k][0] = least::<T, N>(token, &self.slope[0][k], groups);
            slope[k][1] = greatest::<T, N>(token, &self.slope[1][k], groups);
        }
        let depths =
            [least::<T, N>(token, &self.origin[0][z], groups), greatest::<T, N>(token, &self.origin[1][z], groups)];
        let (first, last) = if backward { (depths[1], depths[0]) } else { (depths[0], depths[1]) };
        let (near, far) = if backward { (z + 3, z) } else { (z, z + 3) };
        self.axis = axis;
        self.near = Plane { row: near, start: last + margin * way };
        self.far = Plane { row: far, start: first - margin * way };
        self.least_inverse = if backward {
            greatest::<T, N>(token, &self.inverse, groups)
        } else {
            least::<T, N>(token, &self.inverse, groups)
        };
        let first_near = Plane { row: near, start: first + margin * way };
        let bases = if COMMON_ORIGIN {
            [[self.origin[0][x], self.origin[0][y]]; 2]
        } else {
            bases::<T, N>(token, rays, groups, [x, y, z], first)
        };
        let mut base = [[0.0; 2]; 2];
        for k in 0..2 {
            base[k][0] = least::<T, N>(token, &bases[0][k], groups);
            base[k][1] = greatest::<T, N>(token, &bases[1][k], groups);
        }
        self.wide = 0;
        for k in 0..2 {
            // As they are in front of `first`: turned where z falls.
            let [below, above] = if backward { [-slope[k][1], -slope[k][0]] } else { slope[k] };
            // A side bounds slopes times depths that are not negative: at the near plane of a box or at the far one, by sign.
            // Where groups differ in it, those of the lesser size count as zero.
            let by_far = [below < 0.0, above >= 0.0];
            let rows = [[x, y][k] + 3, [x, y][k]];
            for (side, outer) in [below, above].into_iter().enumerate() {
                let bound = &mut self.side[k + 2 * side];
                bound.x = rows[side];
                bound.depth = if by_far[side] { self.far } else { first_near };
                bound.outer_slope = outer * way;
                bound.outer_base = base[k][side] + if side == 0 { -margin } else { margin };
            }
            let widths = token.splat(self.scale * (WIDE / SPREAD));
            let zero = token.splat(0.0);
            let mut at = 0;
            while at < group_lanes(N) {
                let (low, high) = (token.load(&self.slope[0][k][..], at), token.load(&self.slope[1][k][..], at));
                let bases = [token.load(&bases[0][k][..], at), token.load(&bases[1][k][..], at)];
                let wide = (high - low).gt(token.splat(WIDE)) | (bases[1] - bases[0]).gt(widths);
                self.wide |= wide.bits() << at;
                let (mut below, mut above) = if backward { (-high, -low) } else { (low, high) };
                if by_far[0] {
                    below = below.min(zero);
                }
                if by_far[1] {
                    above = above.max(zero);
                }
                (below * token.splat(way)).store(&mut self.side[k].slope[..], at);
                (above * token.splat(way)).store(&mut self.side[k + 2].slope[..], at);
                (bases[0] - token.splat(margin)).store(&mut self.side[k].base[..], at);
                (bases[1] + token.splat(margin)).store(&mut self.side[k + 2].base[..], at);
                at += T::LANES;
            }
        }
        let mut at = 0;
        while at < group_lanes(N) {
            let travels = token.mask(groups >> at);
            let reach = token.load(&self.t_max[..], at).select(travels, token.splat(f32::NEG_INFINITY));
            reach.store(&mut self.reach[..], at);
            if !COMMON_ORIGIN {
                let start = token.load(&self.origin[usize::from(backward)][z][..], at) - token.splat(first);
                (start * token.splat(self.least_inverse)).store(&mut self.start[..], at);
            }
            at += T::LANES;
        }
        self.farthest = greatest::<T, N>(token, &self.reach, groups);
        self.alike = COMMON_ORIGIN || (slope[0][0] == slope[0][1] && slope[1][0] == slope[1][1]);
        if COMMON_ORIGIN {
            self.groups = Groups::new(token, &self.slope, slope, group_lanes(N), None);
        } else if self.alike {
            let parallel = Parallel { shear: [slope[0][0], slope[1][0]], start: first, scale: self.scale };
            self.groups = Groups::new(token, &bases, base, group_lanes(N), Some(parallel));
        }
        self.wide = if self.alike { self.wide & groups } else { groups };
        groups
    }

    /// The dominant axis of all rays that travel together.
    #[inline(always)]
    pub(super) fn axis(&self) -> usize {
        self.axis
    }

    /// By how much boxes are widened: see [`traverse`](super).
    #[inline(always)]
    pub(super) fn margin(&self) -> f32 {
        self.scale * PAD
    }

    /// The groups as the edges of triangles see them, if the rays have an origin or a direction in common.
    #[inline(always)]
    pub(super) fn groups(&self) -> Option<&Groups> {
        self.alike.then_some(&self.groups)
    }

    /// The groups that have come apart, so that bounds say little of them: their rays are better tested one by one.
    #[inline(always)]
    pub(super) fn wide(&self) -> u32 {
        self.wide
    }

    /// Those of `groups` that may still hit something from `near` on.
    #[inline(always)]
    pub(super) fn reaching<T: Token, const N: usize>(&self, token: T, groups: u32, near: f32) -> u32 {
        let mut reaching = 0;
        let mut at = 0;
        while at < group_lanes(N) {
            reaching |= token.splat(near).le(token.load(&self.reach[..], at)).bits() << at;
            at += T::LANES;
        }
        groups & reaching
    }

    /// Which children of a node any ray may meet, a bit each, and how they are passed.
    #[inline(always)]
    pub(super) fn children<T: Token>(&self, token: T, node: &Node, passage: &mut Passage) -> u32 {
        let token = token.narrow();
        let mut met = 0;
        let mut at = 0;
        while at < 8 {
            let depth = self.near.depths(token, node, at);
            depth.store(&mut passage.depth[0], at);
            let near = depth * token.splat(self.least_inverse);
            near.store(&mut passage.near, at);
            let far = self.far.depths(token, node, at) * token.splat(self.least_inverse);
            far.store(&mut passage.far, at);
            let mut inside = far.ge(token.splat(0.0)) & near.le(token.splat(self.farthest));
            for (k, side) in self.side.iter().enumerate() {
                let depth = side.depth.depths(token, node, at);
                depth.store(&mut passage.depth[k + 1], at);
                let plane = depth.mul_add(token.splat(side.outer_slope), token.splat(side.outer_base));
                let x = token.load(node.row(side.x), at);
                inside = inside & if k < 2 { x.ge(plane) } else { x.le(plane) };
            }
            met |= inside.bits() << at;
            at += <T::Narrow as Token>::LANES;
        }
        met
    }

    /// Which groups may meet a child.
    #[inline(always)]
    pub(super) fn meeting<T: Token, const N: usize, const COMMON_ORIGIN: bool>(
        &self,
        token: T,
        node: &Node,
        slot: usize,
        passage: &Passage,
    ) -> u32 {
        let slot = slot % 8;
        let mut met = 0;
        let mut at = 0;
        while at < group_lanes(N) {
            let near = token.splat(passage.depth[0][slot]) * token.load(&self.inverse[..], at);
            let mut inside = near.le(token.load(&self.reach[..], at));
            if !COMMON_ORIGIN {
                inside = inside & token.splat(passage.far[slot]).ge(token.load(&self.start[..], at));
            }
            for (k, side) in self.side.iter().enumerate() {
                let (slope, base) = (token.load(&side.slope[..], at), token.load(&side.base[..], at));
                let plane = token.splat(passage.depth[k + 1][slot]).mul_add(slope, base);
                let x = token.splat(node.row(side.x)[slot]);
                inside = inside & if k < 2 { x.ge(plane) } else { x.le(plane) };
            }
            met |= inside.bits() << at;
            at += T::LANES;
        }
        met
    }

    /// After hits: the rays of a group reach no farther than this.
    #[inline(always)]
    pub(super) fn shorten<T: Token>(&mut self, token: T, group: usize, farthest: f32) {
        // A whole vector, though one value changes: what is stored in parts is not there for the next load.
        let mut at = 0;
        while at < GROUPS {
            token.splat(farthest).store_masked(&mut self.reach[..], at, token.mask((1 << group) >> at));
            at += T::LANES;
        }
    }

    /// After hits in some groups: all together reach no farther than the farthest.
    #[inline(always)]
    pub(super) fn shortened<T: Token, const N: usize>(&mut self, token: T) {
        self.farthest = greatest::<T, N>(token, &self.reach, u32::MAX);
    }

    /// Bounds the rays of a group, some of which may be inactive if `MASKED`. Leaves out a common origin.
    #[inline(always)]
    fn look<T: Token, const N: usize, const COMMON_ORIGIN: bool, const MASKED: bool>(
        &mut self,
        token: T,
        rays: &Rays<N>,
        group: usize,
    ) {
        let size = group_size(N);
        let (inf, minus_inf, zero) = (token.splat(f32::INFINITY), token.splat(f32::NEG_INFINITY), token.splat(0.0));
        // Inactive lanes become NaN, which min and max pass over.
        let nan = token.splat(f32::NAN);
        let (mut low, mut high) = ([inf; 3], [minus_inf; 3]);
        let (mut low_origin, mut high_origin) = ([inf; 3], [minus_inf; 3]);
        let mut far = minus_inf;
        let axis = rays.axes()[rays.range().start.max(group * size)];
        let (mut mixed, mut early) = (false, false);
        let mut at = group * size;
        while at < (group + 1) * size {
            let active = rays.active(token, at);
            let mut same = token.load_u32(&rays.axes()[..], at).eq(token.splat_i32(axis as i32));
            let mut t_min = token.load(&rays.t_min()[..], at);
            let mut t_max = token.load(&rays.t_max[..], at);
            if MASKED {
                t_min = t_min.select(active, nan);
                t_max = t_max.select(active, nan);
                same = same | !active;
            }
            far = t_max.max(far);
            early |= t_min.lt(zero).any();
            mixed |= !same.all();
            for k in 0..3 {
                let mut x = token.load(&rays.shear_columns()[k][..], at);
                if MASKED {
                    x = x.select(active, nan);
                }
                (low[k], high[k]) = (x.min(low[k]), x.max(high[k]));
                if !COMMON_ORIGIN {
                    let mut x = token.load(&rays.origins()[k][..], at);
                    if MASKED {
                        x = x.select(active, nan);
                    }
                    (low_origin[k], high_origin[k]) = (x.min(low_origin[k]), x.max(high_origin[k]));
                }
            }
            at += T::LANES;
        }
        let (least, greatest) = (low[2].reduce_min(), high[2].reduce_max());
        let backward = greatest < 0.0;
        mixed |= early || (least < 0.0) != backward;
        self.class[group] = if mixed { MIXED } else { axis as u8 * 2 + u8::from(backward) };
        self.inverse[group] = if backward { greatest } else { least };
        self.t_max[group] = far.reduce_max();
        for k in 0..2 {
            self.slope[0][k][group] = low[k].reduce_min();
            self.slope[1][k][group] = high[k].reduce_max();
        }
        if !COMMON_ORIGIN {
            for k in 0..3 {
                let (low, high) = (low_origin[k].reduce_min(), high_origin[k].reduce_max());
                (self.origin[0][k][group], self.origin[1][k][group]) = (low, high);
                // One ray from nowhere must not blur the others' bounds.
                if max(low.abs(), high.abs()) > FARTHEST {
                    self.class[group] = MIXED;
                }
            }
        }
    }
}

/// Groups of rays whose slopes differ by more than this (a tile of 4x4 pixels is a few thousandths wide) have come apart.
const WIDE: f32 = 1.0 / 160.0;
/// Groups with origins beyond are not bounded: sums and products of such overflow.
const FARTHEST: f32 = 1e30;
/// How many times as wide as the slopes the bases may be, as a share of the scene.
const SPREAD: f32 = 2.0;

/// Least and greatest x and y of the rays of each group at the depth `start`.
#[inline(always)]
fn bases<T: Token, const N: usize>(
    token: T,
    rays: &Rays<N>,
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
            let origin = rays.origins();
            let depth = token.splat(start) - token.load(&origin[z][..], at);
            for (k, axis) in [x, y].into_iter().enumerate() {
                let slope = token.load(&rays.shear_columns()[k][..], at);
                let base = depth.mul_add(slope, token.load(&origin[axis][..], at)).select(active, nan);
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

/// `if x > y { x } else { y }`
#[inline(always)]
fn max(x: f32, y: f32) -> f32 {
    if x > y { x } else { y }
}
