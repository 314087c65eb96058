//! Materials of OBJ files (MTL), through `tobj`.

use std::collections::{HashMap, HashSet};
use std::ffi::OsString;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;

use super::lines::{CheckedLines, Stop};
use super::mtl_check::MtlCheck;
use super::text::quoted;
use super::{LoadError, input};
use crate::material::{Flat, Lambertian, Material, NamedMaterial, Phong};
use crate::progress::Progress;

/// Names beyond this many are not looked for: one statement may hold a great many.
const MOST_NAMES: usize = 1024;
/// Files beyond this many are left out.
const MOST_FILES: usize = 64;

/// The materials of all MTL files that an OBJ file names.
#[derive(Default)]
pub(super) struct Library {
    pub(super) materials: Vec<NamedMaterial>,
    /// Is a file not there, or are some left out?
    pub(super) missing: bool,
    /// What people should know.
    pub(super) warnings: Vec<String>,
    numbers: HashMap<String, u32>,
    /// Files that are loaded: exporters repeat statements.
    loaded: HashSet<PathBuf>,
}

impl Library {
    /// Loads what the `mtllib` statements of an OBJ file name, each file once. A missing file is a warning.
    pub(super) fn of(obj: &Path, statements: &[String]) -> Result<Self, LoadError> {
        let mut library = Self::default();
        let (mut said, mut seen) = (HashSet::new(), HashSet::new());
        for statement in statements.iter().filter(|&statement| said.insert(statement)).take(MOST_NAMES) {
            // A statement is a name with spaces, if there is such a file, or several names.
            let whole = statement.trim_matches(['"', '\'']);
            let bare = statement.split_once(" #").map_or(&**statement, |(name, _)| name.trim());
            let names = if find(obj, whole).is_some() { vec![whole] } else { words(bare) };
            for name in names {
                if seen.len() >= MOST_NAMES || !seen.insert(name) {
                    continue;
                }
                let Some(path) = find(obj, name) else {
                    library.missing = true;
                    let name = quoted(name);
                    let folder = obj.parent().unwrap_or(Path::new(""));
                    let other = name.len() < 200 && folder.join(name.trim_matches('\'')).exists();
                    let why = if other { "is no file that may be read" } else { "is not there" };
                    library.warnings.push(format!("{}: material file {name} {why}; grey is used", obj.display()));
                    continue;
                };
                let same = path.canonicalize().unwrap_or_else(|_| path.clone());
                if library.loaded.contains(&same) {
                    continue;
                }
                if library.loaded.len() >= MOST_FILES {
                    library.missing = true;
                    continue;
                }
                library.loaded.insert(same);
                if let Err(error) = library.add(&path) {
                    // As if it were not there: the mesh can be seen without.
                    library.missing = true;
                    library.warnings.push(format!("{error}; grey is used"));
                }
            }
        }
        Ok(library)
    }

    /// Loads the materials of an MTL file. A name that is there already keeps its first meaning.
    fn add(&mut self, file: &Path) -> Result<(), LoadError> {
        let mut input = input::open(file, &Progress::default())?;
        let mut lines = CheckedLines::new(&mut input.reader, MtlCheck::default());
        let parsed = tobj::load_mtl_buf(&mut lines);
        let (check, stop, line) = (lines.check, lines.stop, lines.lines.number);
        if let Some(stop) = stop {
            // What was read before is used.
            self.missing = true;
            self.warnings.push(format!("{}; what follows in it is left out", stop.into_error(file, line, input.gzip)));
        }
        let parsed = parsed.map_err(|error| LoadError::new(file, error.to_string(), "check it in a text editor"));
        for material in &parsed?.0 {
            if !self.numbers.contains_key(&material.name) {
                self.numbers.insert(material.name.clone(), self.materials.len() as u32);
                self.materials.push(describe(material));
            }
        }
        self.warnings.extend(check.warnings(file));
        self.warnings.extend(input.warning(file));
        Ok(())
    }

    /// The material that a `usemtl` statement names; a comment may follow the name.
    pub(super) fn index_of(&self, name: &str) -> Option<u32> {
        let bare = || name.split_once(" #").and_then(|(name, _)| self.numbers.get(name.trim()));
        self.numbers.get(name).or_else(bare).copied()
    }
}

