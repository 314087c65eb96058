//! What an OBJ line must look like before the parser sees it: numbers that parse, indices that can exist.

use std::collections::BTreeMap;

use super::error::quoted;
use super::lines::{Fault, LineCheck};

/// Largest index that is taken seriously. It keeps the parser's index arithmetic from overflowing.
const LARGEST_INDEX: u64 = 1 << 30;

const NUMBERS: &str = "write plain numbers such as 0.25 or 1e-3";
const RE_EXPORT: &str = "export the mesh again";

/// The three lists that a face points into.
pub(super) const LISTS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

bitflags::bitflags! {
    /// What all corners of a face have.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct FaceHas: u8 {
        /// Indices of texture coordinates.
        const TEXTURE_COORDINATES = 1;
        /// Indices of normals.
        const NORMALS = 2;
    }
}

/// What has been seen of an OBJ file.
#[derive(Debug, Default)]
pub(super) struct ObjCheck {
    /// Vertices, texture coordinates and normals so far.
    pub(super) counts: [u64; 3],
    /// Faces of at least three corners so far.
    pub(super) faces: u64,
    /// Points and lines that were left out.
    pub(super) points_and_lines: u64,
    /// Vertices that are not finite, and the line of the first.
    pub(super) non_finite: (u64, u64),
    /// Lines with statements that are not OBJ, and the first of them.
    pub(super) unknown: (u64, u64),
    /// Curves, surfaces and the like, which are left out.
    pub(super) free_form: (u64, u64),
    /// For each face what it has: the parser makes up what is missing.
    pub(super) face_has: Vec<FaceHas>,
    /// Materials that are used, with the line of their first use.
    pub(super) materials: BTreeMap<String, u64>,
    /// For each list: faces that pointed past the end of what was there, as (line, index), each farther than the one
    /// before. Legal if the list grows that long later.
    pending: [Vec<(u64, u64)>; 3],
}

impl LineCheck for ObjCheck {
    fn check(&mut self, number: u64, line: &mut String) -> Result<(), Fault> {
        if matches!(line.trim_ascii_start().as_bytes(), [b'v' | b'f', ..])
            && let Some(comment) = line.find('#')
        {
            line.truncate(comment);
        }
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else {
            line.clear();
            return Ok(());
        };
        let rewritten = match keyword {
            "v" => self.vertex(number, words)?,
            "vt" => self.texture(words)?,
            "vn" => self.normal(words)?,
            "f" => self.face(number, words)?,
            "usemtl" => {
                let name = line.trim().split_once(char::is_whitespace).map_or("", |(_, name)| name.trim());
                if name.is_empty() {
                    return Err(Fault::new("usemtl without a name", RE_EXPORT));
                }
                if !self.materials.contains_key(name) {
                    self.materials.insert(name.to_owned(), number);
                }
                Some(format!("usemtl {name}"))
            }
            "mtllib" => Some(format!("mtllib {}", line.trim()["mtllib".len()..].trim())),
            "o" | "g" => None,
            "p" | "l" => {
                self.points_and_lines += 1;
                Some(String::new())
            }
            "s" | "mg" | "usemap" | "maplib" | "bevel" | "c_interp" | "d_interp" | "lod" | "shadow_obj"
            | "trace_obj" => Some(String::new()),
            "vp" | "cstype" | "deg" | "bmat" | "step" | "curv" | "curv2" | "surf" | "parm" | "trim" | "hole"
            | "scrv" | "sp" | "end" | "con" | "ctech" | "stech" => {
                count(&mut self.free_form, number);
                Some(String::new())
            }
            _ => {
                if !keyword.starts_with('#') {
                    count(&mut self.unknown, number);
                }
                Some(String::new())
            }
        };
        if let Some(rewritten) = rewritten {
            *line = rewritten;
        }
        Ok(())
    }
}

/// Counts an event and remembers the line of the first.
fn count(event: &mut (u64, u64), line: u64) {
    if event.0 == 0 {
        event.1 = line;
    }
    event.0 += 1;
}

fn number(word: &str, what: &str) -> Result<f32, Fault> {
    word.parse().map_err(|_| Fault::new(format!("{what} {} is not a number", quoted(word)), NUMBERS))
}

