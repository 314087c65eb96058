//! Pictures in all formats, films, and standard output.

use std::collections::HashMap;
use std::fs;

use exr::prelude::FlatSamples;
use exr::prelude::traits::*;

use crate::support::{Done, Folder, PYRAMID, picture};

const COMMON: [&str; 8] = ["render", "pyramid.obj", "--size", "60x40", "--threads", "2", "--eye", "-6,7,-4"];

fn render(folder: &Folder, more: &[&str]) -> Done {
    folder.write("pyramid.obj", PYRAMID);
    folder.run(&[&COMMON, more].concat())
}

fn rendered(folder: &Folder, more: &[&str]) {
    let done = render(folder, more);
    assert_eq!((done.code, &*done.out), (Some(0), ""), "{done:?}");
}

/// The channels of an EXR file.
fn channels(folder: &Folder, name: &str) -> HashMap<String, FlatSamples> {
    let layers = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = layers.from_file(folder.0.join(name)).unwrap();
    assert_eq!((image.layer_data.size.0, image.layer_data.size.1), (60, 40));
    let all = image.layer_data.channel_data.list.into_iter();
    all.map(|channel| (channel.name.to_string(), channel.sample_data)).collect()
}

fn floats(samples: &FlatSamples) -> &[f32] {
    match samples {
        FlatSamples::F32(numbers) => numbers,
        other => panic!("{other:?}"),
    }
}

#[test]
fn every_format_has_the_same_picture() {
    let folder = Folder::new("formats");
    for name in ["a.png", "a.ppm", "a.jpg", "a.JPEG", "a.exr"] {
        rendered(&folder, &["-o", name]);
    }
    assert_eq!(folder.files(), ["a.JPEG", "a.exr", "a.jpg", "a.png", "a.ppm", "pyramid.obj"]);
    let (_, _, pixels) = picture(&folder.0.join("a.png"));

    let ppm = fs::read(folder.0.join("a.ppm")).unwrap();
    assert_eq!(ppm, [b"P6\n60 40\n255\n", &pixels[..]].concat());

    let jpeg = image::load_from_memory(&fs::read(folder.0.join("a.jpg")).unwrap()).unwrap().to_rgb8();
    assert_eq!(jpeg.dimensions(), (60, 40));
    let off: u64 = jpeg.as_raw().iter().zip(&pixels).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    assert!(off < 4 * pixels.len() as u64, "a mean of {}", off as f64 / pixels.len() as f64);
    assert_eq!(fs::read(folder.0.join("a.jpg")).unwrap(), fs::read(folder.0.join("a.JPEG")).unwrap());

    let layers = channels(&folder, "a.exr");
    let srgb = |x: f32| {
        let x = x.clamp(0.0, 1.0);
        let v = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        (v * 255.0).round() as u8
    };
    for (offset, name) in ["R", "G", "B"].into_iter().enumerate() {
        for (i, &light) in floats(&layers[name]).iter().enumerate() {
            assert!(srgb(light).abs_diff(pixels[3 * i + offset]) <= 1, "{name} of pixel {i}: {light}");
        }
    }
    assert!(floats(&layers["A"]).iter().all(|&alpha| alpha == 1.0));
}

#[test]
fn layers_say_what_is_behind_each_pixel() {
    let folder = Folder::new("layers");
    rendered(&folder, &["-o", "a.exr", "--exposure", "3", "--samples", "4"]);
    rendered(&folder, &["-o", "b.exr", "--samples", "4", "--isa", "scalar", "--packet", "1"]);
    let (layers, others) = (channels(&folder, "a.exr"), channels(&folder, "b.exr"));
    assert_eq!(layers.len(), 14);
    for (name, samples) in &layers {
        match (samples, &others[name]) {
            (FlatSamples::U32(a), FlatSamples::U32(b)) => assert_eq!(a, b, "{name}"),
            (a, b) => {
                let close = |(a, b): (&f32, &f32)| a == b || (a - b).abs() < 1e-4 * a.abs().max(1.0);
                assert!(floats(a).iter().zip(floats(b)).all(close), "{name}: exposure, level and width do not count");
            }
        }
    }
    let whole = |name: &str| match &layers[name] {
        FlatSamples::U32(numbers) => numbers.clone(),
        other => panic!("{other:?}"),
    };
    let [depth, up, red] = ["Z", "N.Y", "albedo.R"].map(|name| floats(&layers[name]));
    let (primitives, geometries) = (whole("id.primitive"), whole("id.geometry"));
    for i in 0..60 * 40 {
        let hit = depth[i].is_finite();
        assert_eq!((primitives[i] < 6, geometries[i] == 0), (hit, hit), "pixel {i}");
        // The floor is two triangles, the sides are steeper.
        let normal = if hit { up[i].abs() } else { 0.0 };
        assert!(if hit && primitives[i] < 2 { normal > 0.999 } else { normal < 0.9 }, "{normal} at {}", primitives[i]);
        assert_eq!(red[i] > 0.0, hit);
    }
    let seen: std::collections::HashSet<u32> = primitives.into_iter().collect();
    assert!(seen.len() >= 4, "floor, two sides, nothing: {seen:?}");
}

