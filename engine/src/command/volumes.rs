//! What people are told of volumes: places, values, a histogram; and what they tell of files of nothing but voxels.

use clap::Args;
use mobula::load::{Raw, VoxelType, printable};
use mobula::volume::{Grid, Statistics, Volume};
use serde_json::{Value, json};

use super::scene::grouped;

/// Rows of a histogram.
const ROWS: usize = 4;
/// What stands for each eighth of a character's height.
const BLOCKS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// What a file of nothing but voxels does not say.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct RawOptions {
    /// Samples along each side of a file of nothing but voxels, the fastest first; a fourth number: steps of time
    #[arg(long, value_name = "X,Y,Z[,T]", requires = "raw_type", value_parser = dims)]
    pub(crate) raw_dims: Option<Dims>,

    /// Type of these voxels: u8, i8, u16, i16, u32, i32, f32 or f64; with `be` behind it the most significant byte is first
    #[arg(long, value_name = "TYPE[be|le]", requires = "raw_dims", value_parser = voxel_type)]
    pub(crate) raw_type: Option<RawType>,

    /// Distances between these voxels [default: 1,1,1]
    #[arg(long, value_name = "X,Y,Z", requires = "raw_dims", value_parser = spacing)]
    pub(crate) raw_spacing: Option<Spacing>,
}

/// Samples along each side, and steps of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dims([u64; 3], u64);

/// The type of voxels, and whether their most significant byte is first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RawType(VoxelType, bool);

/// Distances between voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spacing([f64; 3]);

impl RawOptions {
    /// What they say of files.
    pub(crate) fn raw(&self) -> Option<Raw> {
        let (Dims(dims, steps), RawType(kind, big_endian)) = (self.raw_dims?, self.raw_type?);
        Some(Raw { dims, steps, kind, big_endian, spacing: self.raw_spacing.map_or([1.0; 3], |spacing| spacing.0) })
    }

    /// The options as names and values.
    #[cfg(feature = "window")]
    pub(crate) fn words(&self) -> [(&'static str, Option<String>); 3] {
        let dims = self.raw_dims.map(|Dims([x, y, z], steps)| format!("{x},{y},{z},{steps}"));
        let kind = self.raw_type.map(|RawType(kind, big)| format!("{kind}{}", if big { "be" } else { "le" }));
        let spacing = self.raw_spacing.map(|Spacing([x, y, z])| format!("{x},{y},{z}"));
        [("raw-dims", dims), ("raw-type", kind), ("raw-spacing", spacing)]
    }
}

fn dims(text: &str) -> Result<Dims, String> {
    let numbers: Option<Vec<u64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if x > 0 && y > 0 && z > 0 => Ok(Dims([x, y, z], 1)),
        Some(&[x, y, z, steps]) if x > 0 && y > 0 && z > 0 && steps > 0 => Ok(Dims([x, y, z], steps)),
        _ => Err("write three whole numbers above 0 with commas between them, such as 256,256,100".into()),
    }
}

fn voxel_type(text: &str) -> Result<RawType, String> {
    let lower = text.to_ascii_lowercase();
    let little = || lower.strip_suffix("le").unwrap_or(&lower);
    let (name, big) = lower.strip_suffix("be").map_or_else(|| (little(), false), |name| (name, true));
    let kind = name.parse().map_err(|error: mobula::load::NoVoxelType| error.to_string());
    kind.map(|kind| RawType(kind, big))
}

fn spacing(text: &str) -> Result<Spacing, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().all(|x| x.is_finite() && *x > 0.0) => Ok(Spacing([x, y, z])),
        _ => Err("write three numbers above 0 with commas between them, such as 0.5,0.5,1.25".into()),
    }
}

/// What programs are told of a volume.
pub(crate) fn object(volume: &Volume) -> Value {
    let found = Statistics::of(volume);
    let Some(grid) = volume.steps.first() else { return json!({}) };
    let place = grid.place();
    json!({
        "volume": volume.name,
        "dimensions": grid.dims(),
        "type": grid.voxels().type_name(),
        "spacing": place.spacing(),
        "origin": place.origin.to_array(),
        "axes": place.axes.map(|axis| axis.to_array()),
        "steps": volume.steps.len(),
        "range": found.range,
        "mean": found.mean,
        "histogram": found.histogram.as_slice(),
        "not_numbers": found.not_numbers,
        "infinite": found.infinite,
    })
}

