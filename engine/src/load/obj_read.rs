//! The statements of an OBJ file: lists of vertices, and faces that point into them.

use std::collections::HashMap;

use super::lines::{Fault, Lines, Stop};
use super::plain::Plain;
use super::text::{number, quoted};
use crate::geometry::NO_INDEX;

/// Largest index that is taken seriously.
const LARGEST_INDEX: u64 = 1 << 30;

const NUMBERS: &str = "write plain numbers such as 0.25 or 1e-3";
const INDICES: &str = "count the vertices that the file defines, from 1";

/// The three lists that a face points into.
const LISTS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// How often something odd was met, and the line of the first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    pub(super) count: u64,
    pub(super) line: u64,
}

impl Seen {
    pub(super) fn at(&mut self, line: u64) {
        if self.count == 0 {
            self.line = line;
        }
        self.count += 1;
    }

    /// Adds what was met behind so many lines.
    pub(super) fn add(&mut self, later: Self, lines: u64) {
        if self.count == 0 && later.count > 0 {
            self.line = later.line + lines;
        }
        self.count += later.count;
    }
}

/// What an OBJ file says.
#[derive(Debug, Default)]
pub(super) struct Obj {
    pub(super) positions: Vec<[f64; 3]>,
    /// As long as `positions`, or shorter: the rest has no colour.
    pub(super) colors: Vec<[f32; 3]>,
    pub(super) texture_coordinates: Vec<[f32; 2]>,
    pub(super) normals: Vec<[f32; 3]>,
    /// Corners of each face of three or more.
    pub(super) corners: Vec<u32>,
    /// Indices by list and corner, from 0. Those of texture coordinates and normals are as long as the first, or shorter: the rest is
    /// [`NO_INDEX`].
    pub(super) indices: [Vec<u32>; 3],
    /// From which face on which name is used, by number.
    pub(super) materials: Vec<(usize, u32)>,
    /// Names of materials, with the line of their first use.
    pub(super) names: Vec<(String, u64)>,
    /// From which face on a group goes, and what it is called.
    pub(super) groups: Vec<(usize, String)>,
    /// What `mtllib` statements say.
    pub(super) libraries: Vec<String>,
    /// Lines that were read.
    pub(super) lines: u64,
    pub(super) points_and_lines: Seen,
    pub(super) not_finite: Seen,
    pub(super) odd_texture_coordinates: Seen,
    pub(super) odd_normals: Seen,
    pub(super) fourth_numbers: Seen,
    pub(super) nameless_materials: Seen,
    pub(super) unknown: Seen,
    /// Indices of texture coordinates and normals that there are not.
    pub(super) dangling: Seen,
    /// Numbers of colours that are no numbers.
    pub(super) odd_colors: Seen,
    /// More than three numbers of a vertex that are neither a weight nor a colour.
    pub(super) odd_numbers: Seen,
    pub(super) empty_faces: Seen,
    pub(super) free_form: Seen,
    pub(super) numbers: HashMap<String, u32>,
    /// For each list: faces that pointed past the end of what was there, as (line, index), each farther than the one
    /// before. Legal if the list grows that long later.
    pub(super) pending: [Vec<(u64, u64)>; 3],
    /// Of a piece that is read alone: how many each list must have before it for all indices to be in range.
    pub(super) piece: Option<[u64; 3]>,
}

/// May a backslash at its end join this line to the next? Not a comment, and not a name, which may end in one.
fn joins(line: &[u8]) -> bool {
    let keyword = line.trim_ascii_start().split(u8::is_ascii_whitespace).next().unwrap_or_default();
    !line.contains(&b'#') && !matches!(keyword, b"usemtl" | b"mtllib" | b"o" | b"g" | b"usemap" | b"maplib")
}

