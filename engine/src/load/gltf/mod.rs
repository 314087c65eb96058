//! glTF 2.0 documents and GLB files, through `gltf`: the meshes of the document's scene, where its nodes put them; materials with
//! textures; the first camera; lights (KHR_lights_punctual).
//!
//! | file | idea |
//! |---|---|
//! | `nodes` | which meshes, cameras and lights there are, and where |
//! | `assemble` | one mesh of them all |
//! | `material` | materials and textures |
//! | `buffers` | numbers in buffers |
//! | `container` | the parts of a GLB file; bytes in URIs |

mod assemble;
mod buffers;
mod container;
mod material;
mod nodes;

use std::io::Read;
use std::path::Path;

use gltf::Document;
use gltf::json::{Root, deserialize};

use self::assemble::Assembly;
use self::buffers::Buffers;
use self::material::Textures;
use super::input::{self, Input};
use super::loaded::{Loaded, Report, display_name};
use super::place::Place;
use super::text::{counted, quoted};
use super::{LoadError, Options};
use crate::geometry::{Geometry, Mesh};
use crate::scene::SceneDescription;
use crate::view::Up;

/// Extensions that a document may require.
const EXTENSIONS: [&str; 9] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Does the start of a file look like glTF?
pub(super) fn looks_like(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let json = text.trim_start_matches('\u{feff}').trim_start().starts_with('{');
    start.starts_with(container::MAGIC)
        || (json && ["\"asset\"", "\"accessors\"", "\"scenes\""].iter().any(|key| text.contains(key)))
}

/// The version that a document names, if it is not 2.
fn other_version(json: &[u8]) -> Option<String> {
    let document: serde_json::Value = serde_json::from_slice(json).ok()?;
    let old = document["meshes"].is_object().then_some("1.0");
    let version = document["asset"]["version"].as_str().or(old)?;
    (!version.starts_with('2')).then(|| version.to_owned())
}

/// Loads a document.
pub(super) fn load(file: &Path, mut input: Input, options: &Options) -> Result<Loaded, LoadError> {
    let fail = |problem: String| LoadError::new(file, problem, "check it with a glTF validator, or export it again");
    let mut bytes = Vec::new();
    // All at once: to grow while it is read takes as long as reading. Where this is refused, it is tried piece by piece.
    let length = if input.gzip { 0 } else { file.metadata().map_or(0, |data| data.len()) };
    let _ = bytes.try_reserve(usize::try_from(length).unwrap_or(0));
    input.reader.read_to_end(&mut bytes).map_err(|error| {
        let (problem, remedy) = input::explain(&error, input.gzip);
        LoadError::new(file, problem, remedy)
    })?;
    let (json, binary) = container::split(&bytes).map_err(fail)?;
    let root: Root = deserialize::from_slice(json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json)).map_err(|error| {
        if let Some(version) = other_version(json) {
            let remedy = "convert it to glTF 2.0, which Mobula loads";
            return LoadError::new(file, format!("this is glTF {}", quoted(&version)), remedy);
        }
        let (line, column) = (error.line() as u64, error.column() as u64);
        fail(format!("this is no glTF document: {error}")).at_column(line, column)
    })?;
    if let Some(name) = root.extensions_required.iter().find(|name| !EXTENSIONS.contains(&name.as_str())) {
        let remedy = "export it without that, or convert it with gltf-transform or gltfpack";
        return Err(LoadError::new(file, format!("it needs the extension {}", quoted(name)), remedy));
    }
    let root = Root { extensions_required: Vec::new(), ..root };
    let document = Document::from_json(root).map_err(|error| {
        let all = error.to_string();
        let mut faults = all.split(';').map(|fault| fault.trim().trim_start_matches("invalid glTF: "));
        let first = faults.next().unwrap_or_default();
        let more = faults.filter(|fault| !fault.is_empty()).count();
        let more = if more > 0 { format!(" (and {more} more)") } else { String::new() };
        fail(format!("this is no sound glTF document: {first}{more}"))
    })?;
    let mut warnings = Vec::new();
    let buffers = Buffers::read(file, &document, binary);
    let textures = Textures::read(file, &document, &buffers, &options.progress, &mut warnings);

    let nodes = nodes::placed(&document);
    let mut assembly = Assembly::default();
    for node in &nodes {
        if let Some(mesh) = node.node.mesh() {
            assembly.add(&node.node, &mesh, &node.transform, &buffers).map_err(fail)?;
        }
    }
    let place = Place::choose(options.place, file, &assembly.positions, &assembly.corners(), &mut warnings);
    for (count, of, what) in [
        (assembly.other_modes, "part", "of points or lines left out"),
        (assembly.dangling, "triangle", "with corners that are not there left out"),
        (assembly.other_sets, "part", "whose textures use several sets of coordinates: one is used"),
    ] {
        if count > 0 {
            warnings.push(format!("{}: {} {what}", file.display(), counted(count, of)));
        }
    }
    if document.animations().next().is_some() || document.skins().next().is_some() {
        warnings.push(format!("{}: it is shown as it stands, without its animation", file.display()));
    }
    warnings.extend(input.warning(file));
    let mut scene = SceneDescription { name: display_name(file), up: Some(Up::Y), ..SceneDescription::default() };
    scene.materials = material::materials(&document, &textures);
    nodes::look(&nodes, &assembly.positions, &place, &mut scene);
    nodes::light(&nodes, &place, &mut scene);
    let mesh = assembly.into_mesh(display_name(file), &place);
    if mesh.triangles.is_empty() {
        return Err(LoadError::new(file, "there is no triangle in its scene", "export it with its meshes"));
    }
    let mut census = mesh.census();
    for (item, count) in [
        (Mesh::VERTICES, mesh.positions.len()),
        (Mesh::TEXTURE_COORDINATES, mesh.texture_coordinates.len()),
        (Mesh::NORMALS, mesh.normals.len()),
    ] {
        census.set(item, count as u64);
    }
    scene.add(mesh);
    Ok(Loaded { scene, report: Report { format: "glTF", census, warnings }, place })
}
