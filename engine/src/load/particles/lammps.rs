//! Text dumps of LAMMPS: any number of steps, each with its box and the columns of its atoms.

use std::io::BufRead;
use std::path::Path;

use super::frames::{self, Frame, Frames, TextLines};
use super::periodic::{self, Cell};
use super::rows::Rows;
use crate::load::input::Input;
use crate::load::lines::{Fault, Lines, Stop};
use crate::load::loaded::Loaded;
use crate::load::text::{number, quoted};
use crate::load::{LoadError, Options};

const WRITTEN: &str = "check how it was written";

/// Loads a dump.
pub(in crate::load) fn load(file: &Path, input: Input, options: &Options) -> Result<Loaded, LoadError> {
    frames::load(file, input, options, ["LAMMPS dump", "LAMMPS dump, gzip"], read)
}

/// Does the start of a file look like a dump?
pub(in crate::load) fn looks_like(start: &[u8]) -> bool {
    start.trim_ascii_start().starts_with(b"ITEM: ")
}

/// A box: where it starts, and its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bounds {
    low: [f64; 3],
    cell: Cell,
}

fn read(lines: &mut TextLines<'_>, frames: &mut Frames<'_>) -> Result<(), Stop> {
    let (mut count, mut bounds) = (None, None);
    while let Some((number, line)) = lines.next(|_| false)? {
        let line = line.trim();
        if line.is_empty() {
            continue;
        }
        let Some(item) = line.strip_prefix("ITEM:").map(str::trim) else {
            let problem = format!("{} where a line with ITEM: should be", quoted(line));
            let remedy = if number == 1 { "write it with `dump custom`" } else { "the number of atoms may be wrong" };
            return Err(Fault::new(problem, remedy).into());
        };
        if item == "NUMBER OF ATOMS" {
            let line = next(lines)?;
            let not = || Fault::new(format!("{} is no number of atoms", quoted(&line)), WRITTEN);
            count = Some(line.trim().parse::<u64>().map_err(|_| not())?);
        } else if let Some(kind) = item.strip_prefix("BOX BOUNDS") {
            let general = kind.trim_start().starts_with("abc");
            let mut numbers = Vec::new();
            for _ in 0..3 {
                numbers.push(numbers_of(&next(lines)?)?);
            }
            bounds = bounds_of(&numbers, general);
            if bounds.is_none() {
                return Err(Fault::new("the bounds of the box are no box", WRITTEN).into());
            }
        } else if let Some(names) = item.strip_prefix("ATOMS") {
            let names = names.to_owned();
            let Some(count) = count.take() else {
                return Err(Fault::new("nothing says how many atoms there are", WRITTEN).into());
            };
            atoms(lines, frames, &names, count, bounds)?;
        } else {
            // What else there is has one line: TIMESTEP, TIME, UNITS.
            next(lines)?;
        }
    }
    if frames.len() == 0 {
        return Err(Fault::new("there are no atoms in the dump", "write it with `dump custom`").into());
    }
    Ok(())
}

/// The line of an item.
fn next<R: BufRead>(lines: &mut Lines<R>) -> Result<String, Stop> {
    let line = lines.next(|_| false)?.map(|(_, line)| std::mem::take(line));
    line.ok_or_else(|| Fault::new("the dump ends too early", "the file is truncated: fetch it again").into())
}

fn numbers_of(line: &str) -> Result<Vec<f64>, Fault> {
    let not = |word: &str| Fault::new(format!("{} is not a number", quoted(word)), WRITTEN);
    line.split_whitespace().take(5).map(|word| number(word).ok_or_else(|| not(word))).collect()
}

