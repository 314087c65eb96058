//! In each crate, imports run one way: no file uses one that uses it, directly or through others; and the table "# Map" in
//! the documentation of its root names every public module, above all that it uses.
//!
//! What counts as the use of a file: a `use`, or a path in the code, of what that file defines, wherever it is re-exported.
//! A parent does not use its children by declaring and re-exporting them, and tests use what they like.

mod imports;
mod made_up;
mod rules;
mod source;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use source::Files;

/// Violations that are there today. One that is mended must go from here.
const KNOWN: &[&str] = &[];

#[test]
fn imports_run_one_way_and_as_the_maps_say() {
    let mut wrong = String::new();
    let mut known: BTreeSet<&str> = KNOWN.iter().copied().collect();
    for package in ["simd", "core", "engine"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(package).join("src");
        let mut files = Files::new();
        read_folder(&folder, "", &mut files);
        for violation in rules::violations(package, &files) {
            if !known.remove(violation.name.as_str()) {
                wrong += &format!("{}\n{}", violation.name, violation.places);
            }
        }
    }
    for mended in known {
        wrong += &format!("no longer there, so take it from KNOWN: {mended}\n");
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// Reads all Rust files in a folder and below.
fn read_folder(folder: &Path, prefix: &str, files: &mut Files) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{prefix}{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            read_folder(&path, &format!("{name}/"), files);
        } else if name.ends_with(".rs") {
            files.insert(name, fs::read_to_string(&path).unwrap());
        }
    }
}
