//! NRRD files, after <https://teem.sourceforge.net/nrrd/format.html>: with their voxels behind the header (`.nrrd`) or in files beside
//! it (`.nhdr`); raw, gzip and text.

use std::path::Path;

use super::fields::{Field, Fields, LONGEST_LINE, Wrong};
use super::filling::filling;
use super::header::{self, Header, check_place};
use super::layout::Layout;
use super::nrrd_axes::Axes;
use super::source::{MOST_FILES, Packing, Source, numbered, repeated};
use super::{VoxelType, read};
use crate::load::input::Input;
use crate::load::lines::Lines;
use crate::load::loaded::Loaded;
use crate::load::text::quoted;
use crate::load::{LoadError, Options};

/// How files start.
const MAGIC: &str = "NRRD";
/// The last version of the format.
const LAST_VERSION: u32 = 5;

/// Does the start of a file look like NRRD?
pub(crate) fn looks_like(start: &[u8]) -> bool {
    start.starts_with(MAGIC.as_bytes())
}

/// Loads an NRRD file, and the files that it names.
pub(crate) fn load(file: &Path, mut input: Input, options: &Options) -> Result<Loaded, LoadError> {
    let mut source = Source::of(file, &mut input);
    let format = if input.gzip { "NRRD, gzip" } else { "NRRD" };
    let fields = read_fields(file, &mut source)?;
    let mut warnings = fields.warnings(file);
    let (header, stored) = fields.understand(file, &mut warnings).map_err(|wrong| wrong.into_error(file))?;
    let format = if stored.encoding == Encoding::Gzip { "NRRD, gzip" } else { format };

    let bytes = header.layout.bytes(header.kind);
    let mut filling = filling(header.kind, &header.layout);
    let mut read = |mut source: Source, parts: u64| -> Result<(), LoadError> {
        source.skip_lines(stored.skipped_lines)?;
        if stored.encoding == Encoding::Gzip {
            source = source.unpack(Packing::Gzip);
        }
        source.skip_bytes(match (stored.skipped_bytes, source.left()) {
            (Some(count), _) => count,
            (None, Some(left)) => left.saturating_sub(bytes / parts),
            (None, None) => {
                let problem = "byte skip -1 needs a file that is not packed";
                return Err(LoadError::new(source.file(), problem, "unpack it"));
            }
        })?;
        match stored.encoding {
            Encoding::Raw | Encoding::Gzip => read::binary(&mut source, &header, &mut *filling, bytes / parts)?,
            Encoding::Text => {
                read::text(&mut source, &header, &mut *filling, header.layout.voxels() as u64 / parts)?;
            }
        }
        warnings.extend(source.rest()?);
        Ok(())
    };
    if stored.files.is_empty() {
        input.allow(bytes.saturating_add(stored.skipped_bytes.unwrap_or(0)));
        read(source, 1)?;
    } else {
        for name in &stored.files {
            read(Source::beside(file, name, options)?, stored.files.len() as u64)?;
        }
    }
    warnings.extend(input.warning(file));
    header::scene(file, format, &header, filling.finish(), options, warnings)
}

/// How voxels are stored.
#[derive(Debug)]
struct Stored {
    encoding: Encoding,
    /// The files that they are in; none: they are behind the header.
    files: Vec<String>,
    skipped_lines: u64,
    /// `None`: all but the voxels.
    skipped_bytes: Option<u64>,
}

/// How voxels are encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Raw,
    Gzip,
    Text,
}

/// The fields that matter, in lower case without spaces: the format knows several spellings.
const KNOWN: [(&str, &str); 14] = [
    ("dimension", "dimension"),
    ("type", "type"),
    ("encoding", "encoding"),
    ("endian", "endian"),
    ("datafile", "data file"),
    ("lineskip", "line skip"),
    ("byteskip", "byte skip"),
    ("sizes", "sizes"),
    ("spacings", "spacings"),
    ("axismins", "axis mins"),
    ("axismaxs", "axis maxs"),
    ("centers", "centers"),
    ("centerings", "centers"),
    ("kinds", "kinds"),
];
/// Those of the space around.
const OF_SPACE: [(&str, &str); 4] = [
    ("space", "space"),
    ("spacedimension", "space dimension"),
    ("spaceorigin", "space origin"),
    ("spacedirections", "space directions"),
];
/// Those that say nothing about where voxels are and what they stand for.
const OTHERS: [&str; 16] = [
    "content",
    "number",
    "blocksize",
    "min",
    "max",
    "oldmin",
    "oldmax",
    "thicknesses",
    "labels",
    "units",
    "sampleunits",
    "spaceunits",
    "measurementframe",
    "axisunits",
    "axislabels",
    "date",
];

/// The fields of a header.
#[derive(Debug, Default)]
pub(super) struct NrrdFields {
    pub(super) fields: Fields,
    /// Names of files, one a line.
    listed: Vec<String>,
    /// Fields that are not known: how many, the first and its line.
    unknown: Option<(u64, String, u64)>,
    last: u64,
}

