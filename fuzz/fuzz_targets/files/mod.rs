//! What the targets of file formats share: a folder to load from, and what must be true of whatever was loaded.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use mobula::load::{self, LoadError, Loaded};
use mobula::geometry::{DEFAULT_MATERIAL, Mesh, NO_INDEX};

/// A folder of this process, in memory where there is such a file system.
pub fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let memory = Path::new("/dev/shm");
        let base = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
        let folder = base.join(format!("mobula-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        folder
    })
}

/// Writes a file into the folder.
pub fn write(name: &str, bytes: &[u8]) -> PathBuf {
    let file = folder().join(name);
    std::fs::write(&file, bytes).unwrap();
    file
}

/// Removes a file from the folder.
#[allow(dead_code, reason = "not every target does")]
pub fn remove(name: &str) {
    let _ = std::fs::remove_file(folder().join(name));
}

/// Loads a file. It must be a scene that holds together, or an error of one line that names a file.
pub fn load(file: &Path) -> Result<Loaded, LoadError> {
    let loaded = load::load(file);
    match &loaded {
        Ok(Loaded { scene, report, .. }) => {
            let materials = scene.materials.len();
            let meshes = scene.geometry.iter().filter_map(|geometry| geometry.downcast_ref::<Mesh>());
            let triangles: usize = meshes.map(|mesh| check_mesh(mesh, materials)).sum();
            assert_eq!(triangles as u64, report.census.count("triangles"));
            let most = ["particles", "spheres"].map(|key| report.census.count(key)).iter().sum::<u64>();
            assert!(report.census.left_out() <= triangles as u64 + most);
            if let Some([low, high]) = report.bounds() {
                assert!((0..3).all(|k| low[k].is_finite() && high[k].is_finite() && low[k] <= high[k]));
            }
        }
        Err(error) => {
            let text = error.to_string();
            assert!(!text.trim().is_empty() && !text.contains('\n'), "{text:?}");
            assert!(text.starts_with(&*folder().to_string_lossy()), "{text:?} names no file");
        }
    }
    loaded
}

/// Every index is of something; returns the number of triangles.
fn check_mesh(mesh: &Mesh, materials: usize) -> usize {
    let count = mesh.triangles.len();
    for i in 0..count {
        assert!(mesh.corners(i).is_some(), "triangle {i} has corners that are not there");
        let material = mesh.material_of(i);
        assert!(material == DEFAULT_MATERIAL || (material as usize) < materials, "material {material}");
    }
    for (indices, values) in [
        (&mesh.triangle_normals, mesh.normals.len()),
        (&mesh.triangle_texture_coordinates, mesh.texture_coordinates.len()),
    ] {
        assert!(indices.is_empty() || indices.len() == count);
        assert!(indices.iter().flatten().all(|&i| i == NO_INDEX || (i as usize) < values));
    }
    assert!(mesh.materials.is_empty() || mesh.materials.len() == count);
    for group in &mesh.groups {
        assert!(u64::from(group.first) + u64::from(group.count) <= count as u64, "{group:?}");
    }
    count
}
