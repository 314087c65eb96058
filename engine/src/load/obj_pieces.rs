//! An OBJ file in pieces, which threads read at the same time.
//!
//! Each is read as if nothing were before it, and they are put together in order. Where what is before matters after all (indices from
//! the end or of what is defined later, and whatever is wrong and is told with its line) the piece is read once more, in its place. So
//! what comes out, faults as well, is what reading from the first line to the last gives, however many threads there are.

use std::io::BufRead;

use super::lines::Stop;
use super::obj_read::Obj;
use super::pieces::{Piece, Pieces};
use crate::accel::Pool;
use crate::geometry::NO_INDEX;

/// Pieces that are read at the same time, while as many that were read before are put together.
const AT_ONCE: usize = 16;

impl Obj {
    /// Reads all statements.
    ///
    /// # Errors
    /// Why reading stopped, and at which line.
    pub(super) fn read(input: impl BufRead) -> Result<Self, (u64, Stop)> {
        Self::read_pieces(&mut Pieces::new(input))
    }

    fn read_pieces(pieces: &mut dyn Iterator<Item = Piece>) -> Result<Self, (u64, Stop)> {
        let mut obj = Self::default();
        // One is read here: what is small needs no threads.
        pieces.next().map_or(Ok(()), |first| obj.read_in_place(first))?;
        let mut before = Vec::new();
        let mut next = pieces.next();
        while next.is_some() || !before.is_empty() {
            let mut batch: Vec<(Piece, Option<Self>)> = Vec::new();
            batch.resize_with(AT_ONCE, Default::default);
            let mut count = 0;
            Pool::with_tasks(|tasks| {
                for (piece, alone) in &mut batch {
                    let Some(text) = next.take().or_else(|| pieces.next()) else { break };
                    *piece = text;
                    tasks.add(|| *alone = Self::read_alone(piece));
                    count += 1;
                }
                before.drain(..).try_for_each(|(piece, alone)| obj.append(piece, alone))
            })?;
            batch.truncate(count);
            before = batch;
        }
        obj.check_range().map(|()| obj)
    }

    /// Reads the statements of a piece behind those that are there.
    fn read_in_place(&mut self, piece: Piece) -> Result<(), (u64, Stop)> {
        self.statements(&piece.text)?;
        piece.failed.map_or(Ok(()), |error| Err((self.lines + 1, Stop::Io(error))))
    }

    /// Reads a piece of which it is not known what is before it; `None` if that matters.
    fn read_alone(piece: &Piece) -> Option<Self> {
        let mut obj = Self { piece: Some([0; 3]), ..Self::default() };
        // Lines are counted from 1 here: a mark that only means something at the start of a file must not do so here.
        let sound = piece.failed.is_none() && !piece.text.starts_with(b"\xef\xbb\xbf");
        (sound && obj.statements(&piece.text).is_ok()).then_some(obj)
    }

