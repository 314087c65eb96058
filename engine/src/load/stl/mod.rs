//! STL: triangles as text or binary; what is equal of their corners is shared.
//!
//! Binary files often start with `solid`, as those of text do, so the first word does not tell them apart: the length does, which follows
//! from the number of triangles in a binary file, and where it is not known (packed, from a pipe) whether the start holds bytes that no
//! text has.
//!
//! | file | idea |
//! |---|---|
//! | `text` | text: statements about facets |
//! | `binary` | binary: 50 bytes a triangle, some of which programs use for colours |
//! | `facets` | what was read: triangles that share corners |

mod binary;
mod facets;
mod text;

use std::path::Path;

use facets::Facets;

use super::input::{self, Input};
use super::loaded::{Loaded, Report, display_name};
use super::place::Place;
use super::{LoadError, Options};
use crate::geometry::Geometry;
use crate::scene::SceneDescription;

/// Loads an STL file.
pub(super) fn load(file: &Path, mut input: Input, options: &Options) -> Result<Loaded, LoadError> {
    let (gzip, length) = (input.gzip, input.length);
    let unreadable = |error: &std::io::Error| {
        let (problem, remedy) = input::explain(error, gzip);
        LoadError::new(file, problem, remedy)
    };
    let start = input.start().map_err(|error| unreadable(&error))?;
    if start.is_empty() {
        return Err(LoadError::new(file, "the file is empty", "name a file with a mesh in it"));
    }
    let mut facets = Facets::default();
    let warning = if is_text(start, length) {
        text::read(&mut *input.reader, &mut facets).map_err(|(line, stop)| stop.into_error(file, line, gzip))?
    } else {
        let read = binary::read(&mut *input.reader, length, &mut facets);
        read.map_err(|stop| LoadError { line: None, ..stop.into_error(file, 0, gzip) })?;
        None
    };
    let mut warnings: Vec<String> = warning.map(|text| format!("{}: {text}", file.display())).into_iter().collect();
    // To its end, which says whether packed data is whole.
    if input::drain(&mut *input.reader).map_err(|error| unreadable(&error))? && warnings.is_empty() {
        warnings.push(format!("{}: what is behind the last triangle is left out", file.display()));
    }
    warnings.extend(input.warning(file));
    if facets.triangles.is_empty() {
        return Err(LoadError::new(file, "there is no triangle in it", "export it as a triangle mesh"));
    }
    let corners = facets.triangles.as_flattened();
    let place = Place::choose(options.place, file, &facets.positions, corners, &mut warnings);
    let mesh = facets.into_mesh(display_name(file), &place);
    let mut scene = SceneDescription { name: display_name(file), ..SceneDescription::default() };
    let report = Report { format: if gzip { "STL, gzip" } else { "STL" }, census: mesh.census(), warnings };
    scene.add(mesh);
    Ok(Loaded { scene, report, place })
}

/// Does the start of a file look like STL?
pub(super) fn looks_like(start: &[u8]) -> bool {
    is_text(start, None) || binary::looks_like(start)
}

/// Is a file of such a start, and of such a length where that is known, text?
fn is_text(start: &[u8], length: Option<u64>) -> bool {
    if length.is_some() && length == binary::length(start) {
        return false;
    }
    // Zeros behind a text are padding.
    let end = start.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    let text = start[..end].strip_prefix(b"\xef\xbb\xbf").unwrap_or(&start[..end]);
    let control = |byte: &u8| byte.is_ascii_control() && !byte.is_ascii_whitespace();
    let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    words.next().is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && !text.iter().any(control)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_word_decides_nothing() {
        let text = b"solid part\nfacet normal 0 0 1\n";
        let header = |name: &str, count: u32| [format!("{name:<80}").as_bytes(), &count.to_le_bytes()].concat();
        for (start, length, expected) in [
            (&text[..], None, true),
            (b"\xef\xbb\xbf\n SOLID caf\xe9\n\0\0", Some(20), true),
            (b"solidify", None, false),
            (b"facet normal 0 0 1", None, false),
            // By its length, also where all bytes are those of text; by its bytes where no length is known.
            (&header("solid made by a program", 1), Some(134), false),
            (&header("solid made by a program", 0x2020_2020), Some(84 + 50 * 0x2020_2020), false),
            (&header("solid made by a program", 1), None, false),
            (&header("solid made by a program", 0x2020_2020), None, true),
        ] {
            assert_eq!(is_text(start, length), expected, "{:?} {length:?}", String::from_utf8_lossy(start));
        }
    }
}
