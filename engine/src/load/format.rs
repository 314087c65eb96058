//! The formats that can be loaded, and which one a file is in: by its name, else by its content.

use std::path::Path;

use super::input::{self, Input};
use super::loaded::Loaded;
use super::place::Place;
use super::{LoadError, obj};
use crate::progress::Progress;

/// A format that can be loaded.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// What people call it.
    pub name: &'static str,
    /// How its files' names end, in lower case; each may be followed by `.gz`.
    pub extensions: &'static [&'static str],
    /// Does the start of a file, unpacked, look like it?
    pub sniff: fn(&[u8]) -> bool,
    /// Loads an opened file, to a place or where it finds best.
    load: fn(&Path, Input, Option<Place>) -> Result<Loaded, LoadError>,
}

/// All formats: a new one is a file and a line here.
pub const FORMATS: &[Format] =
    &[Format { name: "Wavefront OBJ", extensions: &[".obj"], sniff: obj::looks_like, load: obj::load }];

/// What can be loaded, for messages.
pub(super) fn supported() -> String {
    let format = |format: &Format| {
        let names: Vec<String> = format.extensions.iter().map(|end| format!("{end}, {end}.gz")).collect();
        format!("{} files ({})", format.name, names.join(", "))
    };
    format!("Mobula loads {}", FORMATS.iter().map(format).collect::<Vec<_>>().join(", "))
}

/// Loads a file, choosing the format by its name and its content; `-` is the standard input.
///
/// # Errors
/// If it cannot be read, is of no supported format, or is broken; the error is one line that says where and what to do.
pub fn load(file: &Path) -> Result<Loaded, LoadError> {
    load_with(file, &Options::default())
}

/// How a file is loaded.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The place of another file that is shown with it; `None`: where it finds best.
    pub place: Option<Place>,
    /// Where the bytes are counted that have been read.
    pub progress: Progress,
}

/// As [`load`], with options.
///
/// # Errors
/// Those of [`load`].
pub fn load_with(file: &Path, options: &Options) -> Result<Loaded, LoadError> {
    let place = options.place;
    let name = file.file_name().map(|n| n.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let stem = name.strip_suffix(".gz").unwrap_or(&name);
    let named = |format: &&Format| format.extensions.iter().any(|end| stem.ends_with(end));
    let mut input = input::open(file, &options.progress)?;
    if let Some(format) = FORMATS.iter().find(named) {
        return (format.load)(file, input, place);
    }
    // What cannot be read is told by whoever reads it.
    let start = input.start().unwrap_or_default().to_vec();
    if let Some(format) = FORMATS.iter().find(|format| (format.sniff)(&start)) {
        return (format.load)(file, input, place);
    }
    let problem = match known_format(&start, stem) {
        Some(format) => format!("this is in {format} format, which Mobula cannot load"),
        None if start.is_empty() => "the file is empty".into(),
        None => "this is in no format that Mobula knows".into(),
    };
    Err(LoadError::new(file, problem, supported()))
}

/// The name of a format that we know but cannot load.
fn known_format(start: &[u8], name: &str) -> Option<&'static str> {
    const MAGIC: [(&[u8], &str); 7] = [
        (b"ply", "PLY"),
        (b"NRRD", "NRRD"),
        (b"glTF", "glTF"),
        (b"solid", "STL"),
        (b"PK\x03\x04", "ZIP"),
        (b"\x89PNG", "PNG"),
        (b"<?xml", "XML"),
    ];
    const EXTENSIONS: [(&str, &str); 8] = [
        (".stl", "STL"),
        (".ply", "PLY"),
        (".nrrd", "NRRD"),
        (".nhdr", "NRRD"),
        (".gltf", "glTF"),
        (".fbx", "FBX"),
        (".3ds", "3DS"),
        (".mtl", "material (MTL)"),
    ];
    let magic = MAGIC.iter().find(|(magic, _)| start.starts_with(magic)).map(|&(_, format)| format);
    magic.or_else(|| EXTENSIONS.iter().find(|(end, _)| name.ends_with(end)).map(|&(_, format)| format))
}
