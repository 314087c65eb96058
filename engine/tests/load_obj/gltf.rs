//! glTF documents and GLB files: what is loaded, and what is said about the rest.

use std::f32::consts::PI;

use glam::Vec3;
use mobula::light::{Directional, Point};
use mobula::load::Loaded;
use mobula::material::{Flat, Principled};
use mobula::view::Up;
use proptest::prelude::*;
use serde_json::{Value, json};

use super::textures::{GREEN, RED, halves};
use super::{Folder, mesh};

/// A GLB file.
fn glb(document: &Value, binary: &[u8]) -> Vec<u8> {
    let json = document.to_string().into_bytes();
    let mut bytes = [b"glTF".as_slice(), &2_u32.to_le_bytes(), &0_u32.to_le_bytes()].concat();
    for (kind, data, pad) in [(b"JSON", &json[..], b' '), (b"BIN\0", binary, 0)] {
        let mut data = data.to_vec();
        data.resize(data.len().next_multiple_of(4), pad);
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(data);
    }
    let length = (bytes.len() as u32).to_le_bytes();
    bytes[8..12].copy_from_slice(&length);
    bytes
}

/// The bytes of a square with normals and texture coordinates, and of a picture; and a document about it.
fn square() -> (Value, Vec<u8>) {
    let floats = |numbers: &[f32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let positions = floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    let normals = floats(&[0., 0., 1.].repeat(4));
    let coordinates = floats(&[0., 1., 1., 1., 1., 0., 0., 0.]);
    let indices: Vec<u8> = [0_u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect();
    let picture = halves(RED, GREEN);
    let (mut binary, mut views) = (Vec::new(), Vec::new());
    for part in [&positions, &normals, &coordinates, &indices, &picture] {
        views.push(json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": part.len()}));
        binary.extend(part);
        binary.resize(binary.len().next_multiple_of(4), 0);
    }
    let document = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 2, 3]}],
        "nodes": [
            {"name": "here", "mesh": 0},
            {"name": "there", "mesh": 0, "translation": [10, 0, 0], "scale": [2, 2, -2]},
            {"camera": 0, "translation": [0.5, 0.5, 3]},
            {"translation": [0, 0, 8], "extensions": {"KHR_lights_punctual": {"light": 0}}, "children": [4]},
            {"extensions": {"KHR_lights_punctual": {"light": 1}}},
        ],
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0},
        ]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": binary.len()}],
        "images": [{"bufferView": 4, "mimeType": "image/png"}],
        "textures": [{"source": 0}],
        "materials": [{
            "name": "paint",
            "pbrMetallicRoughness": {
                "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [1, 0.5], "offset": [0, 0.5]}}},
                "metallicFactor": 0.25,
                "roughnessFactor": 0.5,
            },
            "emissiveFactor": [0, 0.5, 0],
        }],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}],
        "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_transform"],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "point", "intensity": 10.0 * f64::from(PI), "color": [1, 0.5, 0]},
            {"type": "directional", "intensity": PI},
        ]}},
    });
    (document, binary)
}

fn check(loaded: &Loaded) {
    assert_eq!(loaded.report.warnings, [""; 0]);
    let (scene, mesh) = (&loaded.scene, mesh(loaded));
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (8, 4));
    assert_eq!(mesh.groups.iter().map(|group| &*group.name).collect::<Vec<_>>(), ["here", "there"]);
    assert_eq!((mesh.positions[2], mesh.positions[6]), ([1.0, 1.0, 0.0], [12.0, 2.0, 0.0]));
    // The mirrored one is turned round, and its normals go the other way.
    assert_eq!((mesh.triangles[0], mesh.triangles[2]), ([0, 1, 2], [4, 6, 5]));
    assert_eq!((mesh.normals[0], mesh.normals[4]), ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]));
    assert_eq!((mesh.texture_coordinates[0], mesh.texture_coordinates[2]), ([0.0, 0.0], [1.0, 1.0]));
    let [paint] = &scene.materials[..] else { panic!("{:?}", scene.materials) };
    let material: &Principled = paint.material.downcast_ref().unwrap();
    assert_eq!((&*paint.name, material.metallic, material.roughness), ("paint", 0.25, 0.5));
    assert_eq!((material.emission, material.base_color), (Vec3::new(0.0, 0.5, 0.0), Vec3::ONE));
    let map = material.maps.color.as_ref().unwrap();
    assert_eq!((map.turn, map.offset), ([[1.0, 0.0], [0.0, 0.5]], [0.0, 0.0]));
    assert_eq!(map.sample([0.75, 0.5], 0.0).truncate(), Vec3::Y);
    let view = scene.view.unwrap();
    assert!((view.eye - Vec3::new(0.5, 0.5, 3.0)).length() < 1e-6 && (view.fov - 0.5_f32.to_degrees()).abs() < 1e-4);
    assert_eq!((scene.up, view.at.x, view.at.y), (Some(Up::Y), 0.5, 0.5));
    let [point, sun] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
    let (point, sun) = (format!("{point:?}"), format!("{sun:?}"));
    let expected = Point { position: Vec3::Z * 8.0, color: Vec3::new(10.0, 5.0, 0.0), falloff: true };
    assert_eq!(point, format!("{expected:?}"));
    assert_eq!(sun, format!("{:?}", Directional { direction: Vec3::Z, color: Vec3::ONE }));
}

