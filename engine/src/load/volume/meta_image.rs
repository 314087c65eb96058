//! MetaImage files, after <https://itk.org/Wiki/ITK/MetaIO>: a header with voxels behind it (`.mha`), or in files beside it (`.mhd`).

use std::path::Path;

use glam::DVec3;

use super::fields::{Field, Fields, LONGEST_LINE, Wrong};
use super::filling::filling;
use super::header::{self, Header, check_place};
use super::layout::Layout;
use super::source::{MOST_FILES, Source, numbered, repeated};
use super::{VoxelType, read};
use crate::load::input::Input;
use crate::load::lines::Lines;
use crate::load::loaded::Loaded;
use crate::load::text::quoted;
use crate::load::{LoadError, Options};
use crate::volume::GridPlace;

/// The fields that matter, as they are called here and by programs.
const KNOWN: [(&str, &[&str]); 13] = [
    ("ObjectType", &["ObjectType"]),
    ("NDims", &["NDims"]),
    ("DimSize", &["DimSize"]),
    ("ElementType", &["ElementType"]),
    ("ElementDataFile", &["ElementDataFile"]),
    ("ElementSpacing", &["ElementSpacing"]),
    ("ElementSize", &["ElementSize"]),
    ("ElementNumberOfChannels", &["ElementNumberOfChannels"]),
    ("Offset", &["Offset", "Origin", "Position"]),
    ("TransformMatrix", &["TransformMatrix", "Rotation", "Orientation"]),
    ("BinaryData", &["BinaryData"]),
    ("CompressedData", &["CompressedData"]),
    ("HeaderSize", &["HeaderSize"]),
];
const BYTE_ORDER: [&str; 2] = ["BinaryDataByteOrderMSB", "ElementByteOrderMSB"];
const SLOPE: [&str; 2] = ["ElementToIntensityFunctionSlope", "ElementToIntensityFunctionOffset"];

/// Does the start of a file look like MetaImage?
pub(crate) fn looks_like(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let key = text.split_once('=').map(|(key, _)| key.trim());
    key.is_some_and(|key| ["ObjectType", "NDims"].contains(&key))
}

/// Loads a MetaImage file, and the files that it names.
pub(crate) fn load(file: &Path, mut input: Input, options: &Options) -> Result<Loaded, LoadError> {
    let mut source = Source::of(file, &mut input);
    let meta = Meta::read(file, &mut source)?;
    let (header, stored) = meta.understand().map_err(|wrong| wrong.into_error(file))?;

    let bytes = header.layout.bytes(header.kind);
    let mut filling = filling(header.kind, &header.layout);
    let mut warnings = Vec::new();
    let mut read = |mut source: Source, parts: u64| -> Result<(), LoadError> {
        source.skip_bytes(match (stored.skipped, source.left()) {
            (Some(count), _) => count,
            (None, Some(left)) => left.saturating_sub(bytes / parts),
            (None, None) => {
                let problem = "HeaderSize -1 needs a file that is not packed";
                return Err(LoadError::new(source.file(), problem, "unpack it"));
            }
        })?;
        if stored.packed {
            source = source.unpack_any()?;
        }
        if stored.text {
            read::text(&mut source, &header, &mut *filling, header.layout.voxels() as u64 / parts)?;
        } else {
            read::binary(&mut source, &header, &mut *filling, bytes / parts)?;
        }
        warnings.extend(source.rest()?);
        Ok(())
    };
    if stored.files.is_empty() {
        input.allow(bytes.saturating_add(stored.skipped.unwrap_or(0)));
        read(source, 1)?;
    } else {
        for name in &stored.files {
            read(Source::beside(file, name, options)?, stored.files.len() as u64)?;
        }
    }
    warnings.extend(input.warning(file));
    let format = match (input.gzip, stored.packed) {
        (true, _) => "MetaImage, gzip",
        (_, true) => "MetaImage, zlib",
        _ => "MetaImage",
    };
    header::scene(file, format, &header, filling.finish(), options, warnings)
}

/// How voxels are stored.
struct Stored {
    /// The files that they are in; none: they are behind the header.
    files: Vec<String>,
    packed: bool,
    text: bool,
    /// Bytes before them; `None`: all but the voxels.
    skipped: Option<u64>,
}

/// A header.
#[derive(Default)]
struct Meta {
    fields: Fields,
    /// Names of files, one a line.
    listed: Vec<String>,
    last: u64,
}

