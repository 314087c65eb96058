//! Materials of OBJ files (MTL), through `tobj`.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;

use super::beside::beside;
use super::lines::{CheckedLines, Stop};
use super::mtl_check::MtlCheck;
use super::mtl_maps::MapStatement;
use super::text::quoted;
use super::textures::{Decoded, Gallery, Use};
use super::{LoadError, input};
use crate::material::{Flat, Lambertian, Material, NamedMaterial, Phong, Principled};
use crate::progress::Progress;
use crate::texture::{ChannelMap, Map, Maps, NormalMap, OpacityMap};

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
    /// What the parser says of each material.
    parsed: Vec<Parsed>,
}

impl Library {
    /// Loads what the `mtllib` statements of an OBJ file name, each file once. A missing file is a warning.
    pub(super) fn of(obj: &Path, statements: &[String], progress: &Progress) -> Result<Self, LoadError> {
        let mut library = Self::default();
        let (mut said, mut seen) = (HashSet::new(), HashSet::new());
        for statement in statements.iter().filter(|&statement| said.insert(statement)).take(MOST_NAMES) {
            // A statement is a name with spaces, if there is such a file, or several names.
            let whole = statement.trim_matches(['"', '\'']);
            let bare = statement.split_once(" #").map_or(&**statement, |(name, _)| name.trim());
            let names = if beside(obj, whole).is_some() { vec![whole] } else { words(bare) };
            for name in names {
                if seen.len() >= MOST_NAMES || !seen.insert(name) {
                    continue;
                }
                let Some(path) = beside(obj, name) else {
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
        library.describe(progress);
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
        for material in parsed?.0 {
            if !self.numbers.contains_key(&material.name) {
                self.numbers.insert(material.name.clone(), self.parsed.len() as u32);
                self.parsed.push(Parsed { material, file: file.to_owned(), blender: check.blender });
            }
        }
        self.warnings.extend(check.warnings(file));
        self.warnings.extend(input.warning(file));
        Ok(())
    }

    /// Makes the materials of what was parsed, with their textures.
    fn describe(&mut self, progress: &Progress) {
        let (mut gallery, mut missing) = (Gallery::default(), Vec::new());
        let named: Vec<NamedMaps> =
            self.parsed.iter().map(|parsed| NamedMaps::of(parsed, &mut gallery, &mut missing)).collect();
        let decoded = gallery.decode(progress);
        if let [first, others @ ..] = &missing[..] {
            let others = match others.len() {
                0 => String::new(),
                1 => ", and another".to_owned(),
                others => format!(", and {others} others"),
            };
            self.warnings.push(format!("{first}{others}; materials keep their colours"));
        }
        let broken = decoded.iter().filter_map(|result| result.as_ref().err());
        self.warnings.extend(broken.map(|error| format!("{error}; materials keep their colours")));
        let parsed = self.parsed.drain(..).zip(&named);
        self.materials = parsed.map(|(parsed, named)| describe(&parsed, named.maps(&decoded))).collect();
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

/// What the parser says of a material.
struct Parsed {
    material: tobj::Material,
    /// Where it is.
    file: PathBuf,
    /// Was that written by Blender?
    blender: bool,
}

/// Which textures a material wants: the number of each in a gallery, and how it lies on the surface.
#[derive(Debug, Default)]
struct NamedMaps {
    color: Option<(usize, MapStatement)>,
    opacity: Option<(usize, MapStatement)>,
    bumps: Option<(usize, MapStatement)>,
    specular: Option<(usize, MapStatement)>,
    emission: Option<(usize, MapStatement)>,
    roughness: Option<(usize, MapStatement)>,
    metallic: Option<(usize, MapStatement)>,
}

/// What became of them.
struct FoundMaps {
    maps: Maps,
    specular: Option<Map>,
    emission: Option<Map>,
    roughness: Option<ChannelMap>,
    metallic: Option<ChannelMap>,
}

impl NamedMaps {
    /// What a material of an MTL file names. Files that are not there are told.
    fn of(parsed: &Parsed, gallery: &mut Gallery, missing: &mut Vec<String>) -> Self {
        let (material, mtl) = (&parsed.material, &parsed.file);
        let mut want = |name: &str, what: Use| {
            let statement = MapStatement::parse(material.unknown_param.get(name)?)?;
            match beside(mtl, &statement.name) {
                Some(file) => Some((gallery.want(file, what), statement)),
                None => {
                    missing.push(format!("{}: texture {} is not there", mtl.display(), quoted(&statement.name)));
                    None
                }
            }
        };
        Self {
            color: want("texture:color", Use::Color),
            // With alpha in the picture of the colours, it is the same picture.
            opacity: want("texture:opacity", Use::Data),
            bumps: want("texture:normals", Use::Bumps).or_else(|| want("texture:bumps", Use::Bumps)),
            specular: want("texture:specular", Use::Color),
            emission: want("texture:emission", Use::Color),
            roughness: want("texture:roughness", Use::Data),
            metallic: want("texture:metallic", Use::Data),
        }
    }

    /// With the textures that could be decoded. What is opaque in part by its picture of colours alone has that as opacity.
    fn maps(&self, decoded: &Decoded) -> FoundMaps {
        let map = |wanted: &Option<(usize, MapStatement)>| {
            let (number, statement) = wanted.as_ref()?;
            let texture = decoded.get(*number)?.as_ref().ok()?.clone();
            let ([across, up], offset) = (statement.scale, statement.offset);
            Some(Map { texture, wrap: [statement.wrap; 2], turn: [[across, 0.0], [0.0, up]], offset })
        };
        let color = map(&self.color);
        let channel = |map: &Map| {
            let matte = self.opacity.as_ref().is_some_and(|(_, statement)| statement.matte);
            if matte || map.texture.has_alpha() { 3 } else { 0 }
        };
        let opacity =
            map(&self.opacity).map(|map| OpacityMap { channel: channel(&map), map, factor: 1.0, cutoff: None });
        let holes = color.clone().filter(|map| map.texture.has_alpha());
        let holes = holes.map(|map| OpacityMap { map, channel: 3, factor: 1.0, cutoff: None });
        let scale = self.bumps.as_ref().map_or(1.0, |(_, statement)| statement.bump);
        let normal = map(&self.bumps).map(|map| NormalMap { map, scale });
        let grey = |wanted| map(wanted).map(|map| ChannelMap { map, channel: 0 });
        FoundMaps {
            maps: Maps { color, normal, opacity: opacity.or(holes) },
            specular: map(&self.specular),
            emission: map(&self.emission),
            roughness: grey(&self.roughness),
            metallic: grey(&self.metallic),
        }
    }
}

/// What a material of an MTL file looks like.
fn describe(Parsed { material, blender, .. }: &Parsed, found: FoundMaps) -> NamedMaterial {
    let FoundMaps { maps, specular: specular_map, emission: emission_map, roughness, metallic } = found;
    let colour = |c: Option<[f32; 3]>, default: f32| Vec3::from(c.unwrap_or([default; 3])).clamp(Vec3::ZERO, Vec3::ONE);
    let mut diffuse = colour(material.diffuse, 0.7);
    // A texture is multiplied by the colour. Of Blender's materials it takes its place, and black would leave nothing of it.
    let instead = |color: Vec3| *blender || color == Vec3::ZERO;
    if maps.color.is_some() && instead(diffuse) {
        diffuse = Vec3::ONE;
    }
    let mut specular = colour(material.specular, 0.0);
    if specular_map.is_some() && instead(specular) {
        specular = Vec3::ONE;
    }
    let mut emission = Vec3::from(material.emissive.unwrap_or_default()).max(Vec3::ZERO);
    if emission_map.is_some() && instead(emission) {
        emission = Vec3::ONE;
    }
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
    // Physically based numbers, as exporters have added them; of light that is not the same all over, only such a material knows.
    let parameter = |name: &str| material.unknown_param.get(name).and_then(|value| value.parse::<f32>().ok());
    let (pr, pm) = (parameter("roughness"), parameter("metallic"));
    let physical = pr.is_some() || pm.is_some() || roughness.is_some() || metallic.is_some() || emission_map.is_some();
    let described: Arc<dyn Material> = if physical {
        // A texture takes the place of its number.
        let of = |map: &Option<ChannelMap>, number: Option<f32>, usual: f32| {
            if map.is_some() { 1.0 } else { number.unwrap_or(usual).clamp(0.0, 1.0) }
        };
        let plain = if specular == Vec3::ZERO { 1.0 } else { 0.5 };
        Arc::new(Principled {
            base_color: diffuse,
            metallic: of(&metallic, pm, 0.0),
            roughness: of(&roughness, pr, plain),
            emission,
            opacity: 1.0 - transparency,
            ior: refractive_index,
            maps,
            metallic_map: metallic,
            roughness_map: roughness,
            emission_map,
        })
    } else if emission != Vec3::ZERO {
        Arc::new(Flat { color: emission, maps })
    } else if plain && transparency == 0.0 && reflection == 0.0 {
        Arc::new(Lambertian { diffuse, maps })
    } else {
        Arc::new(Phong {
            diffuse,
            specular: if plain { Vec3::ZERO } else { specular },
            shininess: material.shininess.unwrap_or(30.0).clamp(0.0, 10_000.0),
            reflection,
            transparency,
            refractive_index,
            maps,
            specular_map,
        })
    };
    NamedMaterial { name: material.name.clone(), material: described }
}
