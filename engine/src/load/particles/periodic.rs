//! The periodic box, as comments give it: `box 110 A`, `box 10 20 30`, or nine numbers for three edges.

use crate::load::text::number;

/// Three edges.
pub(in crate::load) type Cell = [[f64; 3]; 3];

/// The box that a comment gives; `None`: it says something else, or nothing that could be a box.
pub(in crate::load) fn of_comment(comment: &str) -> Option<Cell> {
    let mut words = comment.split(|c: char| c.is_whitespace() || c == ',' || c == '=').filter(|word| !word.is_empty());
    let first = words.next()?.trim_end_matches(':').to_ascii_lowercase();
    if !["box", "cell", "lattice"].contains(&&*first) {
        return None;
    }
    let numbers: Vec<f64> = words.map_while(number).take(10).collect();
    of_numbers(&numbers)
}

/// The box that numbers give: a side, three sides, or three edges.
pub(super) fn of_numbers(numbers: &[f64]) -> Option<Cell> {
    let straight = |x: f64, y: f64, z: f64| [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
    let cell = match *numbers {
        [side] => straight(side, side, side),
        [x, y, z] => straight(x, y, z),
        [a, b, c, d, e, f, g, h, i] => [[a, b, c], [d, e, f], [g, h, i]],
        _ => return None,
    };
    checked(cell)
}

/// Edges that are finite, and none of which is zero.
pub(super) fn checked(cell: Cell) -> Option<Cell> {
    let sound = |edge: &[f64; 3]| edge.iter().all(|x| x.is_finite()) && edge.iter().any(|x| *x != 0.0);
    cell.iter().all(sound).then_some(cell)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_give_boxes() {
        let straight = |x: f64, y: f64, z: f64| Some([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]);
        assert_eq!(of_comment("box 110 A"), straight(110.0, 110.0, 110.0));
        assert_eq!(of_comment(" Box: 1, 2.5, 3 nm"), straight(1.0, 2.5, 3.0));
        assert_eq!(of_comment("cell = 1 0 0 5 2 0 0 0 3").unwrap()[1], [5.0, 2.0, 0.0]);
        for none in ["box of 44101 molecules", "box", "", "box 1 2", "box 0", "box nan", "a box 1 2 3", "box 1 inf 2"] {
            assert_eq!(of_comment(none), None, "{none}");
        }
    }
}