impl Meta {
    fn read(file: &Path, source: &mut Source) -> Result<Self, LoadError> {
        let packed = source.is_packed();
        let mut lines = Lines::no_longer_than(LONGEST_LINE, source);
        let mut meta = Self::default();
        loop {
            let data = meta.fields.get("ElementDataFile").map(|field| field.value.as_str());
            // Behind a list of files there is nothing else, behind the name of one may be anything.
            let listing = data.is_some_and(|name| name.starts_with("LIST"));
            if data.is_some() && !listing {
                break;
            }
            let line = match lines.next(|_| false) {
                Ok(Some((_, line))) => line.trim().to_owned(),
                Ok(None) => break,
                Err(stop) => return Err(stop.into_error(file, lines.number, packed)),
            };
            meta.last = lines.number;
            meta.add(&line, listing).map_err(|wrong| wrong.into_error(file))?;
        }
        if meta.last == 0 {
            return Err(Wrong::new(1, "the file is empty", "name a file with voxels in it").into_error(file));
        }
        Ok(meta)
    }

    fn add(&mut self, line: &str, listing: bool) -> Result<(), Wrong> {
        if line.is_empty() || line.starts_with('#') {
            return Ok(());
        }
        if listing {
            if self.listed.len() >= MOST_FILES {
                return Err(Wrong::new(self.last, format!("more than {MOST_FILES} data files"), "join some"));
            }
            self.listed.push(line.to_owned());
            return Ok(());
        }
        let Some((key, value)) = line.split_once('=').map(|(key, value)| (key.trim(), value)) else {
            let problem = format!("{} is no field of MetaImage, which has an equals sign", quoted(line));
            return Err(Wrong::new(self.last, problem, "check that it is what its name says"));
        };
        let known = KNOWN.iter().find(|(_, names)| names.contains(&key)).map(|(name, _)| *name);
        let other = || BYTE_ORDER.into_iter().chain(SLOPE).find(|name| *name == key);
        // Programs write some of the fields that say the same, with one value.
        match known.or_else(other) {
            Some(name) if self.fields.get(name).is_some_and(|field| field.value == value.trim()) => Ok(()),
            Some(name) => self.fields.add(name, value, self.last),
            None => Ok(()),
        }
    }

    fn understand(&self) -> Result<(Header, Stored), Wrong> {
        let (fields, last) = (&self.fields, self.last);
        if let Some(field) = fields.get("ObjectType").filter(|field| !field.value.eq_ignore_ascii_case("image")) {
            return Err(field.wrong(format!("is {}", quoted(&field.value)), "name a file whose ObjectType is Image"));
        }
        let dimensions = fields.required("NDims", last)?;
        let count = match dimensions.size(&dimensions.value)? {
            count @ 3..=4 => count as usize,
            count @ 0..3 => {
                let problem = format!("is {count}: a volume has three dimensions");
                return Err(dimensions.wrong(problem, "pictures and lines cannot be loaded"));
            }
            count => return Err(dimensions.wrong(format!("is {count}"), "cut all but space and time")),
        };
        if let Some(field) = fields.get("ElementNumberOfChannels").filter(|field| field.value != "1") {
            let problem = format!("is {}: a voxel must be one number", quoted(&field.value));
            return Err(field.wrong(problem, "write each component into a file of its own"));
        }
        let size = fields.required("DimSize", last)?;
        let words = size.so_many_words(count)?;
        let sizes = words.into_iter().map(|word| size.size(word)).collect::<Result<Vec<_>, _>>()?;
        let steps = sizes.get(3).copied().unwrap_or(1);
        let layout = Layout::new([sizes[0], sizes[1], sizes[2]], steps, 3).map_err(|fault| size.at(fault))?;
        let place = self.place(count)?;
        let kind = voxel_type(fields.required("ElementType", last)?)?;
        let big_endian = fields.any(&BYTE_ORDER).map(truth).transpose()?.unwrap_or(false);
        let header = Header { layout, kind, big_endian, place, scale: self.scale()?, up: None };
        Ok((header, self.stored(&layout)?))
    }

    fn place(&self, count: usize) -> Result<GridPlace, Wrong> {
        let fields = &self.fields;
        let spacing = fields.any(&["ElementSpacing", "ElementSize"]);
        let spacings = spacing.map(|field| field.numbers(count)).transpose()?.unwrap_or(vec![1.0; count]);
        let mut place = GridPlace::with_spacing([spacings[0], spacings[1], spacings[2]]);
        if let Some(field) = spacing {
            check_place(&place).map_err(|fault| field.at(fault))?;
        }
        if let Some(field) = fields.get("TransformMatrix") {
            let numbers = field.numbers(count * count)?;
            for axis in 0..3 {
                let row = &numbers[axis * count..];
                place.axes[axis] = DVec3::new(row[0], row[1], row[2]) * spacings[axis];
            }
            check_place(&place).map_err(|fault| field.at(fault))?;
        }
        if let Some(field) = fields.get("Offset") {
            let numbers = field.numbers(count)?;
            place.origin = DVec3::new(numbers[0], numbers[1], numbers[2]);
            check_place(&place).map_err(|fault| field.at(fault))?;
        }
        Ok(place)
    }