#[test]
fn one_scene_in_all_containers() {
    use base64::Engine;
    let folder = Folder::new("gltf");
    let (mut document, binary) = square();
    check(&folder.load("a.glb", glb(&document, &binary)).unwrap());
    check(&folder.load("a", glb(&document, &binary)).unwrap());
    document["buffers"][0]["uri"] = json!("my%20data.bin");
    folder.write("my data.bin", &binary);
    check(&folder.load("a.gltf", document.to_string()).unwrap());
    check(&folder.load("b", serde_json::to_string_pretty(&document).unwrap()).unwrap());
    let packed = base64::engine::general_purpose::STANDARD.encode(&binary);
    document["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{packed}"));
    check(&folder.load("c.gltf", document.to_string()).unwrap());
}

#[test]
fn other_ways_to_say_it() {
    let folder = Folder::new("gltf-ways");
    let load = |change: &dyn Fn(&mut Value)| {
        let (mut document, binary) = square();
        change(&mut document);
        folder.load("a.glb", glb(&document, &binary)).map_err(|error| error.to_string())
    };
    let strip = load(&|document| document["meshes"][0]["primitives"][0]["mode"] = json!(5)).unwrap();
    assert_eq!(
        mesh(&strip).triangles[..2],
        [[0, 1, 2], [1, 0, 2]].map(|t: [u32; 3]| if t == [1, 0, 2] { [2, 1, 0] } else { t })
    );
    let fan = load(&|document| document["meshes"][0]["primitives"][0]["mode"] = json!(6)).unwrap();
    assert_eq!(mesh(&fan).triangles[1], [0, 2, 0]);
    let plain =
        load(&|document| document["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": 0}})).unwrap();
    assert_eq!((mesh(&plain).triangles.len(), mesh(&plain).triangle_texture_coordinates.len()), (2, 0));
    let lines = load(&|document| document["meshes"][0]["primitives"][0]["mode"] = json!(1)).unwrap_err();
    assert!(lines.contains("there is no triangle in its scene"), "{lines}");
    let unlit = load(&|document| document["materials"][0]["extensions"] = json!({"KHR_materials_unlit": {}})).unwrap();
    assert!(unlit.scene.materials[0].material.downcast_ref::<Flat>().unwrap().maps.color.is_some());
    let sparse = load(&|document| {
        document["accessors"][0]["sparse"] = json!({
            "count": 1,
            "indices": {"bufferView": 3, "byteOffset": 2, "componentType": 5123},
            "values": {"bufferView": 1},
        });
    });
    assert_eq!(mesh(&sparse.unwrap()).positions[1], [0.0, 0.0, 1.0]);
    let bare = load(&|document| document["images"][0] = json!({})).unwrap();
    assert!(bare.report.warnings[0].contains("neither a uri nor a buffer view"), "{:?}", bare.report.warnings);
    let twice = load(&|document| document["nodes"][4]["children"] = json!([3, 0]));
    assert_eq!(mesh(&twice.unwrap()).triangles.len(), 4, "each node once");
    let beyond = load(&|document| document["accessors"][3]["bufferView"] = json!(1)).unwrap();
    assert_eq!(mesh(&beyond).triangles, [[0, 0, 0], [4, 4, 4]]);
    assert!(beyond.report.warnings[0].contains("2 triangle"), "{:?}", beyond.report.warnings);
}

#[test]
fn broken_documents_are_told() {
    let folder = Folder::new("gltf-broken");
    for (pointer, value, expected) in [
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "it needs the extension 'KHR_draco_mesh_compression'",
        ),
        ("/accessors/0/count", json!(1_000_000_000_u64), "accessor 0 reaches beyond its buffer view"),
        ("/accessors/0/byteOffset", json!(u64::MAX), ""),
        ("/bufferViews/0/byteLength", json!(1 << 30), "buffer view 0 reaches beyond its buffer"),
        ("/bufferViews/0/byteStride", json!(1), ""),
        ("/accessors/0/type", json!("VEC2"), "accessor 0 has 2 components instead of 3"),
        ("/nodes/0/mesh", json!(7), "no sound glTF document"),
        ("/scene", json!(7), "no sound glTF document"),
        ("/buffers/0/uri", json!("gone.bin"), "'gone.bin' is not there"),
        ("/buffers/0/uri", json!("https://example.org/a.bin"), "is not fetched"),
        ("/buffers/0/uri", json!("../../../etc/hostname"), "is not there"),
    ] {
        let (mut document, binary) = square();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        document.pointer_mut(parent).unwrap()[key] = value;
        // Whatever else: an error, or a picture of what is sound.
        let result = folder.load("a.glb", glb(&document, &binary));
        if !expected.is_empty() {
            let text = result.map(|loaded| loaded.report).unwrap_err().to_string();
            assert!(text.contains(expected) && !text.contains('\n'), "{pointer}: {text}");
        }
    }
    let complaint = folder.complaint("a.gltf", "{\"asset\": {\"version\": \"2.0\"},\n \"nodes\": 3}");
    assert!(complaint.starts_with("a.gltf:2:") && complaint.contains("no glTF document"), "{complaint}");
    let (document, binary) = square();
    let whole = glb(&document, &binary);
    for end in [0, 3, 8, 12, 19, 40, whole.len() / 2] {
        assert!(folder.load("a.glb", &whole[..end]).is_err(), "{end}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_break_nothing(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let folder = Folder::new("gltf-damaged");
        let (document, binary) = square();
        let mut bytes = glb(&document, &binary);
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        let _ = folder.load("a.glb", bytes);
    }
}
