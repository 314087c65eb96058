//! `mobula info`: what is in a file.

use serde_json::json;

use super::args::InfoOptions;
use super::failure::Failure;
use super::print;
use super::scene::{grouped, open};

pub(crate) fn info(options: &InfoOptions) -> Result<(), Failure> {
    let loaded = open(&options.file)?;
    let (scene, report) = (&loaded.scene, &loaded.report);
    if options.json {
        let materials: Vec<_> = scene.materials.iter().map(|named| named.name.as_str()).collect();
        print(&json!({
            "format": report.format,
            "name": scene.name,
            "bounds": report.bounds,
            "vertices": report.vertices,
            "normals": report.normals,
            "texture_coordinates": report.texture_coordinates,
            "faces": report.faces,
            "triangles": report.triangles,
            "spheres": report.spheres,
            "groups": report.groups,
            "materials": materials.len(),
            "material_names": materials,
            "degenerate_triangles": report.degenerate_triangles,
            "non_finite_triangles": report.non_finite_triangles,
            "warnings": report.warnings,
        }));
        return Ok(());
    }
    let mut text = format!("{}\n", options.file.display());
    let mut line = |name: &str, value: String| text.push_str(&format!("  {name:<22}{value}\n"));
    line("format", report.format.to_owned());
    if let Some([low, high]) = report.bounds {
        let corner = |c: [f32; 3]| format!("({}, {}, {})", c[0], c[1], c[2]);
        line("bounds", format!("{} to {}", corner(low), corner(high)));
    }
    for (name, count) in [
        ("vertices", report.vertices),
        ("normals", report.normals),
        ("texture coordinates", report.texture_coordinates),
        ("faces", report.faces),
        ("triangles", report.triangles),
        ("  without area", report.degenerate_triangles),
        ("  not finite", report.non_finite_triangles),
        ("spheres", report.spheres),
        ("groups", report.groups),
        ("materials", scene.materials.len() as u64),
    ] {
        if count > 0 {
            line(name, grouped(count));
        }
    }
    for named in &scene.materials {
        line("", format!("{}: {}", named.name, looks(&named.material)));
    }
    print(&text.trim_end());
    Ok(())
}

/// A material in a few words.
fn looks(material: &mobula::scene::MaterialDescription) -> String {
    use mobula::scene::MaterialDescription as M;
    let rgb = |c: glam::Vec3| format!("({:.2}, {:.2}, {:.2})", c.x, c.y, c.z);
    match material {
        M::Flat { color } => format!("flat {}", rgb(*color)),
        M::Lambertian { diffuse } => format!("matt {}", rgb(*diffuse)),
        M::Phong(phong) => {
            let mut text = format!("diffuse {}, highlight {:.0}", rgb(phong.diffuse), phong.shininess);
            if phong.reflection > 0.0 {
                text.push_str(&format!(", mirrors {:.2}", phong.reflection));
            }
            if phong.transparency > 0.0 {
                text.push_str(&format!(", lets through {:.2}", phong.transparency));
            }
            text
        }
        M::NormalColor => "normal as colour".into(),
    }
}
