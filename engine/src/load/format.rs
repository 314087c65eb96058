//! The formats that can be loaded, and which one a file is in: by its name, else by its content.

use std::path::Path;

use super::input::{self, Input, Packed};
use super::loaded::Loaded;
use super::options::{Load, Options};
use super::particles::{self, csv, lammps, xyz};
use super::volume::{meta_image, nifti, nrrd, raw};
use super::{LoadError, gltf, obj, ply, scene_file, stl};
use crate::geometry::CREASE_ANGLE;

/// A format that can be loaded.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// What people call it.
    pub name: &'static str,
    /// How its files' names end, in lower case; each may be followed by `.gz`.
    pub extensions: &'static [&'static str],
    /// Does the start of a file, unpacked, look like it?
    pub sniff: fn(&[u8]) -> bool,
    /// Loads an opened file.
    load: fn(&Path, Input, &Options) -> Result<Loaded, LoadError>,
}

/// All formats: a new one is a file and a line here.
pub const FORMATS: &[Format] = &[
    Format { name: "Wavefront OBJ", extensions: &[".obj"], sniff: obj::looks_like, load: obj::load },
    Format { name: "PLY", extensions: &[".ply"], sniff: ply::looks_like, load: ply::load },
    Format { name: "STL", extensions: &[".stl"], sniff: stl::looks_like, load: stl::load },
    Format { name: "glTF", extensions: &[".gltf", ".glb"], sniff: gltf::looks_like, load: gltf::load },
    Format { name: "NRRD", extensions: &[".nrrd", ".nhdr"], sniff: nrrd::looks_like, load: nrrd::load },
    Format { name: "NIfTI", extensions: &[".nii"], sniff: nifti::looks_like, load: nifti::load },
    Format { name: "MetaImage", extensions: &[".mha", ".mhd"], sniff: meta_image::looks_like, load: meta_image::load },
    Format {
        name: "LAMMPS dump",
        extensions: &[".lammpstrj", ".lammpsdump", ".dump"],
        sniff: lammps::looks_like,
        load: lammps::load,
    },
    Format { name: "XYZ", extensions: &[".xyz", ".extxyz"], sniff: xyz::looks_like, load: xyz::load },
    Format { name: "CSV", extensions: &[".csv", ".tsv"], sniff: csv::looks_like, load: csv::load },
    Format { name: SCENE_FILE, extensions: &[".toml"], sniff: scene_file::looks_like, load: load_scene_file },
];

/// What the format is called that puts together what other files hold.
pub const SCENE_FILE: &str = "Mobula scene";

fn load_scene_file(file: &Path, input: Input, options: &Options) -> Result<Loaded, LoadError> {
    let part: Load = |part, options| load_any(part, options, |format| format.name != SCENE_FILE);
    scene_file::load(file, input, options, SCENE_FILE, part)
}

/// What can be loaded, for messages.
pub(super) fn supported() -> String {
    let format = |format: &Format| format!("{} ({})", format.name, format.extensions.join(", "));
    let formats: Vec<_> = FORMATS.iter().map(format).collect();
    format!(
        "Mobula loads {}, each also with .gz, raw voxels (--raw-dims) and raw particles (--raw-layout)",
        formats.join(", ")
    )
}

/// Loads a file, choosing the format by its name and its content; `-` is the standard input.
///
/// # Errors
/// If it cannot be read, is of no supported format, or is broken; the error is one line that says where and what to do.
pub fn load(file: &Path) -> Result<Loaded, LoadError> {
    load_with(file, &Options::default())
}

/// As [`load`], with options.
///
/// # Errors
/// Those of [`load`].
pub fn load_with(file: &Path, options: &Options) -> Result<Loaded, LoadError> {
    load_any(file, options, |_| true)
}

/// As [`load_with`], of some of the formats.
fn load_any(file: &Path, options: &Options, allowed: fn(&Format) -> bool) -> Result<Loaded, LoadError> {
    let load = |format: &Format, input| {
        if allowed(format) {
            let mut loaded = (format.load)(file, input, options)?;
            // A scene file's own files were smoothed as its parts; what it generates stays as it is.
            if format.name != SCENE_FILE {
                loaded.smooth(options.smooth.unwrap_or(CREASE_ANGLE));
            }
            loaded.tell_of_lost_textures();
            return Ok(loaded);
        }
        let remedy = "a scene file names no other ones: write here what is in it";
        Err(LoadError::new(file, format!("this is a {}", format.name), remedy))
    };
    let name = file.file_name().map(|n| n.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let stem = name.strip_suffix(".gz").unwrap_or(&name);
    let named = |format: &&Format| format.extensions.iter().any(|end| stem.ends_with(end));
    let named = FORMATS.iter().find(named);
    if let (Some(raw), None) = (&options.raw, named) {
        let packed = if name.ends_with(".gz") { Packed::AsItStarts } else { Packed::No };
        return raw::load(file, input::open_bytes(file, &options.progress, packed)?, raw, options);
    }
    if let (Some(raw), None) = (&options.raw_particles, named) {
        let packed = if name.ends_with(".gz") { Packed::AsItStarts } else { Packed::No };
        return particles::raw::load(file, input::open_bytes(file, &options.progress, packed)?, raw, options);
    }
    let mut input = input::open(file, &options.progress)?;
    if let Some(format) = named {
        return load(format, input);
    }
    // What cannot be read is told by whoever reads it.
    let start = input.start().unwrap_or_default().to_vec();
    if let Some(format) = FORMATS.iter().find(|format| (format.sniff)(&start)) {
        return load(format, input);
    }
    let problem = match known_format(&start, stem) {
        None if [".raw", ".img", ".dat", ".bin", ".vol"].iter().any(|end| stem.ends_with(end)) => {
            let remedy =
                "say of what: --raw-dims X,Y,Z --raw-type u16 for voxels, --raw-layout x,y,z,radius for particles";
            return Err(LoadError::new(file, "this is in no format that Mobula knows", remedy));
        }
        Some(format) => format!("this is in {format} format, which Mobula cannot load"),
        None if start.is_empty() => "the file is empty".into(),
        None => "this is in no format that Mobula knows".into(),
    };
    Err(LoadError::new(file, problem, supported()))
}

/// The name of a format that we know but cannot load.
fn known_format(start: &[u8], name: &str) -> Option<&'static str> {
    const MAGIC: [(&[u8], &str); 6] = [
        (b"PK\x03\x04", "ZIP"),
        (b"\x89PNG", "PNG"),
        (b"<?xml", "XML"),
        (b"# vtk DataFile", "VTK"),
        (b"\x89HDF", "HDF5"),
        (b"CDF", "NetCDF"),
    ];
    const EXTENSIONS: [(&str, &str); 4] =
        [(".fbx", "FBX"), (".dcm", "DICOM"), (".3ds", "3DS"), (".mtl", "material (MTL)")];
    let magic = MAGIC.iter().find(|(magic, _)| start.starts_with(magic)).map(|&(_, format)| format);
    magic.or_else(|| EXTENSIONS.iter().find(|(end, _)| name.ends_with(end)).map(|&(_, format)| format))
}