impl Obj {
    /// Reads statements behind those that are there.
    ///
    /// # Errors
    /// Why reading stopped, and at which line.
    pub(super) fn statements(&mut self, text: &[u8]) -> Result<(), (u64, Stop)> {
        let mut lines = Lines::after(self.lines, text);
        loop {
            lines.skip(|number, line| self.plain_statement(number, line));
            match lines.next(joins) {
                Ok(Some((number, line))) => self.statement(number, line).map_err(|fault| (number, fault.into()))?,
                Ok(None) => break,
                Err(stop) => return Err((lines.number, stop)),
            }
        }
        self.lines = lines.number;
        Ok(())
    }

    /// Takes what nearly all lines are: plain numbers behind `v`, `vt`, `vn` and `f`.
    #[inline(always)]
    fn plain_statement(&mut self, line: u64, text: &[u8]) -> bool {
        match text {
            [b'v', b' ', rest @ ..] => Plain(rest).decimals().map(|position| self.positions.push(position)).is_some(),
            [b'v', b'n', b' ', rest @ ..] => {
                let normal = Plain(rest).decimals().map(|normal| normal.map(|x| x as f32));
                normal.map(|normal| self.normals.push(normal)).is_some()
            }
            [b'v', b't', b' ', rest @ ..] => {
                let uv = Plain(rest).decimals().map(|uv| uv.map(|x| x as f32));
                uv.map(|uv| self.texture_coordinates.push(uv)).is_some()
            }
            [b'f', b' ', rest @ ..] => {
                let first = self.indices[0].len();
                let corners = self.plain_face(line, Plain(rest)).filter(|&corners| corners >= 3);
                match corners {
                    Some(corners) => self.corners.push(corners),
                    None => self.indices.iter_mut().for_each(|indices| indices.truncate(first)),
                }
                corners.is_some()
            }
            _ => false,
        }
    }

    /// The number of corners of a face of plain indices.
    #[inline(always)]
    fn plain_face(&mut self, line: u64, mut text: Plain<'_>) -> Option<u32> {
        let (first, mut corners) = (self.indices[0].len(), 0);
        while text.more() {
            for list in 0..3 {
                // `v//vn` has nothing between.
                if list == 1 && text.take(b'/') {
                    continue;
                }
                let index = text.whole().filter(|index| (1..=LARGEST_INDEX).contains(index))?;
                self.points_at(line, list, index);
                let indices = &mut self.indices[list];
                if indices.len() < first + corners {
                    indices.resize(first + corners, NO_INDEX);
                }
                indices.push((index - 1) as u32);
                if !text.take(b'/') {
                    break;
                }
            }
            if !text.ends() {
                return None;
            }
            corners += 1;
        }
        Some(corners as u32)
    }

    fn statement(&mut self, line: u64, text: &str) -> Result<(), Fault> {
        let text = text.trim();
        let (keyword, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        // Not any `#`: some programs write `1.#IND`.
        let words = || rest.split_whitespace().take_while(|word| !word.starts_with('#'));
        match keyword {
            "v" => self.vertex(line, words())?,
            "vt" => self.texture(line, words())?,
            "vn" => self.normal(line, words())?,
            "f" | "fo" => self.face(line, words())?,
            "usemtl" => self.material(line, rest.trim()),
            "mtllib" => self.libraries.push(rest.trim().to_owned()),
            "o" | "g" => self.group(self.corners.len(), rest.trim()),
            "p" | "l" => self.points_and_lines.at(line),
            "" | "s" | "mg" | "usemap" | "maplib" | "bevel" | "c_interp" | "d_interp" | "lod" | "shadow_obj"
            | "trace_obj" => {}
            "vp" | "cstype" | "deg" | "bmat" | "step" | "curv" | "curv2" | "surf" | "parm" | "trim" | "hole"
            | "scrv" | "sp" | "end" | "con" | "ctech" | "stech" => self.free_form.at(line),
            _ if keyword.starts_with('#') => {}
            _ => self.unknown.at(line),
        }
        Ok(())
    }

    /// `v x y z [w | r g b [a]]`.
    fn vertex<'a>(&mut self, line: u64, words: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        let mut values = [0.0; 6];
        let mut seen = 0;
        for word in words.take(10) {
            if seen < 6 {
                values[seen] = parse(word, "coordinate")?;
            }
            seen += 1;
        }
        let [x, y, z, r, g, b] = values;
        if seen < 3 {
            return Err(Fault::new(format!("a vertex with {seen} of 3 coordinates"), "write v x y z"));
        }
        if ![x, y, z].iter().all(|x| x.is_finite()) {
            self.not_finite.at(line);
        }
        match seen {
            // With an alpha, which is left out.
            6 | 7 => {
                if ![r, g, b].iter().all(|x| x.is_finite()) {
                    self.odd_colors.at(line);
                }
                let color = [r, g, b].map(|x| if x.is_finite() { x as f32 } else { 1.0 });
                self.colors.resize(self.positions.len(), [1.0; 3]);
                self.colors.push(color);
            }
            4 if r != 1.0 => self.fourth_numbers.at(line),
            5.. => self.odd_numbers.at(line),
            _ => {}
        }
        self.positions.push([x, y, z]);
        Ok(())
    }

