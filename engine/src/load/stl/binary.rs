//! Binary STL: a header that says nothing, the number of triangles, and of each a normal, three corners, and two bytes that were meant for
//! something else once and that programs use for colours:
//!
//! - VisCAM and SolidView: the highest bit says that there is a colour, of 5 bits each of red, green and blue, blue the lowest.
//! - Magics by Materialise: the header says `COLOR=` and a colour for all, as bytes; a triangle without the highest bit has its own, red
//!   the lowest. Programs that know only the header leave zeros there, which are taken for none, not for black.

use std::io::BufRead;

use super::facets::{COLORED, Facets};
use crate::load::VoxelType;
use crate::load::binary::{decode, fill};
use crate::load::lines::{Fault, Stop};
use crate::load::text::counted;

/// Bytes of the header with the number of triangles behind it.
const HEAD: usize = 84;
/// Bytes of a triangle.
const EACH: usize = 50;
const TRUNCATED: &str = "the file is truncated, or its count wrong";

/// Reads all triangles.
pub(super) fn read(reader: &mut dyn BufRead, length: Option<u64>, facets: &mut Facets) -> Result<(), Stop> {
    let mut head = [0; HEAD];
    let bytes = fill(reader, &mut head).map_err(Stop::Io)?;
    let count = count(&head[..bytes]);
    let needed = count.map(length_of);
    let is_short = length.is_some_and(|length| needed > Some(length));
    // What is text has no number of triangles.
    let is_text = head.iter().all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace());
    let (Some(count), Some(needed), false) = (count, needed, is_short && is_text) else {
        let problem =
            format!("neither text that starts with `solid`, nor the {HEAD} bytes that binary STL starts with");
        return Err(Fault::new(problem, "check that it is what its name says").into());
    };
    if let Some(length) = length {
        if is_short {
            let what = counted(count.into(), "triangle");
            let problem = format!("{what} need {needed} bytes, but there are only {length}");
            return Err(Fault::new(problem, TRUNCATED).into());
        }
        // There are as many as it says.
        facets.triangles.reserve(count as usize);
    }
    let colors = Colors::of(&head);
    facets.color = colors.all.unwrap_or(facets.color);
    let mut bytes = [0; EACH];
    for number in 0..count {
        if fill(reader, &mut bytes).map_err(Stop::Io)? < EACH {
            let problem = format!("the file ends after {number} of {}", counted(count.into(), "triangle"));
            return Err(Fault::new(problem, TRUNCATED).into());
        }
        let attribute = u16::from_le_bytes([bytes[EACH - 2], bytes[EACH - 1]]);
        let [_, corners @ ..] = numbers(&bytes).map(|point| point.map(f64::from));
        facets.add(corners, colors.of_triangle(attribute))?;
    }
    Ok(())
}

/// How long a binary file of such a start is.
pub(super) fn length(start: &[u8]) -> Option<u64> {
    count(start).map(length_of)
}

/// Are the first triangles such as nothing else would have: with normals of length 1, or 0 where none was computed?
pub(super) fn looks_like(start: &[u8]) -> bool {
    let Some(count) = count(start) else { return false };
    let (all, _) = start[HEAD..].as_chunks::<EACH>();
    let likely = |bytes: &[u8; EACH]| {
        let [normal, a, b, c] = numbers(bytes);
        let square: f32 = normal.iter().map(|x| x * x).sum();
        let plausible = |x: &f32| x.is_finite() && (*x == 0.0 || (1e-12..1e12).contains(&x.abs()));
        (square == 0.0 || (square - 1.0).abs() < 1e-3) && [a, b, c].as_flattened().iter().all(plausible) && a != b
    };
    let mut some = all.iter().take(count as usize).peekable();
    some.peek().is_some() && some.all(likely)
}

fn count(start: &[u8]) -> Option<u32> {
    Some(u32::from_le_bytes(*start.get(HEAD - 4..HEAD)?.first_chunk()?))
}

fn length_of(count: u32) -> u64 {
    HEAD as u64 + u64::from(count) * EACH as u64
}

/// The normal and the three corners of a triangle.
fn numbers(bytes: &[u8; EACH]) -> [[f32; 3]; 4] {
    let at = |number: usize| decode(VoxelType::F32, false, &bytes[4 * number..]) as f32;
    [0, 1, 2, 3].map(|point| [0, 1, 2].map(|k| at(3 * point + k)))
}

/// What attributes mean.
struct Colors {
    /// The colour for all, from 0 to 1, if the header has one: then attributes are those of Magics.
    all: Option<[f64; 3]>,
}

impl Colors {
    fn of(head: &[u8; HEAD]) -> Self {
        const KEY: &[u8] = b"COLOR=";
        let header = &head[..HEAD - 4];
        let key = header.windows(KEY.len() + 4).find(|bytes| bytes.starts_with(KEY));
        Self { all: key.map(|bytes| [0, 1, 2].map(|k| f64::from(bytes[KEY.len() + k]) / 255.0)) }
    }

    /// The colour of a triangle, as [`COLORED`] has it.
    fn of_triangle(&self, attribute: u16) -> u16 {
        let own = attribute & !COLORED;
        match self.all {
            None if attribute & COLORED == 0 => 0,
            None => attribute,
            Some(_) if attribute & COLORED != 0 || own == 0 => 0,
            Some(_) => COLORED | (own & 31) << 10 | (own & 31 << 5) | own >> 10,
        }
    }
}