/// What people are told of a volume: names and values, a line each.
pub(crate) fn lines(volume: &Volume) -> Vec<(&'static str, String)> {
    let found = Statistics::of(volume);
    let Some(grid) = volume.steps.first() else { return Vec::new() };
    let [x, y, z] = grid.dims();
    let mut lines = vec![
        ("volume", printable(&volume.name).into_owned()),
        ("  dimensions", format!("{x} x {y} x {z}")),
        ("  type", grid.voxels().type_name().to_owned()),
    ];
    lines.extend(place(grid));
    lines.push(("  steps of time", volume.steps.len().to_string()));
    let [slope, intercept] = grid.scale();
    if [slope, intercept] != [1.0, 0.0] {
        lines.push(("  values", format!("voxels times {slope}, plus {intercept}")));
    }
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
    lines.extend(histogram(&found).into_iter().zip(["  histogram"].into_iter().chain(std::iter::repeat(""))).map(swap));
    lines
}

fn swap((text, name): (String, &'static str)) -> (&'static str, String) {
    (name, text)
}

/// Where samples are.
fn place(grid: &Grid) -> Vec<(&'static str, String)> {
    let place = grid.place();
    let [x, y, z] = place.spacing().map(short);
    let point = |v: [f64; 3]| format!("({})", v.map(short).join(", "));
    let mut lines = vec![("  spacing", format!("{x} x {y} x {z}")), ("  origin", point(place.origin.to_array()))];
    let straight = (0..3).all(|k| (0..3).all(|i| i == k || place.axes[k][i] == 0.0) && place.axes[k][k] > 0.0);
    if !straight {
        let axes = place.axes.map(|axis| point(axis.normalize_or_zero().to_array()));
        lines.push(("  directions", axes.join(" ")));
    }
    lines
}

/// A number in at most six digits or so.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    let exponent = rounded.abs().log10();
    if rounded == 0.0 || (-5.0..9.0).contains(&exponent) {
        format!("{}", rounded + 0.0)
    } else {
        format!("{rounded:e}")
    }
}

/// A histogram of text: as many columns as parts, heights that grow with the logarithm of the counts, and the range below.
fn histogram(found: &Statistics) -> Vec<String> {
    let Some([low, high]) = found.range else { return Vec::new() };
    let most = found.histogram.iter().copied().max().unwrap_or(0);
    let height = |count: u64| {
        let eighths = (8 * ROWS) as f64;
        // One voxel shows.
        let share = (count as f64).ln_1p() / (most as f64).ln_1p();
        if count == 0 { 0 } else { ((share * eighths).round() as usize).clamp(1, 8 * ROWS) }
    };
    let row = |row: usize| {
        let block = |&count: &u64| BLOCKS[height(count).saturating_sub(8 * (ROWS - 1 - row)).min(8)];
        found.histogram.iter().map(block).collect::<String>().trim_end().to_owned()
    };
    let (low, high) = (short(low), short(high));
    let between = found.histogram.len().saturating_sub(low.len() + high.len()).max(1);
    let caption = format!("counts on a logarithmic scale; the highest is {}", grouped(most));
    (0..ROWS).map(row).chain([format!("{low}{}{high}", " ".repeat(between)), caption]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_options_are_checked() {
        assert_eq!(dims("2, 3,4"), Ok(Dims([2, 3, 4], 1)));
        assert_eq!(dims("2,3,4,5"), Ok(Dims([2, 3, 4], 5)));
        for bad in ["", "1,2", "0,1,1", "1,2,3,0", "1,2,3,4,5", "1,2,x", "-1,2,3", "99999999999999999999,1,1"] {
            assert!(dims(bad).is_err(), "{bad}");
        }
        assert_eq!(voxel_type("u16"), Ok(RawType(VoxelType::U16, false)));
        assert_eq!(voxel_type("F32le"), Ok(RawType(VoxelType::F32, false)));
        assert_eq!(voxel_type("i32be"), Ok(RawType(VoxelType::I32, true)));
        for bad in ["", "be", "u64", "u16bele", "short"] {
            assert!(voxel_type(bad).unwrap_err().contains("u8, i8, u16"), "{bad}");
        }
        assert_eq!(spacing("0.5,1,2"), Ok(Spacing([0.5, 1.0, 2.0])));
        for bad in ["", "1,1", "1,0,1", "1,nan,1", "1,-1,1", "1,inf,1"] {
            assert!(spacing(bad).is_err(), "{bad}");
        }
    }

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
        let lines = super::histogram(&found);
        assert_eq!(lines.len(), ROWS + 2);
        assert_eq!(lines[0], "█");
        assert_eq!(lines[ROWS - 1], format!("█▂{}█", " ".repeat(61)));
        assert_eq!(lines[ROWS], format!("-1.5{}300", " ".repeat(57)));
        assert!(lines[ROWS + 1].ends_with("the highest is 1,000,000"));
        assert!(lines.iter().all(|line| line.chars().count() <= 64), "{lines:?}");
    }
}
