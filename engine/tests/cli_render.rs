//! `mobula render` and `mobula info`: pictures, JSON, and what is said where.

#[path = "cli_render/formats.rs"]
mod formats;
mod support;

use std::fs;

use serde_json::Value;
use support::{Folder, PYRAMID, picture};

#[test]
fn a_mesh_becomes_a_picture_and_one_json_object() {
    let folder = Folder::new("render");
    folder.write("pyramid.obj", PYRAMID);
    let done = folder.run(&[
        "render",
        "pyramid.obj",
        "-o",
        "out.png",
        "--size",
        "90x60",
        "--threads",
        "2",
        "--frames",
        "3",
        "--json",
        "--stats",
        "--isa",
        "sse2",
        "--packet",
        "16",
    ]);
    assert_eq!(done.code, Some(0), "{done:?}");
    assert_eq!(done.err.lines().next(), Some("mobula: sse2, packets of 16 rays, 2 threads"));
    assert!(done.err.contains("wrote out.png (90x60)"), "{}", done.err);
    assert_eq!(done.out.lines().count(), 1);
    let json: Value = serde_json::from_str(&done.out).unwrap();
    assert_eq!(json["level"], "sse2");
    assert_eq!(json["packet"], 16);
    assert_eq!(json["threads"], 2);
    assert_eq!(json["size"], serde_json::json!([90, 60]));
    assert_eq!(json["frames"], 3);
    // Files are antialiased: sixteen samples a pixel.
    assert_eq!(json["rays"]["primary"], 3 * 90 * 60 * 16);
    assert!(json["rays"]["shadow"].as_u64().unwrap() > 0);
    assert_eq!(json["output"], "out.png");
    assert_eq!((&json["geometries"], &json["media"], &json["camera"]), (&1.into(), &0.into(), &"pinhole".into()));
    for key in ["seconds", "fps", "mrays_per_second"] {
        assert!(json[key].as_f64().unwrap() > 0.0, "{key}");
    }
    let (width, height, pixels) = picture(&folder.0.join("out.png"));
    assert_eq!((width, height), (90, 60));
    let colours: std::collections::HashSet<_> = pixels.chunks(3).collect();
    assert!(colours.len() > 20, "{} colours", colours.len());
    assert_eq!(folder.files(), ["out.png", "pyramid.obj"]);
}

#[test]
fn every_path_gives_the_same_bytes() {
    let folder = Folder::new("paths");
    folder.write("pyramid.obj", PYRAMID);
    let bytes = |options: &[&str]| {
        let base = ["render", "pyramid.obj", "-o", "out.png", "--size", "61x37", "--eye", "-6,7,-4", "--at", "0,0,0"];
        let done = folder.run(&[&base, options].concat());
        assert_eq!(done.code, Some(0), "{done:?}");
        fs::read(folder.0.join("out.png")).unwrap()
    };
    let first = bytes(&["--isa", "scalar"]);
    for options in [
        &["--isa", "sse2"][..],
        &["--isa", "scalar", "--packet", "1"],
        &["--isa", "sse2", "--packet", "256", "--threads", "3"],
        &["--isa", "scalar", "--balancer", "static", "--threads", "2"],
        &["--isa", "scalar", "--balancer", "cyclic", "--frames", "4"],
        &["--isa", "sse2", "--accel", "brute"],
    ] {
        assert!(bytes(options) == first, "{options:?} differs");
    }
    for options in [
        &["--no-shadows"][..],
        &["--renderer", "normal"],
        &["--samples", "1"],
        &["--background", "black"],
        &["--camera", "orthographic"],
        &["--fog", "0.02"],
        &["--fog", "0.02,1,0,0"],
    ] {
        let options = [&["--isa", "scalar"], options].concat();
        assert!(bytes(&options) != first, "{options:?} changes nothing");
    }
}

#[test]
fn without_arguments_and_display_there_is_a_picture() {
    let folder = Folder::new("default");
    let done = folder.run(&["--size", "40x30"]);
    assert_eq!(done.code, Some(0), "{done:?}");
    let why = if cfg!(feature = "window") { "no display for a window" } else { "built without a window" };
    assert!(done.err.contains("wrote mobula.png (40x30)") && done.err.contains(why), "{}", done.err);
    assert_eq!(picture(&folder.0.join("mobula.png")).0, 40);
}

#[test]
fn the_eye_can_be_placed() {
    let folder = Folder::new("eye");
    folder.write("pyramid.obj", PYRAMID);
    // From below the floor, looking down: nothing but background.
    let view = ["--eye", "0,-5,0", "--at", "0,-9,0.1", "--background", "0,1,0", "--fov", "30"];
    let done = folder.run(&[&["render", "pyramid.obj", "-o", "out.png", "--size", "8x8"][..], &view].concat());
    assert_eq!(done.code, Some(0), "{done:?}");
    assert!(picture(&folder.0.join("out.png")).2.chunks(3).all(|pixel| pixel == [0, 255, 0]));
}