/// The box that three lines give. `general`: each is an edge and a coordinate of the origin; else each is the least and the greatest
/// coordinate, perhaps of a box that leans, with how far it does: xy, xz, yz.
fn bounds_of(lines: &[Vec<f64>], general: bool) -> Option<Bounds> {
    let [x, y, z] = lines else { return None };
    let bounds = match (&x[..], &y[..], &z[..]) {
        (&[a, b, c, x], &[d, e, f, y], &[g, h, i, z]) if general => {
            Bounds { low: [x, y, z], cell: [[a, b, c], [d, e, f], [g, h, i]] }
        }
        (&[x0, x1], &[y0, y1], &[z0, z1]) => {
            Bounds { low: [x0, y0, z0], cell: [[x1 - x0, 0.0, 0.0], [0.0, y1 - y0, 0.0], [0.0, 0.0, z1 - z0]] }
        }
        (&[x0, x1, xy], &[y0, y1, xz], &[z0, z1, yz]) => {
            // The bounds are of all corners.
            let leans = [0.0, xy, xz, xy + xz];
            let x0 = x0 - leans.into_iter().fold(0.0, f64::min);
            let x1 = x1 - leans.into_iter().fold(0.0, f64::max);
            let (y0, y1) = (y0 - yz.min(0.0), y1 - yz.max(0.0));
            Bounds { low: [x0, y0, z0], cell: [[x1 - x0, 0.0, 0.0], [xy, y1 - y0, 0.0], [xz, yz, z1 - z0]] }
        }
        _ => return None,
    };
    let finite = bounds.low.iter().all(|x| x.is_finite()) && bounds.cell.iter().flatten().all(|x| x.is_finite());
    finite.then_some(bounds)
}

/// Reads the atoms of a step.
fn atoms<R: BufRead>(
    lines: &mut Lines<R>,
    frames: &mut Frames<'_>,
    names: &str,
    count: u64,
    bounds: Option<Bounds>,
) -> Result<(), Stop> {
    let names: Vec<&str> = names.split_whitespace().collect();
    let first = if count == 0 { None } else { Some(next(lines)?) };
    let words: Option<Vec<&str>> = first.as_ref().map(|line| line.split_whitespace().collect());
    let mut rows = Rows::new(&names, words.as_deref())?;
    if let Some(words) = words {
        rows.add(words.into_iter())?;
        rows.fill(lines, count)?;
    }
    if frames.len() == 0
        && let Some(warning) = rows.warning()
    {
        frames.warn(&format!(": {warning}"));
    }
    let has = |name: &str| names.contains(&name);
    if !(has("x") || has("xu")) && (has("xs") || has("xsu")) {
        let Some(Bounds { low, cell: [a, b, c] }) = bounds else {
            let problem = "coordinates are in units of the box, but nothing says how large it is";
            return Err(Fault::new(problem, WRITTEN).into());
        };
        rows.columns.map_positions(|[x, y, z]| [0, 1, 2].map(|k| low[k] + x * a[k] + y * b[k] + z * c[k]));
    }
    let cell = bounds.and_then(|bounds| periodic::checked(bounds.cell));
    frames.add(Frame { columns: rows.columns, cell, radii: Vec::new() })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_may_lean() {
        let lines = |text: [&str; 3]| text.map(|line| numbers_of(line).unwrap());
        let straight = bounds_of(&lines(["-1 3", "0 2", "5 6"]), false).unwrap();
        assert_eq!(straight.cell, [[4.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]]);
        let leaning = bounds_of(&lines(["-1 6 2", "0 3 -1", "0 4 1"]), false).unwrap();
        assert_eq!(leaning.low, [0.0, 0.0, 0.0]);
        assert_eq!(leaning.cell, [[4.0, 0.0, 0.0], [2.0, 2.0, 0.0], [-1.0, 1.0, 4.0]]);
        let general = bounds_of(&lines(["1 2 3 7", "4 5 6 8", "0 0 1 9"]), true).unwrap();
        assert_eq!((general.low, general.cell[1]), ([7.0, 8.0, 9.0], [4.0, 5.0, 6.0]));
        for bad in [["0 1", "0 1", "0 inf"], ["0 1", "0 1", "0"], ["0 1 2", "0 1", "0 1"], ["0 1 2 3 4", "0 1", "0 1"]]
        {
            assert_eq!(bounds_of(&lines(bad), false), None, "{bad:?}");
        }
    }
}
