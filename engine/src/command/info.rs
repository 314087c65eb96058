//! `mobula info`: what is in a file.

use mobula::geometry::Role;
use mobula::load::{Place, SCENE_FILE, printable};
use mobula::scene::Object;
use serde_json::json;

use super::args::InfoOptions;
use super::failure::Failure;
use super::scene::{gather, grouped};
use super::{memory, particles, print, print_object, volumes};

/// Counts that the JSON object always has.
const KEYS: [&str; 11] = [
    "vertices",
    "normals",
    "made_normals",
    "texture_coordinates",
    "faces",
    "triangles",
    "spheres",
    "particles",
    "groups",
    "degenerate_triangles",
    "non_finite_triangles",
];

pub(crate) fn info(options: &InfoOptions) -> Result<(), Failure> {
    let loaded = gather(&options.files, &options.raw, None, &memory::memory(options.memory))?;
    let (scene, report, place) = (&loaded.scene, &loaded.report, &loaded.place);
    if options.json {
        let materials: Vec<_> = scene.materials.iter().map(|named| named.name.as_str()).collect();
        let mut object = json!({
            "format": report.format,
            "name": scene.name,
            "bounds": report.bounds().map(|corners| corners.map(|corner| place.back(corner))),
            "offset": place.offset,
            "scale": place.scale,
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
        let object_of = |one: &Object| json!({ "kind": one.kind, "names": one.names, "material": one.material });
        object["objects"] = scene.objects.iter().map(object_of).collect();
        object["lights"] = json!(scene.lights.len());
        if scene.has_moving_meshes() {
            object["steps"] = json!(scene.steps());
        }
        let volumes: Vec<_> = scene.volumes.iter().map(volumes::object).collect();
        let particles: Vec<_> = scene.particles.iter().map(|particles| particles::object(particles, place)).collect();
        // What is asked for most often: the keys of the first are the scene's too.
        for first in [particles.first(), volumes.first()].into_iter().flatten().filter_map(|first| first.as_object()) {
            first.iter().for_each(|(key, value)| object[key] = value.clone());
        }
        object["volumes"] = json!(volumes);
        object["particle_sets"] = json!(particles);
        return print_object(&object);
    }
    let files: Vec<_> = options.files.iter().map(|file| file.display().to_string()).collect();
    let mut text = format!("{}\n", printable(&files.join(" ")));
    let mut line = |name: &str, value: String| text.push_str(&format!("  {name:<21} {value}\n"));
    line("format", report.format.to_owned());
    if let Some([low, high]) = report.bounds() {
        let corner = |c: [f32; 3]| {
            // What was not moved has few digits.
            let moved = *place != Place::default();
            let [x, y, z] = if moved { place.back(c).map(|x| x.to_string()) } else { c.map(|x| x.to_string()) };
            format!("({x}, {y}, {z})")
        };
        line("bounds", format!("{} to {}", corner(low), corner(high)));
    }
    for (item, count) in report.census.items().iter().filter(|(_, count)| *count > 0) {
        line(&format!("{}{}", if item.role == Role::LeftOut { "  " } else { "" }, item.many), grouped(*count));
    }
    if scene.has_moving_meshes() {
        line("steps of time", scene.steps().to_string());
    }
    // What is more than the files that were named.
    if report.format == SCENE_FILE {
        for Object { kind, names, material, .. } in &scene.objects {
            let material = material.as_ref().map(|name| format!(", {name}")).unwrap_or_default();
            line(kind, printable(&format!("{}{material}", names.join(" "))).into_owned());
        }
    }
    if !scene.lights.is_empty() {
        line("lights", grouped(scene.lights.len() as u64));
    }
    if !scene.materials.is_empty() {
        line("materials", grouped(scene.materials.len() as u64));
    }
    for named in &scene.materials {
        line("", format!("{}: {}", printable(&named.name), named.material.describe()));
    }
    for (name, value) in scene.volumes.iter().flat_map(volumes::lines) {
        line(name, value);
    }
    for (name, value) in scene.particles.iter().flat_map(|particles| particles::lines(particles, place)) {
        line(&name, value);
    }
    print(&text.trim_end())
}
