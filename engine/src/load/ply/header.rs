//! The header of a PLY file: what elements there are, and what each has.

use std::io::BufRead;

use crate::load::VoxelType;
use crate::load::lines::{Fault, Lines, Stop};
use crate::load::text::quoted;

/// A longer line is in no header.
const LONGEST_LINE: usize = 1 << 16;
/// More elements, and more properties of one, are in none.
const MOST: usize = 1 << 10;
const WRITTEN: &str = "check how it was written";

/// How rows are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Binary { big_endian: bool },
}

/// What a header says.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    pub(super) comments: Vec<String>,
    /// Lines that it has, and at least how many bytes.
    pub(super) lines: u64,
    pub(super) bytes: u64,
}

/// Rows of one kind.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    /// Where it stands.
    pub(super) line: u64,
}

/// What each row has.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: VoxelType,
    /// The type of the count before a list.
    pub(super) list: Option<VoxelType>,
}

impl Element {
    /// Where the first property is that has one of these names and is, or is not, a list.
    pub(super) fn find(&self, names: &[&str], list: bool) -> Option<usize> {
        let at = |wanted: &&str| {
            let fits =
                |property: &Property| property.list.is_some() == list && property.name.eq_ignore_ascii_case(wanted);
            self.properties.iter().position(fits)
        };
        names.iter().find_map(at)
    }
}

impl Header {
    /// Reads a header and nothing behind it; else says where it is wrong.
    pub(super) fn read(reader: &mut dyn BufRead) -> Result<Self, (u64, Stop)> {
        let mut lines = Lines::no_longer_than(LONGEST_LINE, reader);
        let mut header =
            Self { encoding: Encoding::Text, elements: Vec::new(), comments: Vec::new(), lines: 0, bytes: 0 };
        let mut encoding = None;
        while !header.add(&mut lines, &mut encoding)? {}
        let missing =
            || Fault::new("the header does not say how its rows are written", "add a line `format ascii 1.0`");
        header.encoding = encoding.ok_or_else(|| (header.lines, missing().into()))?;
        Ok(header)
    }

    /// Reads a line; true: it ends the header.
    fn add<R: BufRead>(&mut self, lines: &mut Lines<R>, encoding: &mut Option<Encoding>) -> Result<bool, (u64, Stop)> {
        let line = match lines.next(|_| false) {
            Ok(Some((_, line))) => line.clone(),
            Ok(None) => {
                let fault = Fault::new("the header has no end", "the file is truncated: fetch it again");
                return Err((lines.number.max(1), fault.into()));
            }
            Err(stop) => return Err((lines.number, stop)),
        };
        self.lines = lines.number;
        // Of a byte that is no text a character of three bytes was made.
        let bytes = |c: char| if c == char::REPLACEMENT_CHARACTER { 1 } else { c.len_utf8() as u64 };
        self.bytes += line.chars().map(bytes).sum::<u64>() + 1;
        self.understand(line.trim(), encoding).map_err(|fault| (lines.number, fault.into()))
    }

    fn understand(&mut self, line: &str, encoding: &mut Option<Encoding>) -> Result<bool, Fault> {
        let words: Vec<&str> = line.split_whitespace().collect();
        if self.lines == 1 {
            return match words[..] {
                ["ply"] => Ok(false),
                _ => Err(Fault::new("a PLY file starts with a line `ply`", "check that it is what its name says")),
            };
        }
        let strange = || Fault::new(format!("{} is no line of a PLY header", quoted(line)), WRITTEN);
        match words[..] {
            [] | ["obj_info", ..] => {}
            ["comment", ..] => self.comments.push(line["comment".len()..].trim().to_owned()),
            ["format", how, ..] => {
                *encoding = Some(match how {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::Binary { big_endian: false },
                    "binary_big_endian" => Encoding::Binary { big_endian: true },
                    _ => return Err(Fault::new(format!("there is no format {} of PLY", quoted(how)), WRITTEN)),
                });
            }
            ["element", name, count] => {
                let not = || Fault::new(format!("{} is no number of elements", quoted(count)), WRITTEN);
                let count = count.parse().map_err(|_| not())?;
                if self.elements.len() >= MOST {
                    return Err(Fault::new("the header has too many elements", WRITTEN));
                }
                let name = name.to_owned();
                self.elements.push(Element { name, count, properties: Vec::new(), line: self.lines });
            }
            ["property", "list", count, kind, name] => self.property(name, kind, Some(count))?,
            ["property", kind, name] => self.property(name, kind, None)?,
            ["end_header"] => return Ok(true),
            _ => return Err(strange()),
        }
        Ok(false)
    }

