//! Files that a model names: they are beside it.

use std::ffi::OsString;
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::input;

/// The file that a model calls `name`, if it is beside the model or in a folder beside it. Exporters write paths of their own
/// machine: then the bare file name counts, and last its letters whether large or small.
pub(super) fn beside(model: &Path, name: &str) -> Option<PathBuf> {
    let folder = model.parent().unwrap_or(Path::new(""));
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
            [Path::new(".").join(folder).canonicalize().ok(), model.canonicalize().ok()?.parent().map(Path::to_owned)];
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
