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
use crate::bvh::block::Spread;
use crate::{Column, Rays};

/// Groups in a packet, at most.
pub(super) const GROUPS: usize = 16;

/// Rays in a group: 16, or as many as make 16 groups of a wider packet.
pub(super) const fn group_size(width: usize) -> usize {
    if width <= 16 * GROUPS { 16 } else { width.div_ceil(GROUPS).next_multiple_of(16) }
}

/// Lanes that the groups of a packet take: 4 or 16.
pub(super) const fn group_lanes(width: usize) -> usize {
    if width <= 4 * 16 { 4 } else { GROUPS }
}

/// The class of a group whose rays have nothing in common: they go one by one.
pub(super) const MIXED: u8 = u8::MAX;

/// x, y, z in order when the axis z is dominant.
const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// A value of every group. With four groups, those come four times.
type Row = Column<f32, GROUPS>;

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
    spread: Spread,
}

/// A side of all beams: of a box, the corner that is farthest inside has the coordinate in row `x` of a node's planes, and z
/// in that of `depth`.
#[derive(Clone, Copy, Debug)]
struct Side {
    x: usize,
    depth: Plane,
    slope: Row,
    base: Row,
}

/// A row of a node's planes, and what to subtract from it: where the rays start, moved outwards by the margin.
#[derive(Clone, Copy, Debug)]
struct Plane {
    row: usize,
    start: f32,
}

impl Plane {
    const NONE: Self = Self { row: 0, start: 0.0 };