    fn property(&mut self, name: &str, kind: &str, list: Option<&str>) -> Result<(), Fault> {
        let Some(element) = self.elements.last_mut() else {
            return Err(Fault::new("a property before any element", WRITTEN));
        };
        if element.properties.len() >= MOST {
            return Err(Fault::new(
                format!("{} has more than {MOST} properties", quoted(&element.name)),
                "leave some out",
            ));
        }
        if element.properties.iter().any(|property| property.name == name) {
            let problem = format!("{} has two properties {}", quoted(&element.name), quoted(name));
            return Err(Fault::new(problem, "leave one of them out"));
        }
        let list = list.map(kind_of).transpose()?;
        if list.is_some_and(|count| matches!(count, VoxelType::F32 | VoxelType::F64)) {
            return Err(Fault::new("the length of a list is no whole number", WRITTEN));
        }
        element.properties.push(Property { name: name.to_owned(), kind: kind_of(kind)?, list });
        Ok(())
    }
}

/// The type of a name.
fn kind_of(name: &str) -> Result<VoxelType, Fault> {
    Ok(match name {
        "uchar" | "uint8" => VoxelType::U8,
        "char" | "int8" => VoxelType::I8,
        "ushort" | "uint16" => VoxelType::U16,
        "short" | "int16" => VoxelType::I16,
        "uint" | "uint32" => VoxelType::U32,
        "int" | "int32" => VoxelType::I32,
        "float" | "float32" => VoxelType::F32,
        "double" | "float64" => VoxelType::F64,
        _ => return Err(Fault::new(format!("{} is no type of PLY", quoted(name)), WRITTEN)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Header, (u64, String)> {
        let mut bytes = text.as_bytes();
        let header = Header::read(&mut bytes).map_err(|(line, stop)| match stop {
            Stop::Fault(fault) => (line, fault.problem),
            Stop::Io(error) => (line, error.to_string()),
        });
        header.inspect(|header| assert_eq!(bytes, b"rest", "{header:?}"))
    }

    #[test]
    fn headers_are_read_to_their_end() {
        let text = "ply\r\nformat binary_big_endian 1.0\ncomment box 3\nelement vertex 2\nproperty float x\nproperty list uchar \
                    int a\nobj_info what\nelement face 0\nend_header\nrest";
        let header = read(text).unwrap();
        assert_eq!((header.encoding, header.lines), (Encoding::Binary { big_endian: true }, 9));
        assert_eq!(header.comments, ["box 3"]);
        let [vertex, face] = &header.elements[..] else { panic!() };
        assert_eq!((vertex.count, vertex.find(&["A"], true), face.line), (2, Some(1), 8));
        assert_eq!(
            vertex.properties[1],
            Property { name: "a".into(), kind: VoxelType::I32, list: Some(VoxelType::U8) }
        );
    }

    #[test]
    fn bytes_are_counted_that_are_no_text() {
        let mut bytes = &b"ply\nformat ascii 1.0\ncomment \xff\xe9\xff\nend_header\n"[..];
        let length = bytes.len() as u64;
        assert_eq!(Header::read(&mut bytes).map_err(|_| ()).unwrap().bytes, length);
    }

    #[test]
    fn what_is_wrong_is_told_at_its_line() {
        let head = "ply\nformat ascii 1.0\nelement vertex 2\n";
        for (text, line, expected) in [
            ("".to_owned(), 1, "no end"),
            ("plywood\n".to_owned(), 1, "starts with a line `ply`"),
            ("ply\nend_header\n".to_owned(), 2, "how its rows are written"),
            ("ply\nformat xml 1.0\n".to_owned(), 2, "no format 'xml'"),
            ("ply\nformat ascii 1.0\nproperty float x\n".to_owned(), 3, "before any element"),
            ("ply\nformat ascii 1.0\nelement vertex -1\n".to_owned(), 3, "'-1' is no number of elements"),
            (format!("{head}property half x\n"), 4, "'half' is no type"),
            (format!("{head}property list float int x\n"), 4, "no whole number"),
            (format!("{head}property float x\nproperty float x\n"), 5, "two properties 'x'"),
            (format!("{head}banana\n"), 4, "'banana' is no line"),
            (format!("{head}property float x"), 4, "no end"),
            (
                head.to_owned() + &(0..2000).map(|i| format!("property float p{i}\n")).collect::<String>(),
                1028,
                "more than 1024",
            ),
            (format!("ply\ncomment {}", "x".repeat(1 << 17)), 2, "more than 64 KiB"),
        ] {
            let (at, problem) = read(&text).unwrap_err();
            assert!(at == line && problem.contains(expected), "{at}: {problem} ({expected})");
        }
    }
}
