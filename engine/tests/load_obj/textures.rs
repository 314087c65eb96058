//! Textures of materials in MTL files: which are found, and what is seen of them.

use std::io::Cursor;

use glam::Vec4;
use image::{ImageFormat, Rgba, RgbaImage};
use mobula::image::Size;
use mobula::material::{Phong, Principled};
use mobula::texture::{Maps, Wrap};

use super::Folder;

/// A square of two triangles with texture coordinates.
const SHEET: &str = "mtllib test.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl it\n\
    f 1/1 2/2 3/3 4/4\n";

/// A picture whose left half is of one colour, the right half of another.
pub(super) fn halves(left: [u8; 4], right: [u8; 4]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let picture = RgbaImage::from_fn(8, 8, |x, _| Rgba(if x < 4 { left } else { right }));
    picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

pub(super) const RED: [u8; 4] = [255, 0, 0, 255];
pub(super) const GREEN: [u8; 4] = [0, 255, 0, 255];

/// The textures of the only material, and what was said.
fn maps(folder: &Folder, mtl: &str) -> (Maps, Vec<String>) {
    folder.write("test.mtl", mtl);
    let loaded = folder.obj(SHEET).unwrap();
    (loaded.scene.materials[0].material.maps().clone(), loaded.report.warnings)
}

#[test]
fn textures_are_found_beside_the_file() {
    let folder = Folder::new("textures");
    folder.write("a b.png", halves(RED, GREEN));
    folder.write("maps/c.png", halves(RED, GREEN));
    folder.write("bumps.png", halves([128, 128, 255, 255], [0, 128, 255, 255]));
    folder.write("heights.png", halves([0, 0, 0, 255], [255, 255, 255, 255]));
    folder.write("holes.png", halves([0, 0, 0, 255], [255, 255, 255, 255]));
    for name in
        ["a b.png", "maps/c.png", "maps\\C.PNG", "D:\\work\\a b.png", "\"a b.png\" # a comment", "-s 1 1 1 a b.png"]
    {
        let (maps, warnings) = maps(&folder, &format!("newmtl it\nmap_Kd {name}\n"));
        assert_eq!(warnings, [""; 0], "{name}");
        let left = maps.color.unwrap().sample([0.25, 0.5], 0.0);
        assert_eq!(left, Vec4::new(1.0, 0.0, 0.0, 1.0), "{name}");
        assert_eq!((maps.normal, maps.opacity), (None, None));
    }
    let all = "newmtl it\nmap_Kd -s 2 3 -o 0.5 0 -clamp on a b.png\nmap_Bump -bm 0.5 bumps.png\nmap_d holes.png\n";
    let (of_all, warnings) = maps(&folder, all);
    assert_eq!(warnings, [""; 0]);
    let color = of_all.color.unwrap();
    assert_eq!((color.turn, color.offset, color.wrap), ([[2.0, 0.0], [0.0, 3.0]], [0.5, 0.0], [Wrap::Clamp; 2]));
    assert_eq!(color.sample([0.0, 0.0], 0.0).y, 0.5, "half way, on the curve of the texels' light");
    let bumps = of_all.normal.unwrap();
    assert_eq!(bumps.scale, 0.5);
    let tilted = bumps.normal(bumps.map.sample([0.75, 0.5], 0.0));
    assert!(tilted.x < -0.4 && tilted.z > 0.9, "{tilted}");
    let holes = of_all.opacity.unwrap();
    assert_eq!([0.25, 0.75].map(|u| holes.opacity(holes.map.sample([u, 0.5], 0.0))), [0.0, 1.0]);
    // Of heights, the slope between the halves goes up to the right: the normal leans to the left.
    let (of_heights, _) = maps(&folder, "newmtl it\nbump heights.png\n");
    let bumps = of_heights.normal.unwrap();
    let slope = bumps.normal(bumps.map.sample([0.5, 0.5], 0.0));
    assert!(slope.x < -0.5 && slope.y.abs() < 0.1, "{slope}");
}

#[test]
fn textures_that_cannot_be_used_are_told() {
    let folder = Folder::new("no-textures");
    folder.write("broken.png", &halves(RED, GREEN)[..60]);
    folder.write("text.png", "hello");
    folder.write("../outside.png", halves(RED, GREEN));
    for (mtl, warning) in [
        ("map_Kd a.png\nmap_d b.png", "texture 'a.png' is not there, and another; materials keep their colours"),
        ("map_Kd /etc/passwd", "texture '/etc/passwd' is not there"),
        ("map_Kd ../../outside.png", "is not there"),
        ("map_Kd broken.png", "broken.png: the picture is broken"),
        ("map_Kd text.png", "text.png: the picture is broken"),
        ("map_Ka x.png\nrefl y.png", "2 texture maps of other kinds than Mobula knows are left out"),
    ] {
        let (maps, warnings) = maps(&folder, &format!("newmtl it\n{mtl}\n"));
        assert_eq!(maps, Maps::default());
        assert!(warnings.len() == 1 && warnings[0].contains(warning), "{mtl}: {warnings:?}");
    }
    let _ = std::fs::remove_file(folder.0.join("../outside.png"));
}

#[test]
fn textures_that_lie_nowhere_are_told() {
    let folder = Folder::new("lost-textures");
    folder.write("a.png", halves(RED, GREEN));
    folder.write("test.mtl", "newmtl it\nmap_Kd a.png\n");
    let warning = folder.obj(SHEET.replace("1/1 2/2", "1 2").replace("3/3 4/4", "3 4")).unwrap().report.warnings;
    assert!(warning.len() == 1 && warning[0].contains("2 triangles have no texture coordinates"), "{warning:?}");
    assert_eq!(folder.obj(SHEET).unwrap().report.warnings, [""; 0]);
}

#[test]
fn gloss_light_and_metal_have_textures() {
    let folder = Folder::new("more-textures");
    folder.write("a.png", halves(RED, GREEN));
    folder.write("b.png", halves([0, 0, 0, 255], [255, 255, 255, 255]));
    folder.write("test.mtl", "newmtl it\nKd 1 1 1\nKs 0 0 0\nmap_Ks a.png\n");
    let loaded = folder.obj(SHEET).unwrap();
    let phong: &Phong = loaded.scene.materials[0].material.downcast_ref().unwrap();
    assert_eq!(phong.specular, glam::Vec3::ONE, "nothing would be left of the texture");
    assert_eq!(phong.specular_map.as_ref().unwrap().sample([0.75, 0.5], 0.0).y, 1.0);
    folder.write("test.mtl", "newmtl it\nKd 1 1 1\nmap_Ke a.png\nPr 0.3\nmap_Pm b.png\nPm 0\n");
    let loaded = folder.obj(SHEET).unwrap();
    assert_eq!(loaded.report.warnings, [""; 0]);
    let principled: &Principled = loaded.scene.materials[0].material.downcast_ref().unwrap();
    assert_eq!((principled.roughness, principled.metallic, principled.emission), (0.3, 1.0, glam::Vec3::ONE));
    assert!(principled.roughness_map.is_none());
    let metallic = principled.metallic_map.as_ref().unwrap();
    assert_eq!([0.25, 0.75].map(|u| metallic.map.sample([u, 0.5], 0.0)[metallic.channel]), [0.0, 1.0]);
    // Light of its own is the texture's.
    let row = seen(&folder, "newmtl it\nKd 0 0 0\nPr 1\nNi 1\nmap_Ke a.png\n");
    assert!(row[4][0] == 255 && row[4][1] < 30 && row[11][1] == 255 && row[11][0] < 30, "{row:?}");
}

/// What the camera sees of the sheet from above, in a row of pixels; behind it is white.
fn seen(folder: &Folder, mtl: &str) -> Vec<[u8; 4]> {
    folder.write("test.mtl", mtl);
    let mut scene = folder.obj(SHEET).unwrap().scene;
    scene.background = std::sync::Arc::new(mobula::background::Constant { color: glam::Vec3::ONE });
    let eye = glam::Vec3::new(0.5, 0.5, 1.0);
    scene.view = Some(mobula::view::View { eye, at: eye - glam::Vec3::Z, up: glam::Vec3::Y, fov: 45.0 });
    let settings = mobula::app::Settings { size: Size::new(16, 16).unwrap(), threads: 1, ..Default::default() };
    let mut pipeline = mobula::app::pipeline(&scene, &settings).unwrap();
    pipeline.run(1).unwrap();
    let bytes = pipeline.picture(0).unwrap().1.to_rgba8();
    bytes.as_chunks().0[16 * 8..16 * 9].to_vec()
}

#[test]
fn textures_and_holes_are_seen() {
    let folder = Folder::new("seen-textures");
    folder.write("color.png", halves(RED, GREEN));
    folder.write("holes.png", halves([0, 0, 0, 255], [255, 255, 255, 255]));
    folder.write("alpha.png", halves(RED, [0, 255, 0, 0]));
    let row = seen(&folder, "newmtl it\nKe 1 1 1\nmap_Kd color.png\n");
    assert_eq!((row[4], row[11]), (RED, GREEN));
    let row = seen(&folder, "newmtl it\nKe 1 1 1\nmap_Kd color.png\nmap_d holes.png\n");
    assert_eq!((row[4], row[11]), ([255; 4], GREEN), "through the hole, the background");
    let row = seen(&folder, "newmtl it\nKe 1 1 1\nmap_Kd alpha.png\n");
    assert_eq!((row[4], row[11]), (RED, [255; 4]));
    let lit = seen(&folder, "newmtl it\nKd 1 1 1\nmap_Kd color.png\n");
    assert!(lit[4][0] > 60 && lit[4][1] == 0 && lit[11][1] > 60 && lit[11][0] == 0, "{lit:?}");
}

#[test]
fn scene_files_have_textures() {
    let folder = Folder::new("scene-textures");
    folder.write("color.png", halves(RED, GREEN));
    folder.write("rough.png", halves([0, 128, 255, 255], [0, 255, 0, 255]));
    folder.write("sheet.obj", SHEET.replace("mtllib test.mtl\n", "").replace("usemtl it\n", ""));
    let scene = |material: &str| {
        let object = "[[object]]\nmesh = \"sheet.obj\"\nmaterial = \"it\"\n";
        folder.load("scene.toml", format!("mobula = 1\n[materials]\nit = {{ {material} }}\n{object}"))
    };
    let laid = "texture = { file = \"color.png\", repeat = [2, 3], offset = [0.5, 0], clamp = true }";
    let loaded = scene(&format!("kind = \"principled\", {laid}, metallic_roughness_map = \"rough.png\"")).unwrap();
    let material: &Principled = loaded.scene.materials[0].material.downcast_ref().unwrap();
    let color = material.maps.color.as_ref().unwrap();
    assert_eq!((color.turn, color.offset, color.wrap), ([[2.0, 0.0], [0.0, 3.0]], [0.5, 0.0], [Wrap::Clamp; 2]));
    assert_eq!(material.base_color, glam::Vec3::ONE, "nothing else is said");
    let metallic = material.metallic_map.as_ref().unwrap();
    assert_eq!((metallic.channel, metallic.map.sample([0.25, 0.5], 0.0).z), (2, 1.0));
    for kind in ["lambertian", "flat", "phong"] {
        let loaded = scene(&format!("kind = \"{kind}\", color = 0.5, texture = \"color.png\"")).unwrap();
        assert!(loaded.scene.materials[0].material.maps().color.is_some(), "{kind}");
    }
    for (material, expected) in [
        ("kind = \"lambertian\", texture = \"gone.png\"", ":3:39: there is no file \"gone.png\""),
        ("kind = \"lambertian\", texture = 3", "scene.toml:3:39: "),
        ("kind = \"lambertian\", texture = { file = \"color.png\", size = 2 }", "size"),
        ("kind = \"metal\", texture = \"color.png\"", "texture"),
        ("kind = \"flat\", texture = \"sheet.obj\"", "this is no PNG"),
    ] {
        let error = scene(material).map(|loaded| loaded.report).unwrap_err().to_string();
        assert!(error.contains(expected), "{material}: {error}");
    }
}
