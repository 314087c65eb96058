//! What people are told of values: their range, their mean, and a histogram of text.

use mobula::volume::Statistics;

use super::scene::grouped;

/// Rows of a histogram.
const ROWS: usize = 4;
/// What stands for each eighth of a character's height.
const BLOCKS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// Names and values, a line each.
pub(crate) fn lines(found: &Statistics) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    match (found.range, found.mean) {
        (Some([low, high]), Some(mean)) => {
            lines.push(("  range", format!("{} to {}", short(low), short(high))));
            lines.push(("  mean", short(mean)));
        }
        _ => lines.push(("  range", "no finite value".to_owned())),
    }
    for (name, count) in [("  not numbers", found.not_numbers), ("  infinite", found.infinite)] {
        if count > 0 {
            lines.push((name, grouped(count)));
        }
    }
    let names = ["  histogram"].into_iter().chain(std::iter::repeat(""));
    lines.extend(names.zip(rows(found)));
    lines
}

/// A number in at most six digits or so.
pub(crate) fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    let exponent = rounded.abs().log10();
    if rounded == 0.0 || (-5.0..9.0).contains(&exponent) {
        format!("{}", rounded + 0.0)
    } else {
        format!("{rounded:e}")
    }
}

/// A histogram of text: as many columns as parts, heights that grow with the logarithm of the counts, and the range below.
fn rows(found: &Statistics) -> Vec<String> {
    let Some([low, high]) = found.range else { return Vec::new() };
    let most = found.histogram.iter().copied().max().unwrap_or(0);
    let (low, high) = (short(low), short(high));
    let between = found.histogram.len().saturating_sub(low.len() + high.len()).max(1);
    let caption = format!("counts on a logarithmic scale; the highest is {}", grouped(most));
    let range = format!("{low}{}{high}", " ".repeat(between));
    (0..ROWS).map(|at| drawn(found, ROWS, at)).chain([range, caption]).collect()
}

/// A histogram of a single row.
pub(crate) fn row(found: &Statistics) -> String {
    drawn(found, 1, 0)
}

/// One of the rows of a histogram that has so many.
fn drawn(found: &Statistics, rows: usize, row: usize) -> String {
    let most = found.histogram.iter().copied().max().unwrap_or(0);
    let height = |count: u64| {
        // One value shows.
        let share = (count as f64).ln_1p() / (most as f64).ln_1p();
        if count == 0 { 0 } else { ((share * (8 * rows) as f64).round() as usize).clamp(1, 8 * rows) }
    };
    let block = |&count: &u64| BLOCKS[height(count).saturating_sub(8 * (rows - 1 - row)).min(8)];
    found.histogram.iter().map(block).collect::<String>().trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let numbers = [0.0, -0.0, 0.9570310115814209, 3071.0, -1024.5, 1e-9, 1.234567891e30, 0.00012, -600.123456];
        let texts = numbers.map(short);
        assert_eq!(texts, ["0", "0", "0.957031", "3071", "-1024.5", "1e-9", "1.23457e30", "0.00012", "-600.123"]);
    }

    #[test]
    fn histograms_are_drawn() {
        let mut histogram = [0; 64];
        (histogram[0], histogram[1], histogram[63]) = (1_000_000, 1, 1_000);
        let found = Statistics { range: Some([-1.5, 300.0]), mean: None, histogram, not_numbers: 0, infinite: 0 };
        assert_eq!(row(&found), format!("█▁{}▄", " ".repeat(61)));
        let lines = rows(&found);
        assert_eq!(lines.len(), ROWS + 2);
        assert_eq!(lines[0], "█");
        assert_eq!(lines[ROWS - 1], format!("█▂{}█", " ".repeat(61)));
        assert_eq!(lines[ROWS], format!("-1.5{}300", " ".repeat(57)));
        assert!(lines[ROWS + 1].ends_with("the highest is 1,000,000"));
        assert!(lines.iter().all(|line| line.chars().count() <= 64), "{lines:?}");
    }
}