/// The names in a statement, of which some may be quoted.
fn words(statement: &str) -> Vec<&str> {
    let mut words = Vec::new();
    let mut rest = statement.trim_start();
    while !rest.is_empty() {
        let (word, after) = match rest.strip_prefix(['"', '\'']) {
            Some(quoted) => quoted.split_once(['"', '\'']).unwrap_or((quoted, "")),
            None => rest.split_once(char::is_whitespace).unwrap_or((rest, "")),
        };
        words.extend((!word.is_empty()).then_some(word));
        rest = after.trim_start();
    }
    words
}

/// The file that an OBJ file at `obj` calls `name`, if it is beside it or in a folder beside it. Exporters write paths of their own
/// machine: then the bare file name counts, and last its letters whether large or small.
fn find(obj: &Path, name: &str) -> Option<PathBuf> {
    let folder = obj.parent().unwrap_or(Path::new(""));
    let name = name.replace('\\', "/");
    let path = Path::new(&name);
    let bare = Path::new(path.file_name()?);
    let beside = path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    let exact = [beside.then_some(path), Some(bare)].into_iter().flatten().map(|path| folder.join(path));
    let found = exact.into_iter().find(|path| input::is_regular(path)).or_else(|| {
        let alike = beside.then(|| alike(folder, path)).flatten();
        alike.or_else(|| self::alike(folder, bare)).filter(|path| input::is_regular(path))
    })?;
    // A link may not lead out of the folder that the model is in.
    let inside = |found: &Path| {
        let real = found.canonicalize().ok()?;
        let folders =
            [Path::new(".").join(folder).canonicalize().ok(), obj.canonicalize().ok()?.parent().map(Path::to_owned)];
        folders.into_iter().flatten().any(|folder| real.starts_with(folder)).then_some(())
    };
    inside(&found).map(|()| found)
}

/// The file or folder at a path in a folder whose names differ at most in whether letters are large or small; the first by name,
/// whatever order the disk has.
fn alike(folder: &Path, path: &Path) -> Option<PathBuf> {
    let mut found = folder.to_owned();
    for part in path.components().filter(|part| matches!(part, Component::Normal(_))) {
        let wanted = part.as_os_str().to_string_lossy().to_lowercase();
        let entries = fs::read_dir(Path::new(".").join(&found)).ok()?;
        let names = entries.filter_map(|entry| entry.ok().map(|entry| entry.file_name()));
        found.push(names.filter(|name: &OsString| name.to_string_lossy().to_lowercase() == wanted).min()?);
    }
    Some(found)
}

impl Stop {
    /// The error at the line of `file` where reading stopped.
    pub(super) fn into_error(self, file: &Path, line: u64, gzip: bool) -> LoadError {
        let (problem, remedy) = match self {
            Self::Fault(fault) => (fault.problem, fault.remedy),
            Self::Io(error) => input::explain(&error, gzip),
        };
        LoadError::new(file, problem, remedy).at(line.max(1))
    }
}

/// What a material of an MTL file looks like.
pub(super) fn describe(material: &tobj::Material) -> NamedMaterial {
    let colour = |c: Option<[f32; 3]>, default: f32| Vec3::from(c.unwrap_or([default; 3])).clamp(Vec3::ZERO, Vec3::ONE);
    let diffuse = colour(material.diffuse, 0.7);
    let specular = colour(material.specular, 0.0);
    let emission = Vec3::from(material.emissive.unwrap_or_default()).max(Vec3::ZERO);
    let transparency = (1.0 - material.dissolve.unwrap_or(1.0)).clamp(0.0, 1.0);
    let refractive_index = material.optical_density.unwrap_or(1.5).clamp(1.0, 10.0);
    // Models 3 to 9 mirror. Of glass, only what Fresnel's equations say: its Ks means the highlight.
    let mirrors = material.illumination_model.is_some_and(|model| (3..=9).contains(&model));
    let reflection = match (mirrors, transparency > 0.0) {
        (false, _) => 0.0,
        (true, true) => ((refractive_index - 1.0) / (refractive_index + 1.0)).powi(2),
        (true, false) => specular.max_element(),
    };
    let plain = specular == Vec3::ZERO || material.illumination_model.is_some_and(|model| model < 2);
    let described: Arc<dyn Material> = if emission != Vec3::ZERO {
        Arc::new(Flat { color: emission })
    } else if plain && transparency == 0.0 && reflection == 0.0 {
        Arc::new(Lambertian { diffuse })
    } else {
        Arc::new(Phong {
            diffuse,
            specular: if plain { Vec3::ZERO } else { specular },
            shininess: material.shininess.unwrap_or(30.0).clamp(0.0, 10_000.0),
            reflection,
            transparency,
            refractive_index,
        })
    };
    NamedMaterial { name: material.name.clone(), material: described }
}
