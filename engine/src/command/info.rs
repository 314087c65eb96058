//! `mobula info`: what is in a file.

use mobula::geometry::Role;
use mobula::load::printable;
use serde_json::json;

use super::args::InfoOptions;
use super::failure::Failure;
use super::print;
use super::scene::{grouped, open};

/// Counts that the JSON object always has.
const KEYS: [&str; 9] = [
    "vertices",
    "normals",
    "texture_coordinates",
    "faces",
    "triangles",
    "spheres",
    "groups",
    "degenerate_triangles",
    "non_finite_triangles",
];

pub(crate) fn info(options: &InfoOptions) -> Result<(), Failure> {
    let loaded = open(&options.file, None)?;
    let (scene, report) = (&loaded.scene, &loaded.report);
    if options.json {
        let materials: Vec<_> = scene.materials.iter().map(|named| named.name.as_str()).collect();
        let mut object = json!({
            "format": report.format,
            "name": scene.name,
            "bounds": report.bounds(),
            "materials": materials.len(),
            "material_names": materials,
            "warnings": report.warnings,
        });
        for key in KEYS {
            object[key] = json!(report.census.count(key));
        }
        for (item, count) in report.census.items() {
            object[item.key] = json!(count);
        }
        return print(&object);
    }
    let mut text = format!("{}\n", printable(&options.file.display().to_string()));
    let mut line = |name: &str, value: String| text.push_str(&format!("  {name:<21} {value}\n"));
    line("format", report.format.to_owned());
    if let Some([low, high]) = report.bounds() {
        let corner = |c: [f32; 3]| format!("({}, {}, {})", c[0], c[1], c[2]);
        line("bounds", format!("{} to {}", corner(low), corner(high)));
    }
    for (item, count) in report.census.items().iter().filter(|(_, count)| *count > 0) {
        line(&format!("{}{}", if item.role == Role::LeftOut { "  " } else { "" }, item.many), grouped(*count));
    }
    if !scene.materials.is_empty() {
        line("materials", grouped(scene.materials.len() as u64));
    }
    for named in &scene.materials {
        line("", format!("{}: {}", printable(&named.name), named.material.describe()));
    }
    print(&text.trim_end())
}