    /// Appends a piece that was read alone; one that could not be, or points past the end of what is there now, is read here.
    fn append(&mut self, piece: Piece, read: Option<Self>) -> Result<(), (u64, Stop)> {
        let fits = |read: &Self| read.piece.is_some_and(|before| (0..3).all(|list| before[list] <= self.count(list)));
        let Some(mut read) = read.filter(fits) else { return self.read_in_place(piece) };
        let (lines, faces) = (self.lines, self.corners.len());
        // What is shorter than the list that it goes with is padded up to where the piece begins.
        if !read.colors.is_empty() {
            self.colors.resize(self.positions.len(), [1.0; 3]);
            self.colors.append(&mut read.colors);
        }
        let corners = self.indices[0].len();
        for (all, indices) in self.indices.iter_mut().zip(&mut read.indices) {
            if !indices.is_empty() {
                all.resize(corners, NO_INDEX);
                all.append(indices);
            }
        }
        self.positions.append(&mut read.positions);
        self.texture_coordinates.append(&mut read.texture_coordinates);
        self.normals.append(&mut read.normals);
        self.corners.append(&mut read.corners);
        self.libraries.append(&mut read.libraries);
        for (face, name) in &read.groups {
            self.group(faces + face, name);
        }
        let numbers: Vec<u32> = read.names.iter().map(|(name, line)| self.number(name, lines + line)).collect();
        for &(face, number) in &read.materials {
            self.use_material(faces + face, numbers.get(number as usize).copied().unwrap_or(NO_INDEX));
        }
        for (all, seen) in self.seen().into_iter().zip(read.seen()) {
            all.add(*seen, lines);
        }
        self.lines += read.lines;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What OBJ files have in them, and what they should not have.
    const LINES: [&str; 45] = [
        "v 0 0.25 -1",
        "v 1.5 2 3",
        "v 1e-3 2 3 1",
        "v 1 2 3 0.5 0.5 0.5",
        "v 1 2 3 4 5",
        "v nan 1 2",
        "v 1 2 3 nan 0 0",
        "v 1 2 \\\n3",
        "v 1\u{a0}2 3",
        "vt 0.5 1",
        "vt 1",
        "vt inf 0",
        "vn 0 0 1",
        "vn 1 nan 0",
        "f 1 2 3",
        "f 1 2 3 4 # a square",
        "f 3 2 1",
        "f 1/1 2/1 3/2",
        "f 1//1 2//2 3//1",
        "f 1/1/1 2/2/2 3/1/2",
        "f 1 2/1 3//2",
        "f -1 -2 -3",
        "f -1/-1 -2/-1 -3/-1",
        "f 5 6 \\\n7",
        "f 2 9 30",
        "f 1/40 2/1 3/1",
        "f 1 2",
        "f",
        "g one",
        "g two\u{a0}words",
        "o one",
        "usemtl red",
        "usemtl blue # sky",
        "usemtl",
        "mtllib a.mtl",
        "s off",
        "l 1 2",
        "curv 1",
        "what is this",
        "# a comment \\",
        "\u{feff}v 1 2 3",
        "",
        "f 1 2 0",
        "v 1 x 2",
        "v 1 2 3\0",
    ];

    /// All but what is only known while it is read.
    fn shown(read: Result<Obj, (u64, Stop)>) -> String {
        let read = read.map(|obj| Obj { numbers: Default::default(), pending: Default::default(), ..obj });
        format!("{read:?}")
    }

    proptest! {
        #[test]
        fn pieces_say_what_the_whole_says(
            lines in prop::collection::vec(0..LINES.len() - 3, 0..300),
            broken in prop_oneof![3 => Just(None), 1 => (0..300_usize, LINES.len() - 3..LINES.len()).prop_map(Some)],
            vertices in 3..40_usize,
            end in prop_oneof![Just("\n"), Just("\r\n"), Just("\r")],
            size in 16..300_usize,
        ) {
            let mut lines: Vec<&str> = lines.into_iter().map(|line| LINES[line]).collect();
            if let Some((at, line)) = broken {
                lines.insert(at.min(lines.len()), LINES[line]);
            }
            // Enough for most indices to be in range.
            lines.splice(0..0, std::iter::repeat_n("v 0 1 2", vertices));
            let text = lines.join("\n").replace('\n', end);
            let whole = |text: &str| {
                let mut whole = Obj::default();
                whole.statements(text.as_bytes()).and_then(|()| whole.check_range()).map(|()| whole)
            };
            let pieces = Obj::read_pieces(&mut Pieces::of_size(size, text.as_bytes()));
            prop_assert_eq!(shown(pieces), shown(whole(&text)));
            // With these blanks no line is plain.
            let tabs = ["v ", "vt ", "vn ", "f "].into_iter().fold(text.clone(), |text, keyword| {
                text.replace(&format!("{end}{keyword}"), &format!("{end}{}\t", keyword.trim_end()))
            });
            prop_assert_eq!(shown(whole(&tabs)), shown(whole(&text)));
        }
    }
}