    /// `vt u [v [w]]`.
    fn texture<'a>(&mut self, line: u64, words: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        let mut uv = [0.0; 2];
        let mut seen = 0;
        for (value, word) in uv.iter_mut().zip(words) {
            *value = parse(word, "texture coordinate")? as f32;
            seen += 1;
        }
        if seen == 0 {
            return Err(Fault::new("a texture coordinate without numbers", "write vt u v"));
        }
        if !uv.iter().all(|x| x.is_finite()) {
            self.odd_texture_coordinates.at(line);
            uv = [0.0; 2];
        }
        self.texture_coordinates.push(uv);
        Ok(())
    }

    /// `vn x y z`.
    fn normal<'a>(&mut self, line: u64, words: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        let mut xyz = [0.0; 3];
        let mut seen = 0;
        for (value, word) in xyz.iter_mut().zip(words) {
            *value = parse(word, "normal")? as f32;
            seen += 1;
        }
        if seen < 3 {
            return Err(Fault::new(format!("a normal with {seen} of 3 components"), "write vn x y z"));
        }
        if !xyz.iter().all(|x| x.is_finite()) {
            self.odd_normals.at(line);
            // Shading leaves out normals without a length.
            xyz = [0.0; 3];
        }
        self.normals.push(xyz);
        Ok(())
    }

    /// From a face on a group goes.
    pub(super) fn group(&mut self, face: usize, name: &str) {
        if self.groups.last().is_none_or(|(_, last)| last != name) {
            self.groups.push((face, name.to_owned()));
        }
    }

    /// Nameless: grey, as Blender means it.
    fn material(&mut self, line: u64, name: &str) {
        if name.is_empty() {
            self.nameless_materials.at(line);
        }
        let number = if name.is_empty() { NO_INDEX } else { self.number(name, line) };
        self.use_material(self.corners.len(), number);
    }

    /// Names are numbered by first use.
    pub(super) fn number(&mut self, name: &str, line: u64) -> u32 {
        if let Some(&number) = self.numbers.get(name) {
            return number;
        }
        let number = self.names.len() as u32;
        self.names.push((name.to_owned(), line));
        self.numbers.insert(name.to_owned(), number);
        number
    }

    /// From a face on a material is used.
    pub(super) fn use_material(&mut self, face: usize, number: u32) {
        if self.materials.last().is_none_or(|&(_, last)| last != number) {
            self.materials.push((face, number));
        }
    }

    /// All that is odd.
    pub(super) fn seen(&mut self) -> [&mut Seen; 12] {
        [
            &mut self.points_and_lines,
            &mut self.not_finite,
            &mut self.odd_texture_coordinates,
            &mut self.odd_normals,
            &mut self.fourth_numbers,
            &mut self.nameless_materials,
            &mut self.unknown,
            &mut self.dangling,
            &mut self.odd_colors,
            &mut self.odd_numbers,
            &mut self.empty_faces,
            &mut self.free_form,
        ]
    }

    /// `f v v v ...`, each `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn face<'a>(&mut self, line: u64, words: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        let first = self.indices[0].len();
        let mut corners = 0;
        for word in words {
            // A comment may follow at once.
            let word = word.split('#').next().unwrap_or_default();
            for (list, field) in word.split('/').enumerate() {
                if list >= 3 {
                    let problem = format!("face corner {} has more than 3 indices", quoted(word));
                    return Err(Fault::new(problem, "write v/vt/vn"));
                }
                if !field.is_empty() {
                    let index = self.index(line, list, field)?;
                    self.indices[list].resize(first + corners, NO_INDEX);
                    self.indices[list].push(index);
                } else if list == 0 {
                    let problem = format!("face corner {} has no vertex index", quoted(word));
                    return Err(Fault::new(problem, "write v/vt/vn"));
                }
            }
            corners += 1;
        }
        if corners == 0 {
            self.empty_faces.at(line);
            return Ok(());
        }
        if corners < 3 {
            self.points_and_lines.at(line);
            self.indices.iter_mut().for_each(|indices| indices.truncate(first));
            return Ok(());
        }
        self.corners.push(corners as u32);
        Ok(())
    }

    /// How many are in a list.
    pub(super) fn count(&self, list: usize) -> u64 {
        [self.positions.len(), self.texture_coordinates.len(), self.normals.len()][list] as u64
    }

    /// An index, from 0.
    fn index(&mut self, line: u64, list: usize, field: &str) -> Result<u32, Fault> {
        let (name, count) = (LISTS[list], self.count(list));
        let huge = || {
            let problem = format!("{name} index {} is out of range: {count} are defined before it", quoted(field));
            Fault::new(problem, INDICES)
        };
        let index: i64 = field.parse().map_err(|_| {
            let digits = field.trim_start_matches(['-', '+']);
            if !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) {
                huge()
            } else {
                Fault::new(format!("{name} index {} is not a whole number", quoted(field)), "write v/vt/vn")
            }
        })?;
        match index {
            0 => Err(Fault::new(format!("{name} index 0; indices start at 1"), "add 1 to every index of the file")),
            // In a piece it is not known how many are before it.
            ..0 if self.piece.is_some() => Err(huge()),
            ..0 => count.checked_sub(index.unsigned_abs()).map(|index| index as u32).ok_or_else(huge),
            _ if index as u64 > LARGEST_INDEX => Err(huge()),
            _ => {
                self.points_at(line, list, index as u64);
                Ok((index - 1) as u32)
            }
        }
    }

    /// Remembers what must be there for an index from 1 to be in range.
    #[inline(always)]
    fn points_at(&mut self, line: u64, list: usize, index: u64) {
        let count = self.count(list);
        if index <= count {
            return;
        }
        if let Some(before) = &mut self.piece {
            before[list] = before[list].max(index - count);
        } else if self.pending[list].last().is_none_or(|&(_, farthest)| index > farthest) {
            self.pending[list].push((line, index));
        }
    }

    /// At the end of the file: which faces point past the end of the lists?
    ///
    /// # Errors
    /// The first that points past the end of the vertices: its line and what is wrong.
    pub(super) fn check_range(&mut self) -> Result<(), (u64, Stop)> {
        let [of_vertex, of_texture, of_normal] = [0, 1, 2].map(|list| {
            let count = self.count(list);
            self.pending[list].iter().find(|(_, index)| *index > count).copied()
        });
        [of_texture, of_normal].into_iter().flatten().for_each(|(line, _)| self.dangling.at(line));
        let Some((line, index)) = of_vertex else { return Ok(()) };
        let problem = format!("{} index {index} is out of range: {} are defined", LISTS[0], self.count(0));
        Err((line, Fault::new(problem, INDICES).into()))
    }
}

fn parse(word: &str, what: &str) -> Result<f64, Fault> {
    number(word).ok_or_else(|| Fault::new(format!("{what} {} is not a number", quoted(word)), NUMBERS))
}