    /// The depths of these planes of the children.
    #[inline(always)]
    fn depths<T: Token>(self, token: T, node: &Node, groups: usize, at: usize) -> T::F32 {
        token.repeat(node.row(self.row), groups, at) - token.splat(self.start)
    }
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
        let side = Side { x: 0, depth: Plane::NONE, slope: zero, base: zero };
        let mut beams = Self {
            class: [MIXED; GROUPS],
            slope: [[zero; 2]; 2],
            inverse: zero,
            origin: [[zero; 3]; 2],
            t_max: Column::splat(f32::NEG_INFINITY),
            reach: zero,
            scale,
            axis: 0,
            wide: 0,
            side: [side; 4],
            near: Plane::NONE,
            far: Plane::NONE,
            least_inverse: 0.0,
            spread: Spread::default(),
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
        // As they are in front of `start`: turned where z falls.
        let [least_x, least_y] = [0, 1]
            .map(|k| if backward { -greatest(&self.slope[1][k], groups) } else { least(&self.slope[0][k], groups) });
        let [most_x, most_y] = [0, 1]
            .map(|k| if backward { -least(&self.slope[0][k], groups) } else { greatest(&self.slope[1][k], groups) });
        let (first, last) = if backward {
            (greatest(&self.origin[1][z], groups), least(&self.origin[0][z], groups))
        } else {
            (least(&self.origin[0][z], groups), greatest(&self.origin[1][z], groups))
        };
        let (near, far) = if backward { (z + 3, z) } else { (z, z + 3) };
        self.axis = axis;
        self.near = Plane { row: near, start: last + margin * way };
        self.far = Plane { row: far, start: first - margin * way };
        self.least_inverse = if backward { greatest(&self.inverse, groups) } else { least(&self.inverse, groups) };
        let first_near = Plane { row: near, start: first + margin * way };
        // A side bounds slopes times depths that are not negative: at the near plane of a box or at the far one, by sign.
        // Where groups differ in it, those of the lesser size count as zero.
        let by_far = [least_x < 0.0, least_y < 0.0, most_x >= 0.0, most_y >= 0.0];
        for (k, (side, by_far)) in self.side.iter_mut().zip(by_far).enumerate() {
            side.x = [x + 3, y + 3, x, y][k];
            side.depth = if by_far { self.far } else { first_near };
        }
        let bases = if COMMON_ORIGIN {
            [[self.origin[0][x], self.origin[0][y]]; 2]
        } else {
            bases::<T, N>(token, rays, groups, [x, y, z], first)
        };
        self.wide = 0;
        let widths = token.splat(self.scale * (WIDE / SPREAD));
        if COMMON_ORIGIN {
            let [x, y] = [0, 1].map(|k| least(&self.slope[0][k], groups));
            let [most_x, most_y] = [0, 1].map(|k| greatest(&self.slope[1][k], groups));
            self.spread.center([x, y], [most_x, most_y]);
        }
        let mut at = 0;
        while at < GROUPS {
            let travels = token.mask(if lanes == 4 { groups * 0x1111 } else { groups } >> at);
            let zero = token.splat(0.0);
            for k in 0..2 {
                let low = row(token, &self.slope[0][k], lanes, at);
                let high = row(token, &self.slope[1][k], lanes, at);
                let bases = [row(token, &bases[0][k], lanes, at), row(token, &bases[1][k], lanes, at)];
                let wide = (high - low).gt(token.splat(WIDE)) | (bases[1] - bases[0]).gt(widths);
                self.wide |= wide.bits() << at;
                let (mut below, mut above) = if backward { (-high, -low) } else { (low, high) };
                if by_far[k] {
                    below = below.min(zero);
                }
                if by_far[k + 2] {
                    above = above.max(zero);
                }
                (below * token.splat(way)).store(&mut self.side[k].slope[..], at);
                (above * token.splat(way)).store(&mut self.side[k + 2].slope[..], at);
                (bases[0] - token.splat(margin)).store(&mut self.side[k].base[..], at);
                (bases[1] + token.splat(margin)).store(&mut self.side[k + 2].base[..], at);
            }
            if COMMON_ORIGIN {
                self.spread.set(
                    token,
                    at,
                    [
                        [row(token, &self.slope[0][0], lanes, at), row(token, &self.slope[0][1], lanes, at)],
                        [row(token, &self.slope[1][0], lanes, at), row(token, &self.slope[1][1], lanes, at)],
                    ],
                );
            }
            row(token, &self.inverse, lanes, at).store(&mut self.inverse[..], at);
            let reach = row(token, &self.t_max, lanes, at).select(travels, token.splat(f32::NEG_INFINITY));
            reach.store(&mut self.reach[..], at);
            at += T::LANES;
        }
        self.wide = if COMMON_ORIGIN { self.wide & groups } else { groups };
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

    /// The slopes of groups with a common origin, for [`Block::touches`](crate::bvh::Block::touches).
    #[inline(always)]
    pub(super) fn spread(&self) -> &Spread {
        &self.spread
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

    /// Which groups may meet which child of a node: bit `lanes * child + group`, and where at the earliest.
    #[inline(always)]
    pub(super) fn children<T: Token, const N: usize>(&self, token: T, node: &Node, near: &mut [f32; 8]) -> u128 {
        let mut at = 0;
        while at < 8 {
            let narrow = token.narrow();
            let depth = narrow.load(node.row(self.near.row), at) - narrow.splat(self.near.start);
            (depth * narrow.splat(self.least_inverse)).store(near, at);
            at += <T::Narrow as Token>::LANES;
        }
        let lanes = group_lanes(N);
        let [left, bottom, right, top] = &self.side;
        let mut met = 0;
        let mut at = 0;
        while at < 8 * lanes {
            let group = at % lanes;
            let near = self.near.depths(token, node, lanes, at) * token.load(&self.inverse[..], group);
            let far = self.far.depths(token, node, lanes, at) * token.splat(self.least_inverse);
            let inside = far.ge(token.splat(0.0))
                & near.le(token.load(&self.reach[..], group))
                & left.x(token, node, lanes, at).ge(left.plane(token, node, lanes, at))
                & bottom.x(token, node, lanes, at).ge(bottom.plane(token, node, lanes, at))
                & right.x(token, node, lanes, at).le(right.plane(token, node, lanes, at))
                & top.x(token, node, lanes, at).le(top.plane(token, node, lanes, at));
            met |= u128::from(inside.bits()) << at;
            at += T::LANES;
        }
        met
    }

    /// After hits: the rays of a group reach no farther than this.
    #[inline(always)]
    pub(super) fn shorten<T: Token, const N: usize>(&mut self, token: T, group: usize, farthest: f32) {
        let lanes = if group_lanes(N) == 4 { 0x1111 } else { 1 } << group;
        // A whole vector, though one value changes: what is stored in parts is not there for the next load.
        let mut at = 0;
        while at < GROUPS {
            token.splat(farthest).store_masked(&mut self.reach[..], at, token.mask(lanes >> at));
            at += T::LANES;
        }
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

impl Side {
    /// Where the boxes end on this side.
    #[inline(always)]
    fn x<T: Token>(&self, token: T, node: &Node, lanes: usize, at: usize) -> T::F32 {
        token.repeat(node.row(self.x), lanes, at)
    }

    /// Where the beams end on this side, at the boxes' depth.
    #[inline(always)]
    fn plane<T: Token>(&self, token: T, node: &Node, lanes: usize, at: usize) -> T::F32 {
        let (slope, base) = (token.load(&self.slope[..], at % lanes), token.load(&self.base[..], at % lanes));
        self.depth.depths(token, node, lanes, at).mul_add(slope, base)
    }
}

/// Groups of rays whose slopes differ by more than this (a tile of 4x4 pixels is a few thousandths wide) have come apart.
const WIDE: f32 = 1.0 / 100.0;
/// Groups with origins beyond are not bounded: sums and products of such overflow.
const FARTHEST: f32 = 1e30;
/// How many times as wide as the slopes the bases may be, as a share of the scene.
const SPREAD: f32 = 2.0;

/// A row of which only the first `lanes` are there, so often as it takes.
#[inline(always)]
fn row<T: Token>(token: T, row: &Row, lanes: usize, at: usize) -> T::F32 {
    match row.first_chunk::<4>() {
        Some(four) if lanes == 4 => token.tile(four, at),
        _ => token.load(&row[..], at),
    }
}

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

/// The greatest of the groups of a mask.
#[inline(always)]
fn greatest(row: &Row, groups: u32) -> f32 {
    let mut greatest = f32::NEG_INFINITY;
    let mut left = groups;
    while left != 0 {
        greatest = max(row[left.trailing_zeros() as usize % GROUPS], greatest);
        left &= left - 1;
    }
    greatest
}

/// The least of the groups of a mask.
#[inline(always)]
fn least(row: &Row, groups: u32) -> f32 {
    let mut least = f32::INFINITY;
    let mut left = groups;
    while left != 0 {
        let value = row[left.trailing_zeros() as usize % GROUPS];
        least = if value < least { value } else { least };
        left &= left - 1;
    }
    least
}
