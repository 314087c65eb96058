//! Materials of OBJ files (MTL), through `tobj`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;

use super::lines::{CheckedLines, Stop};
use super::mtl_check::MtlCheck;
use super::{LoadError, input};
use crate::material::{Flat, Lambertian, Material, NamedMaterial, Phong};

/// Materials and the index of each name, as `tobj` wants them.
pub(super) type Materials = (Vec<tobj::Material>, HashMap<String, usize>);

/// The MTL file that an OBJ file at `obj` calls `name`, if it exists: in the OBJ file's folder. Exporters write paths
/// of their own machine, so the bare file name is tried too.
pub(super) fn find(obj: &Path, name: &str) -> Option<PathBuf> {
    let folder = obj.parent().unwrap_or(Path::new(""));
    let bare = name.rsplit(['/', '\\']).next().unwrap_or(name);
    [name, bare].into_iter().filter(|n| !n.is_empty()).map(|n| folder.join(n)).find(|path| input::is_regular(path))
}

/// Loads the materials of an MTL file; adds to `warnings` what was left out.
pub(super) fn load(file: &Path, warnings: &mut Vec<String>) -> Result<Materials, LoadError> {
    let input = input::open(file)?;
    let mut lines = CheckedLines::new(input.reader, MtlCheck::default());
    let parsed = tobj::load_mtl_buf(&mut lines);
    if let Some(stop) = lines.stop {
        return Err(stop.into_error(file, lines.number, input.gzip));
    }
    if lines.check.textures > 0 {
        let count = lines.check.textures;
        warnings.push(format!("{}: {count} texture maps are left out; materials keep their colours", file.display()));
    }
    parsed.map_err(|e| LoadError::new(file, e.to_string(), "export the materials again").at(lines.number))
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
