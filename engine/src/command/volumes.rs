//! What people are told of volumes: places, values, a histogram.

use mobula::load::printable;
use mobula::volume::{Grid, Statistics, Volume};
use serde_json::{Value, json};

use super::histogram::{self, short};

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
    lines.extend(histogram::lines(&found));
    lines
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
