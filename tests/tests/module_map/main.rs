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
const KNOWN: &[&str] = &[
    "core: bvh uses traverse, which stands above it",
    "core: cycle bvh/block.rs -> traverse/single.rs -> bvh/block.rs",
    "core: cycle bvh/build.rs -> bvh/morton.rs -> bvh/build.rs",
    "core: cycle kernel/edges.rs -> kernel/groups.rs -> kernel/edges.rs",
    "core: cycle lab/draft.rs -> lab/kernel.rs -> lab/draft.rs",
    "core: cycle packet.rs -> sub_packet.rs -> packet.rs",
    "core: cycle traverse/mod.rs -> traverse/packet.rs -> traverse/mod.rs",
    "core: kernel uses rays, which stands above it",
    "core: packet uses sub_packet, which stands above it",
    "core: the map lacks lab",
    "engine: cycle balance/by_cost.rs -> balance/mod.rs -> balance/by_cost.rs",
    "engine: cycle balance/cyclic.rs -> balance/mod.rs -> balance/cyclic.rs",
    "engine: cycle balance/mod.rs -> balance/static_shares.rs -> balance/mod.rs",
    "engine: cycle balance/mod.rs -> balance/work_queue.rs -> balance/mod.rs",
    "engine: cycle display/window/mod.rs -> display/window/screen.rs -> display/window/mod.rs",
    "engine: cycle display/window/mod.rs -> display/window/viewer.rs -> display/window/mod.rs",
    "engine: cycle load/mod.rs -> load/obj.rs -> load/mod.rs",
    "engine: cycle material/lambertian.rs -> material/mod.rs -> material/lambertian.rs",
    "engine: cycle material/mod.rs -> material/phong.rs -> material/mod.rs",
    "engine: cycle material/mod.rs -> material/unlit.rs -> material/mod.rs",
    "engine: cycle pipeline/callback.rs -> pipeline/safe_point.rs -> pipeline/callback.rs",
    "engine: cycle pipeline/lead.rs -> pipeline/run.rs -> pipeline/lead.rs",
    "engine: cycle pipeline/mod.rs -> pipeline/run.rs -> pipeline/mod.rs",
    "engine: cycle sampler/jittered.rs -> sampler/mod.rs -> sampler/jittered.rs",
    "engine: cycle sampler/mod.rs -> sampler/single.rs -> sampler/mod.rs",
    "engine: cycle scene/compiled.rs -> stack.rs -> scene/compiled.rs",
    "engine: cycle scene/description.rs -> scene/mesh.rs -> scene/description.rs",
    "engine: cycle scene/description.rs -> scene/spheres.rs -> scene/description.rs",
    "engine: no map",
];

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