#[test]
fn several_scenes_are_shown_together() {
    let folder = Folder::new("several");
    folder.write("pyramid.obj", PYRAMID);
    let done = folder.run(&["render", "pyramid.obj", "gen:terr20k", "-o", "out.png", "--size", "16x16"]);
    assert_eq!(done.code, Some(0), "{done:?}");
    assert!(
        done.err.contains("pyramid: 6 triangles") && done.err.contains("gen:terr20k: 20,000 triangles"),
        "{done:?}"
    );
}

#[test]
fn info_tells_what_is_in_a_file() {
    let folder = Folder::new("info");
    folder.write("pyramid.obj", PYRAMID);
    let done = folder.run(&["info", "pyramid.obj"]);
    assert_eq!(done.code, Some(0), "{done:?}");
    for text in
        ["format                OBJ", "bounds                (-2, 0, -2) to (2, 1.5, 2)", "triangles             6"]
    {
        assert!(done.out.contains(text), "{text}: {}", done.out);
    }
    let done = folder.run(&["info", "pyramid.obj", "--json"]);
    let json: Value = serde_json::from_str(&done.out).unwrap();
    assert_eq!(json["format"], "OBJ");
    assert_eq!(json["bounds"], serde_json::json!([[-2.0, 0.0, -2.0], [2.0, 1.5, 2.0]]));
    assert_eq!((&json["vertices"], &json["faces"], &json["triangles"]), (&9.into(), &5.into(), &6.into()));
}

#[test]
fn pictures_that_are_refined_are_finished() {
    let folder = Folder::new("refined");
    folder.write("pyramid.obj", PYRAMID);
    let bytes = |options: &[&str]| {
        let done = folder.run(&[&["render", "pyramid.obj", "-o", "out.png", "--size", "161x137"], options].concat());
        assert_eq!(done.code, Some(0), "{done:?}");
        fs::read(folder.0.join("out.png")).unwrap()
    };
    let whole = bytes(&[]);
    for traverser in ["progressive", "deadline:1000", "deadline:0.01"] {
        assert!(bytes(&["--traverser", traverser]) == whole, "{traverser}");
    }
}

