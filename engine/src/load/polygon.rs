//! Cutting polygons into triangles: fans for convex ones, ears for the rest (Meisters 1975).

use glam::Vec3;

/// Polygons with more corners are cut as a fan, so that a hostile one costs time in proportion to its size.
const MOST_CORNERS: usize = 256;

/// Appends the triangles of the polygon with corners `polygon` (indices into `positions`) to `out`: always two less
/// than it has corners. Polygons that are not flat, cross themselves or are not finite give some triangles too.
pub(super) fn triangulate(positions: &[Vec3], polygon: &[u32], out: &mut Vec<[u32; 3]>) {
    match *polygon {
        [a, b, c] => out.push([a, b, c]),
        [first, ref rest @ ..] if rest.len() >= 3 => {
            let convex = polygon.len() <= MOST_CORNERS && is_convex(positions, polygon);
            if convex || polygon.len() > MOST_CORNERS {
                out.extend(rest.windows(2).map(|pair| [first, pair[0], pair[1]]));
            } else {
                cut_ears(positions, polygon, out);
            }
        }
        _ => {}
    }
}

/// Twice the polygon's area, as a vector along its normal (Newell).
fn normal(positions: &[Vec3], polygon: &[u32]) -> Vec3 {
    let origin = positions[polygon[0] as usize];
    let corner = |i: usize| positions[polygon[i] as usize] - origin;
    (1..polygon.len() - 1).map(|i| corner(i).cross(corner(i + 1))).sum()
}

fn is_convex(positions: &[Vec3], polygon: &[u32]) -> bool {
    let normal = normal(positions, polygon);
    let n = polygon.len();
    (0..n).all(|i| turn(positions, normal, [polygon[i], polygon[(i + 1) % n], polygon[(i + 2) % n]]) >= 0.0)
}

/// Positive where the corner b turns left, seen from the tip of the normal.
fn turn(positions: &[Vec3], normal: Vec3, [a, b, c]: [u32; 3]) -> f32 {
    let [a, b, c] = [a, b, c].map(|i| positions[i as usize]);
    (b - a).cross(c - b).dot(normal)
}

fn cut_ears(positions: &[Vec3], polygon: &[u32], out: &mut Vec<[u32; 3]>) {
    let normal = normal(positions, polygon);
    let mut left = polygon.to_vec();
    // Each round looks at one corner; simple polygons need about two rounds a corner. The budget is for the others.
    let mut budget = 8 * left.len();
    let mut i = 0;
    while left.len() > 3 {
        let n = left.len();
        i %= n;
        let ear = [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
        let is_ear = turn(positions, normal, ear) > 0.0
            && !left.iter().any(|&point| {
                !ear.contains(&point)
                    && (0..3).all(|k| turn(positions, normal, [ear[k], ear[(k + 1) % 3], point]) >= 0.0)
            });
        budget = budget.saturating_sub(1);
        if is_ear || budget == 0 {
            out.push(ear);
            left.remove(i);
        } else {
            i += 1;
        }
    }
    out.push([left[0], left[1], left[2]]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(positions: &[Vec3], triangles: &[[u32; 3]]) -> (f32, bool) {
        let mut all_left = true;
        let mut sum = 0.0;
        for t in triangles {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            let z = (b - a).cross(c - a).z / 2.0;
            all_left &= z >= 0.0;
            sum += z;
        }
        (sum, all_left)
    }

    #[test]
    fn a_concave_polygon_keeps_its_area() {
        // An L and a star, the star with 10 corners.
        let l = [(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)].map(|(x, y)| Vec3::new(x, y, 5.0));
        let mut out = Vec::new();
        for start in 0..6 {
            out.clear();
            let polygon: Vec<u32> = (0..6).map(|i| (i + start) % 6).collect();
            triangulate(&l, &polygon, &mut out);
            assert_eq!(out.len(), 4);
            assert_eq!(area(&l, &out), (3.0, true), "from corner {start}");
        }
        let star: Vec<Vec3> = (0..10)
            .map(|i| {
                let (s, c) = (i as f32 * std::f32::consts::TAU / 10.0).sin_cos();
                Vec3::new(c, s, 0.0) * if i % 2 == 0 { 1.0 } else { 0.4 }
            })
            .collect();
        out.clear();
        triangulate(&star, &(0..10).collect::<Vec<_>>(), &mut out);
        let (sum, all_left) = area(&star, &out);
        let expected = 10.0 * 0.5 * 0.4 * (std::f32::consts::TAU / 10.0).sin();
        assert!(all_left && (sum - expected).abs() < 1e-5, "{sum} of {expected}");
    }

    #[test]
    fn a_degenerate_polygon_ends() {
        let mut out = Vec::new();
        triangulate(&[Vec3::NAN, Vec3::ZERO, Vec3::ONE], &[0, 1, 2, 0, 1, 2, 2], &mut out);
        assert_eq!(out.len(), 5);
        out.clear();
        triangulate(&[Vec3::ZERO], &[0; 2000], &mut out);
        assert_eq!(out.len(), 1998);
        out.clear();
        triangulate(&[Vec3::ZERO], &[0; 2], &mut out);
        assert_eq!(out.len(), 0);
    }
}