    /// What voxels are multiplied by, and what is added then.
    fn scale(&self) -> Result<[f64; 2], Wrong> {
        let [slope, offset] = SLOPE.map(|name| {
            let Some(field) = self.fields.get(name) else { return Ok(None) };
            let number = field.number(&field.value)?;
            if number.is_finite() { Ok(Some(number)) } else { Err(field.wrong("is not finite", "leave it out")) }
        });
        let slope = slope?.filter(|&slope| slope != 0.0);
        Ok([slope.unwrap_or(1.0), offset?.unwrap_or(0.0)])
    }

    fn stored(&self, layout: &Layout) -> Result<Stored, Wrong> {
        let fields = &self.fields;
        let field = fields.required("ElementDataFile", self.last)?;
        let words = field.words();
        let files = match words[..] {
            ["LOCAL" | "Local" | "local"] => None,
            ["LIST", ..] => Some(self.listed.clone()),
            [pattern, ref numbers @ ..] if pattern.contains('%') && !numbers.is_empty() => {
                let numbers = numbers.iter().map(|word| field.whole(word)).collect::<Result<Vec<_>, _>>()?;
                let range = match numbers[..] {
                    [first, last] => Some([first, last, 1]),
                    [first, last, step] => Some([first, last, step]),
                    _ => None,
                };
                let names = range.and_then(|range| numbered(pattern, range));
                let wrong = || field.wrong("is no pattern with numbers", "write it like name%03d.raw 1 100 1");
                Some(names.ok_or_else(wrong)?)
            }
            _ => Some(vec![field.value.clone()]),
        };
        let count = files.as_ref().map_or(1, Vec::len);
        if count == 0 || !layout.voxels().is_multiple_of(count) {
            let problem = format!("names {count} files, which cannot share {} voxels", layout.voxels());
            return Err(field.wrong(problem, "name one file, or one for each slice"));
        }
        if let Some(name) = files.as_deref().and_then(repeated) {
            return Err(field.wrong(format!("names {} twice", quoted(name)), "name each file once"));
        }
        let packed = fields.get("CompressedData").map(truth).transpose()?.unwrap_or(false);
        let text = !fields.get("BinaryData").map(truth).transpose()?.unwrap_or(true);
        let skipped = match fields.get("HeaderSize") {
            None => Some(0),
            Some(field) => match field.whole(&field.value)? {
                -1 if !packed && !text => None,
                count => {
                    Some(u64::try_from(count).map_err(|_| field.wrong("is negative", "give the number of bytes"))?)
                }
            },
        };
        Ok(Stored { files: files.unwrap_or_default(), packed, text, skipped })
    }
}

/// Is it true?
fn truth(field: &Field) -> Result<bool, Wrong> {
    match field.value.to_ascii_lowercase().as_str() {
        "true" | "1" => Ok(true),
        "false" | "0" => Ok(false),
        _ => Err(field.wrong(format!("is {}", quoted(&field.value)), "it is True or False")),
    }
}

/// The type of a name.
fn voxel_type(field: &Field) -> Result<VoxelType, Wrong> {
    Ok(match field.value.as_str() {
        "MET_CHAR" => VoxelType::I8,
        "MET_UCHAR" => VoxelType::U8,
        "MET_SHORT" => VoxelType::I16,
        "MET_USHORT" => VoxelType::U16,
        // Four bytes, whatever a long is elsewhere.
        "MET_INT" | "MET_LONG" => VoxelType::I32,
        "MET_UINT" | "MET_ULONG" => VoxelType::U32,
        "MET_FLOAT" => VoxelType::F32,
        "MET_DOUBLE" => VoxelType::F64,
        "MET_LONG_LONG" | "MET_ULONG_LONG" => {
            let problem = format!("{} is not supported: integers have at most 32 bits", field.value);
            return Err(field.wrong(problem, "write it as MET_INT or MET_DOUBLE"));
        }
        array if array.ends_with("_ARRAY") => {
            return Err(field.wrong(format!("{} is not supported", quoted(array)), "a voxel must be one number"));
        }
        name => {
            let remedy = "it is MET_ and one of CHAR, UCHAR, SHORT, USHORT, INT, UINT, FLOAT, DOUBLE";
            return Err(field.wrong(format!("{} is not known", quoted(name)), remedy));
        }
    })
}