impl ObjCheck {
    /// `v x y z [w | r g b ...]`. Colours are left out.
    fn vertex<'a>(&mut self, line: u64, words: impl Iterator<Item = &'a str>) -> Result<Option<String>, Fault> {
        let mut xyz = [""; 3];
        let mut w = "";
        let mut seen = 0;
        let mut finite = true;
        for word in words {
            if seen < 3 {
                finite &= number(word, "coordinate")?.is_finite();
                xyz[seen] = word;
            } else if seen == 3 {
                w = word;
            }
            seen += 1;
        }
        if seen < 3 {
            return Err(Fault::new(format!("a vertex with {seen} of 3 coordinates"), "write v x y z"));
        }
        if seen == 4 && number(w, "weight")? == 0.0 {
            return Err(Fault::new("a vertex of weight 0", "leave the fourth number out"));
        }
        self.counts[0] += 1;
        if !finite {
            count(&mut self.non_finite, line);
        }
        let [x, y, z] = xyz;
        Ok((seen > 4).then(|| format!("v {x} {y} {z}")))
    }

    /// `vt u [v [w]]`.
    fn texture<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<Option<String>, Fault> {
        let mut seen = 0;
        let mut first = "";
        for word in words.take(2) {
            number(word, "texture coordinate")?;
            if seen == 0 {
                first = word;
            }
            seen += 1;
        }
        if seen == 0 {
            return Err(Fault::new("a texture coordinate without numbers", "write vt u v"));
        }
        self.counts[1] += 1;
        Ok((seen == 1).then(|| format!("vt {first} 0")))
    }

    /// `vn x y z`.
    fn normal<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<Option<String>, Fault> {
        let mut seen = 0;
        for word in words.take(3) {
            number(word, "normal")?;
            seen += 1;
        }
        if seen < 3 {
            return Err(Fault::new(format!("a normal with {seen} of 3 components"), "write vn x y z"));
        }
        self.counts[2] += 1;
        Ok(None)
    }

    /// `f v v v ...`, each `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn face<'a>(&mut self, line: u64, words: impl Iterator<Item = &'a str>) -> Result<Option<String>, Fault> {
        let mut corners = 0;
        let mut has = FaceHas::all();
        for word in words {
            let mut given = FaceHas::empty();
            for (list, field) in word.split('/').enumerate() {
                if list >= 3 {
                    return Err(Fault::new(
                        format!("face corner {} has more than 3 indices", quoted(word)),
                        "write v/vt/vn",
                    ));
                }
                if !field.is_empty() {
                    self.index(line, list, field)?;
                    given |= [FaceHas::empty(), FaceHas::TEXTURE_COORDINATES, FaceHas::NORMALS][list];
                } else if list == 0 {
                    return Err(Fault::new(
                        format!("face corner {} has no vertex index", quoted(word)),
                        "write v/vt/vn",
                    ));
                }
            }
            has &= given;
            corners += 1;
        }
        if corners == 0 {
            return Err(Fault::new("a face without corners", "remove the line or export the mesh again"));
        }
        if corners < 3 {
            self.points_and_lines += 1;
            return Ok(Some(String::new()));
        }
        self.faces += 1;
        self.face_has.push(has);
        Ok(None)
    }

    fn index(&mut self, line: u64, list: usize, field: &str) -> Result<(), Fault> {
        let (name, count) = (LISTS[list], self.counts[list]);
        let huge = || {
            Fault::new(
                format!("{name} index {} is out of range: {count} are defined before it", quoted(field)),
                RE_EXPORT,
            )
        };
        let index: i64 = field.parse().map_err(|_| {
            let digits = field.trim_start_matches(['-', '+']);
            if !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) {
                huge()
            } else {
                Fault::new(format!("{name} index {} is not a whole number", quoted(field)), RE_EXPORT)
            }
        })?;
        match index {
            0 => Err(Fault::new(format!("{name} index 0; indices start at 1"), "add 1 to every index of the file")),
            ..0 if index.unsigned_abs() > count => Err(huge()),
            ..0 => Ok(()),
            _ if index as u64 > LARGEST_INDEX => Err(huge()),
            _ => {
                let index = index as u64;
                if index > count && self.pending[list].last().is_none_or(|&(_, farthest)| index > farthest) {
                    self.pending[list].push((line, index));
                }
                Ok(())
            }
        }
    }

    /// The first face that points past the end of a list as it now is: its line and what is wrong.
    pub(super) fn dangling(&self) -> Option<(u64, Fault)> {
        let first = |list: usize| {
            let count = self.counts[list];
            let &(line, index) = self.pending[list].iter().find(|(_, index)| *index > count)?;
            let problem = format!("{} index {index} is out of range: {count} are defined", LISTS[list]);
            Some((line, Fault::new(problem, RE_EXPORT)))
        };
        (0..3).filter_map(first).min_by_key(|(line, _)| *line)
    }
}
