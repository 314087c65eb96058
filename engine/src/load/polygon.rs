//! Cutting polygons into triangles: fans for convex ones, ears for the rest (Meisters 1975; Held, "FIST: Fast Industrial-Strength
//! Triangulation of Polygons", Algorithmica 2001, for the grid).

use glam::{DVec2, DVec3};

/// How many corners may be looked at for each corner of a polygon, and for all polygons of a file, before they are cut where they
/// stand: what crosses itself many times must not cost more than in proportion to its size.
const LOOKS: [usize; 2] = [4096, 1 << 28];

/// Cuts polygons; keeps its memory.
#[derive(Debug)]
pub(super) struct Cutter {
    /// How many corners may be looked at still.
    looks: usize,
    /// Polygons that were cut where they stood.
    pub(super) rough: u64,
    corners: Vec<DVec2>,
    /// The corners that are left, in a ring.
    next: Vec<u32>,
    before: Vec<u32>,
    /// Those that turn right, which alone may be in an ear; and where in a grid they are.
    reflex: Vec<bool>,
    cells: Vec<Vec<u32>>,
    side: usize,
    low: DVec2,
    cell: DVec2,
}

impl Default for Cutter {
    fn default() -> Self {
        Self {
            looks: LOOKS[1],
            rough: 0,
            corners: Vec::new(),
            next: Vec::new(),
            before: Vec::new(),
            reflex: Vec::new(),
            cells: Vec::new(),
            side: 0,
            low: DVec2::ZERO,
            cell: DVec2::ZERO,
        }
    }
}

impl Cutter {
    /// Appends the triangles of the polygon with these corners to `out`, as places among them: always two less than it has corners.
    /// Polygons that are not flat, cross themselves or are not finite give some triangles too.
    pub(super) fn cut(&mut self, corners: impl Iterator<Item = [f64; 3]> + Clone, out: &mut Vec<[u32; 3]>) {
        self.flatten(corners);
        let count = self.corners.len() as u32;
        if count < 3 {
            return;
        }
        let ring = |place: u32| [(place + count - 1) % count, place, (place + 1) % count];
        if (0..count).all(|place| self.turn(ring(place)) >= 0.0) {
            out.extend((2..count).map(|place| [0, place - 1, place]));
        } else {
            self.cut_ears(out);
        }
    }

    /// Looks at the polygon along its normal (Newell), so that it goes round to the left.
    fn flatten(&mut self, mut corners: impl Iterator<Item = [f64; 3]> + Clone) {
        self.corners.clear();
        let Some(origin) = corners.clone().next().map(DVec3::from) else { return };
        let (mut normal, mut last) = (DVec3::ZERO, DVec3::ZERO);
        for corner in corners.clone().map(|corner| DVec3::from(corner) - origin) {
            normal += last.cross(corner);
            last = corner;
        }
        let size = normal.abs();
        let (x, y) = match size.max_element() {
            most if most == size.x => (DVec3::Y, DVec3::Z),
            most if most == size.y => (DVec3::Z, DVec3::X),
            _ => (DVec3::X, DVec3::Y),
        };
        let x = if x.cross(y).dot(normal) < 0.0 { -x } else { x };
        let flat =
            |corner: [f64; 3]| DVec2::new((DVec3::from(corner) - origin).dot(x), (DVec3::from(corner) - origin).dot(y));
        self.corners.extend(corners.by_ref().map(flat));
    }

    /// Positive where the second corner turns left.
    fn turn(&self, [a, b, c]: [u32; 3]) -> f64 {
        let [a, b, c] = [a, b, c].map(|place| self.corners[place as usize]);
        (b - a).perp_dot(c - b)
    }

