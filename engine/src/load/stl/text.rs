//! STL as text: `solid`s of facets, each with a normal and a loop of three vertices. Line breaks mean as much as blanks, except behind a
//! solid's name and between the numbers of a vertex. Normals are left out: what a facet's corners say is more exact.

use std::io::BufRead;
use std::str::SplitAsciiWhitespace;

use super::facets::Facets;
use crate::load::lines::{Fault, Lines, Stop};
use crate::load::text::{number, quoted};

const WRITTEN: &str = "check how it was written";
const TRUNCATED: &str = "the file is truncated: fetch it again";

/// Reads a text; returns what people should know of it, or the line that is wrong.
pub(super) fn read(reader: &mut dyn BufRead, facets: &mut Facets) -> Result<Option<String>, (u64, Stop)> {
    let mut lines = Lines::new(reader);
    let mut statements = Statements { facets, within: Within::Nothing, corners: Vec::with_capacity(3) };
    loop {
        let line = match lines.next(|_| false) {
            Ok(Some((_, line))) => line,
            Ok(None) => break,
            Err(stop) => return Err((lines.number, stop)),
        };
        let more = statements.read(line);
        if !more.map_err(|fault| (lines.number, fault.into()))? {
            return Ok(Some(format!("what is behind the last solid, from line {} on, is left out", lines.number)));
        }
    }
    match statements.within {
        Within::Facet => Err((lines.number, Fault::new("the file ends within a facet", TRUNCATED).into())),
        Within::Solid => Ok(Some("the last solid has no end: the file may be truncated".to_owned())),
        Within::Nothing => Ok(None),
    }
}

/// What statements are read in.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Within {
    Nothing,
    Solid,
    Facet,
}

struct Statements<'a> {
    facets: &'a mut Facets,
    within: Within,
    /// Those of the facet that is read.
    corners: Vec<[f64; 3]>,
}

impl Statements<'_> {
    /// Reads a line; false: it is behind the last solid, and no part of the file.
    fn read(&mut self, line: &str) -> Result<bool, Fault> {
        let mut words = line.split_ascii_whitespace();
        while let Some(word) = words.next() {
            let is = |known: &str| word.eq_ignore_ascii_case(known);
            match self.within {
                Within::Nothing if is("solid") => {
                    self.facets.begin(line.trim_start()["solid".len()..].trim());
                    self.within = Within::Solid;
                    return Ok(true);
                }
                Within::Nothing => return Ok(false),
                Within::Facet if is("vertex") => self.vertex(&mut words)?,
                Within::Facet if is("endloop") || is("outer") || is("loop") => {}
                Within::Facet if is("endfacet") => {
                    let Ok(corners) = <[[f64; 3]; 3]>::try_from(&self.corners[..]) else {
                        let problem = format!("a facet of {} instead of 3 vertices", self.corners.len());
                        return Err(Fault::new(problem, "export it as triangles"));
                    };
                    self.facets.add(corners, 0)?;
                    self.corners.clear();
                    self.within = Within::Solid;
                }
                Within::Solid if is("facet") => {
                    // Whatever stands for a normal of no length is no concern of ours.
                    if words.next().is_none_or(|word| !word.eq_ignore_ascii_case("normal")) || words.nth(2).is_none() {
                        return Err(Fault::new("a facet without a normal", WRITTEN));
                    }
                    self.within = Within::Facet;
                }
                Within::Solid if is("endsolid") => {
                    self.within = Within::Nothing;
                    return Ok(true);
                }
                Within::Solid => return Err(unexpected(word, "facet or endsolid")),
                Within::Facet => return Err(unexpected(word, "vertex or endfacet")),
            }
        }
        Ok(true)
    }

    fn vertex(&mut self, words: &mut SplitAsciiWhitespace<'_>) -> Result<(), Fault> {
        let mut corner = [0.0; 3];
        for (have, x) in corner.iter_mut().enumerate() {
            let word =
                words.next().ok_or_else(|| Fault::new(format!("a vertex with {have} of 3 coordinates"), WRITTEN))?;
            let not = || Fault::new(format!("coordinate {} is not a number", quoted(word)), "write it as 0.25 or 1e-3");
            *x = number(word).ok_or_else(not)?;
        }
        // Further ones are only counted: a facet may have any number of them.
        if self.corners.len() == 3 {
            return Err(Fault::new("a facet of more than 3 vertices", "export it as triangles"));
        }
        self.corners.push(corner);
        Ok(())
    }
}

fn unexpected(word: &str, expected: &str) -> Fault {
    Fault::new(format!("{} where {expected} is expected", quoted(word)), WRITTEN)
}