#[test]
fn standard_output_gets_the_picture_and_nothing_else() {
    let folder = Folder::new("stdout");
    folder.write("pyramid.obj", PYRAMID);
    rendered(&folder, &["-o", "a.ppm"]);
    let output = folder.mobula(&[&COMMON[..], &["-o", "-", "--stats"]].concat()).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(output.stdout, fs::read(folder.0.join("a.ppm")).unwrap());
    for wrong in [&["--json"][..], &["--channels", "2"], &["--turntable", "3"]] {
        let done = render(&folder, &[&["-o", "-"], wrong].concat());
        assert_eq!(done.code, Some(2), "{done:?}");
        assert!(done.err.contains("standard output") && done.out.is_empty(), "{done:?}");
    }
}

#[test]
fn what_layers_cannot_be_is_said() {
    let folder = Folder::new("no-layers");
    let done = render(&folder, &["-o", "a.exr", "--stereo", "anaglyph"]);
    assert!(done.code == Some(2) && done.err.contains("layers of one view"), "{done:?}");
    let done = render(&folder, &["-o", "a.gif"]);
    assert!(done.code == Some(2) && done.err.contains("png, jpg, jpeg, ppm or exr; name it a.png"), "{done:?}");
    let done = render(&folder, &["-o", "a-##.exr", "--channels", "2", "-n", "2"]);
    assert_eq!(done.code, Some(0), "{done:?}");
    assert_eq!(folder.files(), ["a-00-0.exr", "a-00-1.exr", "a-01-0.exr", "a-01-1.exr", "pyramid.obj"]);
}

#[test]
fn a_turntable_goes_around_once() {
    let folder = Folder::new("turntable");
    rendered(&folder, &["-o", "still.png"]);
    rendered(&folder, &["-o", "turn.png", "--turntable", "4"]);
    rendered(&folder, &["-o", "t##.exr", "--turntable", "2"]);
    let frames: Vec<_> = (0..4).map(|k| picture(&folder.0.join(format!("turn-000{k}.png"))).2).collect();
    assert_eq!(frames[0], picture(&folder.0.join("still.png")).2);
    assert!((1..4).all(|k| frames[k] != frames[k - 1] && frames[k] != frames[0]));
    // The last of two turns is half around: the view of the third of four.
    let (first, second) = (channels(&folder, "t00.exr"), channels(&folder, "t01.exr"));
    assert_ne!(floats(&first["Z"]), floats(&second["Z"]));
    rendered(&folder, &["-o", "s.png", "--turntable", "2", "--stereo", "side-by-side"]);
    assert_eq!(picture(&folder.0.join("s-0001.png")).0, 120);
}

#[test]
fn time_goes_on_with_frames() {
    let folder = Folder::new("time");
    for step in 0..3 {
        let x = 2 * step;
        folder.write(&format!("p_{step}.csv"), format!("x,y,z\n{x},0,0\n0,1,0\n4,1,1\n"));
    }
    let film = |more: &[&str]| {
        let base =
            ["render", "p_*.csv", "-n", "4", "--size", "24x16", "--radius", "0.5", "--eye", "2,1,9", "--at", "2,0,0"];
        let done = folder.run(&[&base[..], more].concat());
        assert_eq!(done.code, Some(0), "{done:?}");
    };
    film(&["-o", "a##.png", "--fps", "10"]);
    let frames: Vec<_> = (0..4).map(|k| picture(&folder.0.join(format!("a0{k}.png"))).2).collect();
    assert!(frames[0] != frames[1] && frames[1] != frames[2] && frames[0] != frames[2], "a step a frame");
    assert_eq!(frames[0], frames[3], "behind the last comes the first");
    film(&["-o", "b##.png"]);
    assert_eq!(picture(&folder.0.join("b03.png")).2, frames[0], "without --fps time stands still");
    film(&["-o", "c##.png", "--fps", "10", "--memory", "1"]);
    assert_eq!(picture(&folder.0.join("c02.png")).2, frames[2], "steps that are not in memory are read");
}