    fn cut_ears(&mut self, out: &mut Vec<[u32; 3]>) {
        let count = self.corners.len();
        let places = 0..count as u32;
        (self.next, self.before) = (places.clone().collect(), places.collect());
        self.next.rotate_left(1);
        self.before.rotate_right(1);
        self.reflex = (0..count as u32).map(|place| self.turn(self.around(place)) < 0.0).collect();
        self.sort_into_cells();
        let budget = LOOKS[0].saturating_mul(count).min(self.looks);
        let mut looks = budget;
        // `end`: the corner at which all that are left were looked at without an ear.
        let (mut left, mut place, mut end) = (count, 0, 0);
        let mut fruitless = false;
        while left > 3 {
            let ear = self.around(place);
            let next = self.next[place as usize];
            if fruitless || looks == 0 || self.is_ear(ear, &mut looks) {
                out.push(ear);
                left -= 1;
                self.next[ear[0] as usize] = ear[2];
                self.before[ear[2] as usize] = ear[0];
                self.reflex[place as usize] = false;
                // What turned left does so ever after.
                for beside in [ear[0], ear[2]] {
                    if self.reflex[beside as usize] && self.turn(self.around(beside)) >= 0.0 {
                        self.reflex[beside as usize] = false;
                    }
                }
                // The neighbour after it: fans become fewer needles.
                place = self.next[next as usize];
                (end, fruitless) = (ear[0], false);
            } else {
                place = next;
                fruitless = place == end;
            }
        }
        let last = self.around(place);
        out.push(last);
        self.looks -= budget - looks;
        self.rough += u64::from(looks == 0);
    }

    /// A corner between its neighbours.
    fn around(&self, place: u32) -> [u32; 3] {
        [self.before[place as usize], place, self.next[place as usize]]
    }

    /// Does the ear turn left, and is no other corner in it?
    fn is_ear(&self, ear: [u32; 3], looks: &mut usize) -> bool {
        if self.turn(ear).partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return false;
        }
        let corners = ear.map(|place| self.corners[place as usize]);
        let (low, high) = (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
        let ([x, y], [to_x, to_y]) = (self.cell_of(low), self.cell_of(high));
        for cell in (y..=to_y).flat_map(|y| (x..=to_x).map(move |x| (x, y))) {
            for &place in &self.cells[cell.1 * self.side + cell.0] {
                *looks = looks.saturating_sub(1);
                if !self.reflex[place as usize] || ear.contains(&place) {
                    continue;
                }
                let point = self.corners[place as usize];
                let inside = (0..3).all(|k| (corners[(k + 1) % 3] - corners[k]).perp_dot(point - corners[k]) >= 0.0);
                // Where the polygon touches itself in a corner of the ear, that does not make it less of one.
                if inside && !corners.contains(&point) {
                    return false;
                }
            }
        }
        true
    }

    fn sort_into_cells(&mut self) {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for &corner in self.corners.iter().filter(|corner| corner.is_finite()) {
            (low, high) = (low.min(corner), high.max(corner));
        }
        self.side = (self.corners.len() as f64).sqrt() as usize / 2 + 1;
        (self.low, self.cell) = (low, (high - low) / self.side as f64);
        self.cells.iter_mut().for_each(Vec::clear);
        self.cells.resize_with(self.cells.len().max(self.side * self.side), Vec::new);
        for place in (0..self.corners.len()).filter(|&place| self.reflex[place]) {
            let [x, y] = self.cell_of(self.corners[place]);
            self.cells[y * self.side + x].push(place as u32);
        }
    }