#[test]
fn every_frame_is_written_where_there_is_a_place_for_its_number() {
    let folder = Folder::new("numbered");
    folder.write("pyramid.obj", PYRAMID);
    let render = ["render", "pyramid.obj", "--size", "40x30", "--json", "-o"];
    let written = |options: &[&str]| {
        let done = folder.run(&[&render, options].concat());
        assert_eq!(done.code, Some(0), "{done:?}");
        let json: Value = serde_json::from_str(&done.out).unwrap();
        let files = folder.files().into_iter().filter(|name| name.ends_with(".png"));
        let files: Vec<String> = files.inspect(|name| fs::remove_file(folder.0.join(name)).unwrap()).collect();
        let mut told: Vec<_> = json["outputs"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
        told.sort_unstable();
        assert_eq!(files, told);
        assert!(done.err.contains(&format!("wrote {}", json["outputs"][0].as_str().unwrap())), "{}", done.err);
        files
    };
    assert_eq!(written(&["a-##.png", "--frames", "3"]), ["a-00.png", "a-01.png", "a-02.png"]);
    assert_eq!(written(&["a.png", "--frames", "3"]), ["a.png"]);
    assert_eq!(
        written(&["##.png", "--frames", "2", "--channels", "2"]),
        ["00-0.png", "00-1.png", "01-0.png", "01-1.png"]
    );
    assert_eq!(written(&["##.png", "--frames", "2", "--stereo", "anaglyph"]), ["00.png", "01.png"]);
    // From coarse to fine.
    assert_eq!(written(&["##.png", "--traverser", "progressive"]), ["00.png", "01.png", "02.png", "03.png"]);
}

#[test]
fn quiet_is_quiet() {
    let folder = Folder::new("quiet");
    folder.write("pyramid.obj", format!("{PYRAMID}usemtl nothing\nf 1 2 3\n"));
    let render = ["render", "pyramid.obj", "--size", "40x30", "--quiet"];
    let done = folder.run(&render);
    assert_eq!((done.code, done.err.lines().count()), (Some(0), 1), "{done:?}");
    assert!(done.err.starts_with("mobula: warning: "), "{done:?}");
    assert_eq!(folder.run(&["info", "pyramid.obj", "-q"]).out, folder.run(&["info", "pyramid.obj"]).out);
}

#[test]
fn the_command_explains_itself_to_shells_and_readers() {
    let folder = Folder::new("manual");
    let done = folder.run(&["completions", "bash"]);
    assert!(done.code == Some(0) && done.out.contains("--background"), "{done:?}");
    let done = folder.run(&["man", "render"]);
    assert!(done.code == Some(0) && done.out.contains(".TH mobula-render") && done.out.contains("frames"), "{done:?}");
    assert!(folder.run(&["man"]).out.contains(".TH mobula "));
}

#[test]
fn scaling_is_projected_unless_the_machine_is_busy() {
    let folder = Folder::new("scale");
    let done = folder.run(&["scale", "gen:terr20k", "--size", "60x40", "--rounds", "1", "--frames", "1", "--json"]);
    let json: Value = serde_json::from_str(&done.out).unwrap();
    let handovers = json["costs"]["handovers"].as_array().unwrap().len();
    assert!((1..=2).contains(&handovers) && !json["measured"].as_array().unwrap().is_empty(), "{json}");
    let projected = json["projected"].as_array().unwrap();
    if json["disturbed"] == true {
        assert!(done.code == Some(1) && projected.is_empty() && done.err.contains("the machine is busy"), "{done:?}");
    } else {
        assert!(done.code == Some(0) && projected.len() >= handovers, "{done:?}");
    }
}

#[test]
fn a_stray_vertex_hides_nothing_and_costs_nothing() {
    let folder = Folder::new("stray");
    let n = 150;
    let height = |x: usize, z: usize| (x as f32 * 0.37).sin() * (z as f32 * 0.23).cos();
    let mut text = String::new();
    for i in 0..n * n {
        text += &format!("v {} {} {}\n", i % n, height(i % n, i / n), i / n);
    }
    for i in (0..n * n - n).filter(|i| i % n < n - 1) {
        let (a, b) = (i + 1, i + n + 1);
        text += &format!("f {a} {b} {}\nf {a} {} {}\n", b + 1, b + 1, a + 1);
    }
    let view =
        ["--eye", "75,60,-40", "--at", "75,0,75", "--size", "100x75", "--samples", "1", "--json", "-o", "out.png"];
    let seconds = |scene: &str| {
        let done = folder.run(&[&["render", scene], &view[..]].concat());
        assert_eq!(done.code, Some(0), "{done:?}");
        serde_json::from_str::<Value>(&done.out).unwrap()["seconds"].as_f64().unwrap()
    };
    folder.write("plain.obj", &text);
    let plain = (0..3).map(|_| seconds("plain.obj")).fold(f64::INFINITY, f64::min);
    for far in ["1e5", "1e6", "1e7", "1e12"] {
        folder.write("stray.obj", format!("{text}v {far} 0 0\nv {far} 1 0\nv {far} 0 1\nf -1 -2 -3\n"));
        // Brute force takes a hundred times as long, and more; a busy machine some times as long.
        let stray = (0..3).map(|_| seconds("stray.obj")).fold(f64::INFINITY, f64::min);
        assert!(stray < 8.0 * plain + 0.05, "{far}: {stray} s for {plain} s, with shadows");
    }
    let done = folder.run(&["render", "stray.obj", "--size", "100x75", "-o", "framed.png"]);
    assert!(done.err.contains("warning: some of the scene is far from the rest"), "{done:?}");
    let colours: std::collections::HashSet<_> =
        picture(&folder.0.join("framed.png")).2.chunks(3).map(<[u8]>::to_vec).collect();
    assert!(colours.len() > 100, "the grid is not to be seen: {} colours", colours.len());
}

#[test]
fn eyes_and_bounds_are_in_the_coordinates_of_the_file() {
    let folder = Folder::new("moved");
    let at = |x: f64, y: f64| {
        let corner =
            |i: u32| format!("v {} {} {}\n", x + f64::from(i & 1), y + f64::from(i >> 1 & 1), f64::from(i >> 2));
        (0..8).map(corner).collect::<String>() + "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
    };
    folder.write("near.obj", at(0.0, 0.0));
    folder.write("far.obj", at(4e6, 5e6));
    for (scene, eye, aim) in [("near", "3,3.5,2", "0,0,0"), ("far", "4000003,5000003.5,2", "4000000,5000000,0")] {
        let (file, out) = (format!("{scene}.obj"), format!("{scene}.png"));
        let done = folder.run(&["render", &file, "--eye", eye, "--at", aim, "--size", "64x48", "-o", &out]);
        assert_eq!(done.code, Some(0), "{done:?}");
    }
    let colours: std::collections::HashSet<_> =
        picture(&folder.0.join("far.png")).2.chunks(3).map(<[u8]>::to_vec).collect();
    assert!(colours.len() > 20 && picture(&folder.0.join("near.png")).0 == 64);
    let json: Value = serde_json::from_str(&folder.run(&["info", "far.obj", "--json"]).out).unwrap();
    assert_eq!(json["bounds"], serde_json::json!([[4e6, 5e6, 0.0], [4_000_001.0, 5_000_001.0, 1.0]]));
}