fn read_fields(file: &Path, source: &mut Source) -> Result<NrrdFields, LoadError> {
    let packed = source.is_packed();
    let mut lines = Lines::no_longer_than(LONGEST_LINE, source);
    let mut fields = NrrdFields::default();
    loop {
        let next = lines.next(|_| false);
        let line = match next {
            Ok(Some((_, line))) => line.trim_end().to_owned(),
            Ok(None) => break,
            Err(stop) => return Err(stop.into_error(file, lines.number, packed)),
        };
        fields.last = lines.number;
        // Behind a list there is nothing else.
        let listing = fields.fields.get("data file").is_some_and(|field| field.value.starts_with("LIST"));
        if line.is_empty() && !listing {
            break;
        }
        let added = if lines.number == 1 { check_magic(&line) } else { fields.add(&line, listing) };
        added.map_err(|wrong| wrong.into_error(file))?;
    }
    if fields.last == 0 {
        return Err(Wrong::new(1, "the file is empty", "name a file with voxels in it").into_error(file));
    }
    Ok(fields)
}

fn check_magic(line: &str) -> Result<(), Wrong> {
    let version = line.strip_prefix(MAGIC).filter(|digits| digits.len() == 4).and_then(|digits| digits.parse().ok());
    match version {
        Some(1..=LAST_VERSION) => Ok(()),
        Some(version) => {
            let problem = format!("version {version} of NRRD is not known; the last is {LAST_VERSION}");
            Err(Wrong::new(1, problem, "write it as an older version"))
        }
        None => {
            let problem = format!("not an NRRD file: it starts with {}, not NRRD0005", quoted(line));
            Err(Wrong::new(1, problem, "check that it is what its name says"))
        }
    }
}

impl NrrdFields {
    fn add(&mut self, line: &str, listing: bool) -> Result<(), Wrong> {
        let number = self.last;
        if line.starts_with('#') {
            return Ok(());
        }
        if listing {
            if self.listed.len() >= MOST_FILES {
                return Err(Wrong::new(number, format!("more than {MOST_FILES} data files"), "join some"));
            }
            self.listed.extend((!line.is_empty()).then(|| line.to_owned()));
            return Ok(());
        }
        // What comes first says whether it is a field or a key of somebody's.
        let Some((name, value)) = line.split_once(':') else {
            let problem = format!("{} is no field of NRRD, which has a colon behind its name", quoted(line));
            return Err(Wrong::new(number, problem, "end the header with an empty line"));
        };
        if value.starts_with('=') {
            return Ok(());
        }
        let name: String = name.chars().filter(|c| !c.is_whitespace()).collect::<String>().to_ascii_lowercase();
        if let Some((_, known)) = KNOWN.iter().chain(&OF_SPACE).find(|(spelling, _)| *spelling == name) {
            return self.fields.add(known, value, number);
        }
        if !OTHERS.contains(&name.as_str()) {
            match &mut self.unknown {
                Some((count, ..)) => *count += 1,
                None => self.unknown = Some((1, quoted(&name), number)),
            }
        }
        Ok(())
    }

    fn warnings(&self, file: &Path) -> Vec<String> {
        let warning = |(count, name, line): &(u64, String, u64)| {
            let others = if *count > 1 { format!(" and {} other fields", count - 1) } else { String::new() };
            format!("{}:{line}: {name}{others}, which NRRD does not know, is left out", file.display())
        };
        self.unknown.iter().map(warning).collect()
    }

    /// What they say of the voxels.
    fn understand(&self, file: &Path, warnings: &mut Vec<String>) -> Result<(Header, Stored), Wrong> {
        let fields = &self.fields;
        let dimension = fields.required("dimension", self.last)?;
        let dimension = match dimension.size(&dimension.value)? {
            count @ 0..3 => {
                let problem = format!("is {count}: a volume has three dimensions");
                return Err(dimension.wrong(problem, "pictures and lines cannot be loaded"));
            }
            count => count,
        };
        let kind = voxel_type(fields.required("type", self.last)?)?;
        let sizes = fields.required("sizes", self.last)?;
        let count = usize::try_from(dimension).ok().filter(|&count| count <= 16);
        let count = count.ok_or_else(|| {
            Wrong::new(self.last, format!("it has {dimension} dimensions, not 3 to 16"), "check how it was written")
        })?;
        let words = sizes.so_many_words(count)?;
        let sizes_of = words.into_iter().map(|word| sizes.size(word)).collect::<Result<Vec<_>, _>>()?;

        let axes = Axes::of(fields, &sizes_of)?;
        warnings.extend(axes.warning.map(|text| format!("{}: {text}", file.display())));
        let dims = axes.in_space.map(|axis| sizes_of[axis]);
        let steps = axes.in_time.map_or(1, |axis| sizes_of[axis]);
        let before = |time: usize| axes.in_space.iter().filter(|&&axis| axis < time).count();
        let layout = Layout::new(dims, steps, axes.in_time.map_or(3, before)).map_err(|fault| sizes.at(fault))?;
        let placed_by = axes.placed_by.unwrap_or(sizes);
        check_place(&axes.place).map_err(|fault| placed_by.at(fault))?;

        let stored = self.stored(&layout)?;
        let big_endian = match fields.get("endian") {
            Some(endian) => match endian.value.to_ascii_lowercase().as_str() {
                "little" => false,
                "big" => true,
                _ => return Err(endian.wrong(format!("is {}", quoted(&endian.value)), "it is little or big")),
            },
            None => {
                if kind.bytes() > 1 && stored.encoding != Encoding::Text {
                    let file = file.display();
                    warnings.push(format!("{file}: the header has no 'endian'; little is assumed"));
                }
                false
            }
        };
        let header = Header { layout, kind, big_endian, place: axes.place, scale: [1.0, 0.0], up: axes.up };
        Ok((header, stored))
    }