    /// The cell that a point is in; one at the edge if it is in none.
    fn cell_of(&self, point: DVec2) -> [usize; 2] {
        // What is no number is 0 as an integer.
        let at = (point - self.low) / self.cell;
        [at.x, at.y].map(|x| (x as usize).min(self.side - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(corners: &[[f64; 2]]) -> Vec<[u32; 3]> {
        let mut out = Vec::new();
        Cutter::default().cut(corners.iter().map(|&[x, y]| [x, y, 5.0]), &mut out);
        out
    }

    /// Twice the area of a polygon, and of its triangles; are they all turned the same way?
    fn areas(corners: &[[f64; 2]], triangles: &[[u32; 3]]) -> (f64, f64, bool) {
        let cross = |[ax, ay]: [f64; 2], [bx, by]: [f64; 2]| ax * by - ay * bx;
        let whole: f64 = (0..corners.len()).map(|i| cross(corners[i], corners[(i + 1) % corners.len()])).sum();
        let each = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|i| corners[i as usize]);
            cross([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]])
        });
        let each: Vec<f64> = each.collect();
        (whole, each.iter().sum(), each.iter().all(|area| area * whole.signum() >= 0.0))
    }

    fn is_cut_right(corners: &[[f64; 2]]) {
        let triangles = cut(corners);
        assert_eq!(triangles.len(), corners.len() - 2);
        let (whole, sum, alike) = areas(corners, &triangles);
        assert!(alike && (whole - sum).abs() < 1e-9 * whole.abs(), "{} corners: {whole} {sum} {alike}", corners.len());
    }

    /// A comb: as concave as can be.
    fn comb(teeth: usize) -> Vec<[f64; 2]> {
        let tooth = |i: usize| [[i as f64, 0.0], [i as f64 + 0.5, 9.0 + (i % 7) as f64]];
        (0..teeth).flat_map(tooth).chain([[teeth as f64, -1.0], [0.0, -1.0]]).collect()
    }

    #[test]
    fn concave_polygons_keep_their_area() {
        let l = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
        for start in 0..6 {
            let mut turned = l;
            turned.rotate_left(start);
            is_cut_right(&turned);
            turned.reverse();
            is_cut_right(&turned);
        }
        for points in [10, 300, 5000] {
            let star = |i: usize| {
                let (s, c) = (i as f64 * std::f64::consts::TAU / points as f64).sin_cos();
                let r = if i.is_multiple_of(2) { 1.0 } else { 0.4 };
                [c * r, s * r]
            };
            is_cut_right(&(0..points).map(star).collect::<Vec<_>>());
        }
        // A spiral of one wall.
        let side = |i: usize, r: f64| {
            let (s, c) = (i as f64 * 0.05).sin_cos();
            [c * (1.0 + i as f64 * 0.01 + r), s * (1.0 + i as f64 * 0.01 + r)]
        };
        let spiral: Vec<_> = (0..3000).map(|i| side(i, 0.0)).chain((0..3000).rev().map(|i| side(i, 0.3))).collect();
        is_cut_right(&spiral);
        is_cut_right(&comb(100));
    }

    #[test]
    fn a_polygon_of_a_hundred_thousand_corners_takes_no_time() {
        let start = std::time::Instant::now();
        is_cut_right(&comb(50_000));
        assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
    }

    #[test]
    fn a_polygon_that_touches_itself_keeps_its_area() {
        // A square with a hole, joined by a seam.
        is_cut_right(&[
            [0., 0.],
            [4., 0.],
            [4., 4.],
            [0., 4.],
            [0., 0.],
            [1., 1.],
            [1., 3.],
            [3., 3.],
            [3., 1.],
            [1., 1.],
        ]);
    }

    #[test]
    fn a_degenerate_polygon_ends() {
        assert_eq!(cut(&[[f64::NAN; 2], [0.0; 2], [1.0; 2], [f64::NAN; 2], [0.0; 2], [1.0; 2], [1.0; 2]]).len(), 5);
        assert_eq!(cut(&[[0.0; 2]; 2000]).len(), 1998);
        assert_eq!(cut(&[[0.0; 2]; 2]).len(), 0);
        let random = |i: u64| ((i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) & 0xffff) as f64;
        let crossing: Vec<_> = (0..20_000).map(|i| [random(2 * i), random(2 * i + 1)]).collect();
        assert_eq!(cut(&crossing).len(), crossing.len() - 2);
    }
}
