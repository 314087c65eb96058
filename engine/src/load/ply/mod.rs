//! PLY: text and binary of either byte order. With faces it is a mesh, else its vertices are particles.
//!
//! The reader is our own: what elements have is known only when their header was read, errors name lines, and rows are read as columns.
//!
//! | file | idea |
//! |---|---|
//! | `points` | vertices that are particles |
//! | `mesh` | vertices and faces that are a mesh |
//! | `rows` | the rows of elements |
//! | `header` | what elements there are, and what each has |

mod header;
mod mesh;
mod points;
mod rows;

use std::path::Path;

use header::{Element, Header};
use rows::Rows;

use super::input::{self, Input};
use super::loaded::Loaded;
use super::{LoadError, Options};

/// Loads a PLY file.
pub(super) fn load(file: &Path, mut input: Input, options: &Options) -> Result<Loaded, LoadError> {
    let (gzip, length) = (input.gzip, input.length);
    let header = Header::read(&mut input.reader).map_err(|(line, stop)| stop.into_error(file, line, gzip))?;
    let is = |element: &&Element, name: &str| element.name == name && element.count > 0;
    let all = || header.elements.iter();
    let strips = all().find(|element| is(element, "tristrips"));
    let faces = all().any(|element| is(&element, "face"));
    if let (Some(strips), false) = (strips, faces) {
        let problem = "its triangles are in strips, which Mobula cannot load";
        return Err(LoadError::new(file, problem, "export it with faces").at(strips.line));
    }
    let left = length.map(|length| length.saturating_sub(header.bytes));
    let rows = Rows::new(file, &mut *input.reader, &header, gzip, left)?;
    let load = if faces { mesh::load } else { points::load };
    let mut loaded = load(rows, &header, options)?;
    loaded.report.format = if gzip { "PLY, gzip" } else { "PLY" };
    let behind = input::drain(&mut *input.reader).map_err(|error| {
        let (problem, remedy) = input::explain(&error, gzip);
        LoadError::new(file, problem, remedy)
    })?;
    // Elements behind those that are looked at may be there.
    let last = if faces { "face" } else { "vertex" };
    if behind && header.elements.last().is_some_and(|element| element.name == last) {
        loaded.report.warnings.push(format!("{}: what is behind the last row is left out", file.display()));
    }
    // What follows gzip data is known once all is read.
    loaded.report.warnings.extend(input.warning(file));
    Ok(loaded)
}

/// Does the start of a file look like PLY?
pub(super) fn looks_like(start: &[u8]) -> bool {
    start.starts_with(b"ply\n") || start.starts_with(b"ply\r")
}
