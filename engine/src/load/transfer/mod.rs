//! Transfer functions from files: a text format of our own, and the JSON colour maps of ParaView. Either may be packed by gzip.
//!
//! | file | idea |
//! |---|---|
//! | `points` | the text format: a point a line |
//! | `paraview` | colour maps of ParaView |

mod paraview;
mod points;

use std::io::Read;
use std::path::Path;

use self::points::REMEDY;
use super::loaded::display_name;
use super::{LoadError, input};
use crate::progress::Progress;
use crate::volume::TransferFunction;

/// A larger file is no transfer function.
const LARGEST: u64 = 4 << 20;

/// Loads a transfer function; `-` is the standard input. A file that starts with `{` or `[` is a colour map of ParaView, another the
/// text format.
///
/// The text format has a first line `mobula transfer 1`, then in any order lines that say what values and lengths are measured by
/// (see [`Scale`](crate::volume::Scale)) and a line for each point, by value; two of one value are a jump. What follows a `#` is a
/// comment.
///
/// ```text
/// mobula transfer 1
/// values relative     # or absolute, which is the default
/// lengths relative    # or absolute, which is the default
/// # value   red green blue (sRGB, 0 to 1)   extinction
/// 0.2       1.0 0.5 0.2                     0
/// 0.6       1.0 0.9 0.7                     3.5
/// ```
///
/// Of a colour map of ParaView the first map of the file counts: `RGBPoints` between which colours go as `ColorSpace` says, and the
/// opacities `Points`; or `IndexedColors` for the labels that `Annotations` name, of which 0 is clear. Opacity is that of a
/// hundredth of the volume's longest side. Without `Points` it rises from 0 to 0.2. A map from exactly 0 to 1 or from -1 to 1 was made
/// for no data in particular, as those that come with ParaView: its ends become the ends of the volume's range, those of
/// `Points` too. Any other map is absolute.
///
/// # Errors
/// If it cannot be read, or is neither; the error is one line that says where and what to do.
pub fn load_transfer(path: &Path) -> Result<TransferFunction, LoadError> {
    let mut input = input::open(path, &Progress::default())?;
    let mut bytes = Vec::new();
    if let Err(error) = (&mut input.reader).take(LARGEST + 1).read_to_end(&mut bytes) {
        let (problem, remedy) = input::explain(&error, input.gzip);
        return Err(LoadError::new(path, problem, remedy));
    }
    if bytes.len() as u64 > LARGEST {
        let problem = format!("is larger than {} MiB: this is no transfer function", LARGEST >> 20);
        return Err(LoadError::new(path, problem, REMEDY));
    }
    parse(path, &bytes)
}

fn parse(file: &Path, bytes: &[u8]) -> Result<TransferFunction, LoadError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count();
        LoadError::new(file, "this is not UTF-8 text", REMEDY).at(line as u64)
    })?;
    let name = display_name(file);
    match text.trim_start().chars().next() {
        None => Err(LoadError::new(file, "the file is empty", REMEDY)),
        Some('{' | '[') => paraview::read(file, name, text),
        Some(_) => points::read(file, name, text),
    }
}

#[cfg(test)]
mod tests {
    use proptest::collection::vec;
    use proptest::prelude::*;
    use proptest::sample::Index;

    use super::*;

    #[test]
    fn what_is_something_else_is_refused() {
        let error = |bytes: &[u8]| parse(Path::new("a.txt"), bytes).unwrap_err().to_string();
        for empty in [&b""[..], b" \n\t\n", b"\xef\xbb\xbf"] {
            assert_eq!(error(empty), format!("a.txt: the file is empty; {REMEDY}"));
        }
        assert_eq!(error(b"mobula transfer 1\n\n\xff 0"), format!("a.txt:3: this is not UTF-8 text; {REMEDY}"));
        assert_eq!(
            error(b"# .PCD v.7\n"),
            format!("a.txt:1: this is no transfer function that Mobula knows; {REMEDY}")
        );
    }

    const SEEDS: [&str; 3] = [
        "mobula transfer 1\nvalues relative # of it\nlengths relative\n0.2 1 0.5 0.2 0\n0.2 1e-1 1 .5 3.5\n0.7 0 0 0 1e3\n",
        r#"[{"Name": "x", "ColorSpace": "Diverging", "RGBPoints": [-1, 0.2, 0.3, 0.7, 0, 0.8, 0.8, 0.8, 1, 0.7, 0, 0.1],
            "Points": [0, 0, 0.5, 0, 0.3, 0.5, 0.2, 0.7, 1, 1, 0.5, 1]}]"#,
        r#"{"Annotations": ["0", "a", "3", "b", "3.2", "c"], "IndexedColors": [1, 1, 1, 0.5, 0, 0], "HSVWrap": 1}"#,
    ];
    const PARTS: [&str; 16] = [
        "-", "1e308", "1e-320", "0", "1", ", ", "[", "]", "{", "\n", "nan", "\"HSV\"", "\"Lab\"", "\"Step\"", "Points",
        "1e999",
    ];

    proptest! {
        /// What is damaged is an error or a sound function.
        #[test]
        fn damaged_files_do_no_harm(seed in 0..3_usize, edits in vec((any::<Index>(), 0..6_usize, 0..16_usize), 0..5)) {
            let mut bytes = SEEDS[seed].as_bytes().to_vec();
            for (at, length, part) in edits {
                let at = at.index(bytes.len() + 1);
                let end = (at + length).min(bytes.len());
                bytes.splice(at..end, PARTS[part].bytes());
            }
            match parse(Path::new("a"), &bytes) {
                Ok(TransferFunction { name, points, values, lengths }) => {
                    let again = TransferFunction::new(name, points, values, lengths).unwrap();
                    for range in [[-1000.0, 1500.0], [f64::MIN, f64::MAX]] {
                        let points = again.resolve(range, 0.5);
                        prop_assert!(points.is_sorted_by(|a, b| a.value <= b.value));
                        prop_assert!(points.iter().all(|point| (0.0..=f64::MAX).contains(&point.extinction)));
                    }
                }
                Err(error) => prop_assert!(!error.to_string().contains('\n')),
            }
        }
    }

    #[test]
    fn files_are_read() {
        let folder = std::env::temp_dir().join(format!("mobula-transfer-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let load = |name: &str, bytes: &[u8]| {
            let file = folder.join(name);
            std::fs::write(&file, bytes).unwrap();
            load_transfer(&file)
        };
        let text = "mobula transfer 1\n0 1 1 1 2\n";
        let plain = load("warm.txt", text.as_bytes()).unwrap();
        assert_eq!((plain.name.as_str(), plain.points.len()), ("warm", 1));
        let utf16: Vec<u8> = [0xfeff_u16].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
        assert_eq!(load("warm.txt", &utf16), Ok(plain.clone()));
        let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        std::io::Write::write_all(&mut gzip, text.as_bytes()).unwrap();
        let gzip = gzip.finish().unwrap();
        assert_eq!(load("warm.txt.gz", &gzip), Ok(plain));
        let cut = load("cut.txt.gz", &gzip[..gzip.len() - 6]).unwrap_err();
        assert!(cut.problem.contains("ends too early"), "{cut}");
        let huge = load("huge.txt", &vec![b'#'; (4 << 20) + 1]).unwrap_err();
        assert!(huge.problem.contains("larger than 4 MiB"), "{huge}");
        assert!(load_transfer(&folder.join("missing")).unwrap_err().problem.contains("no such file"));
        std::fs::remove_dir_all(folder).unwrap();
    }
}