    fn stored(&self, layout: &Layout) -> Result<Stored, Wrong> {
        let fields = &self.fields;
        let field = fields.required("encoding", self.last)?;
        let encoding = match field.value.to_ascii_lowercase().as_str() {
            "raw" => Encoding::Raw,
            "gz" | "gzip" => Encoding::Gzip,
            "txt" | "text" | "ascii" => Encoding::Text,
            "hex" | "bz2" | "bzip2" | "zrl" => {
                return Err(field.wrong(format!("{} is not supported", field.value), "write it as raw, gzip or ascii"));
            }
            _ => {
                let problem = format!("{} is not known", quoted(&field.value));
                return Err(field.wrong(problem, "write it as raw, gzip or ascii"));
            }
        };
        let skipped_lines = fields.get("line skip").map(|field| field.size(&field.value)).transpose()?.unwrap_or(0);
        let skipped_bytes = match fields.get("byte skip") {
            None => Some(0),
            Some(field) => match field.whole(&field.value)? {
                -1 if encoding == Encoding::Raw => None,
                -1 => return Err(field.wrong("-1 is for raw voxels only", "give the number of bytes")),
                count => Some(u64::try_from(count).map_err(|_| field.wrong("is negative", "give 0 or more, or -1"))?),
            },
        };
        let files = self.files(layout)?;
        Ok(Stored { encoding, files, skipped_lines, skipped_bytes })
    }

    /// The files that voxels are in.
    fn files(&self, layout: &Layout) -> Result<Vec<String>, Wrong> {
        let Some(field) = self.fields.get("data file") else { return Ok(Vec::new()) };
        let words = field.words();
        let files = if words.first() == Some(&"LIST") {
            self.listed.clone()
        } else if let Some((pattern, range)) = pattern(&field.value) {
            let files = numbered(pattern, range);
            files.ok_or_else(|| field.wrong("is no pattern with numbers", "write it like name%03d.raw 1 100 1"))?
        } else {
            vec![field.value.clone()]
        };
        if files.is_empty() || !layout.voxels().is_multiple_of(files.len()) {
            let problem = format!("names {} files, which cannot share {} voxels", files.len(), layout.voxels());
            return Err(field.wrong(problem, "name one file, or one for each slice or step"));
        }
        if let Some(name) = repeated(&files) {
            return Err(field.wrong(format!("names {} twice", quoted(name)), "name each file once"));
        }
        Ok(files)
    }
}

/// A pattern of names and its numbers: `name%03d.raw 1 100 1`, where a fourth number may follow.
fn pattern(value: &str) -> Option<(&str, [i64; 3])> {
    let (pattern, rest) = value.split_once(char::is_whitespace)?;
    let numbers: Vec<i64> = rest.split_whitespace().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    match numbers[..] {
        [first, last, step] | [first, last, step, _] if pattern.contains('%') => Some((pattern, [first, last, step])),
        _ => None,
    }
}

/// The type by any of its names.
fn voxel_type(field: &Field) -> Result<VoxelType, Wrong> {
    let name = field.words().join(" ").to_ascii_lowercase();
    Ok(match name.as_str() {
        "signed char" | "int8" | "int8_t" => VoxelType::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => VoxelType::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => VoxelType::I16,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => VoxelType::U16,
        "int" | "signed int" | "int32" | "int32_t" => VoxelType::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => VoxelType::U32,
        "float" => VoxelType::F32,
        "double" => VoxelType::F64,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t"
        | "ulonglong"
        | "unsigned long long"
        | "unsigned long long int"
        | "uint64"
        | "uint64_t" => {
            return Err(field.wrong(
                format!("{name} is not supported: integers have at most 32 bits"),
                "write it as int32 or double",
            ));
        }
        "block" => {
            return Err(field.wrong("block is not supported: each voxel must be one number", "write it as float"));
        }
        _ => {
            let problem = format!("{} is not known", quoted(&name));
            return Err(field.wrong(problem, "it is one of uint8, int8, uint16, int16, uint32, int32, float, double"));
        }
    })
}
