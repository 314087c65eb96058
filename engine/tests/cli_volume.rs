//! What the command says of volumes: places, values, histograms, steps of time, raw files.

mod support;

use support::{Folder, PYRAMID};

fn nrrd(sizes: &str, more: &str, voxels: &[u8]) -> Vec<u8> {
    let count = sizes.split(' ').count();
    let header = format!("NRRD0004\ntype: uint8\ndimension: {count}\nsizes: {sizes}\nencoding: raw\n{more}\n");
    [header.as_bytes(), voxels].concat()
}

fn info(folder: &Folder, arguments: &[&str]) -> serde_json::Value {
    let done = folder.run(&[&["info", "--json"], arguments].concat());
    assert_eq!(done.code, Some(0), "{done:?}");
    serde_json::from_str(&done.out).unwrap()
}

#[test]
fn info_says_what_is_in_a_volume() {
    let folder = Folder::new("volume-info");
    let voxels: Vec<u8> = (0..24).map(|i| if i < 20 { 10 } else { i }).collect();
    folder.write("a.nrrd", nrrd("2 3 4", "space dimension: 3\nspacings: 0.5 2 1.25\nspace origin: (1,2,3)\n", &voxels));
    let done = folder.run(&["info", "a.nrrd"]);
    assert_eq!(done.code, Some(0), "{done:?}");
    for line in [
        "  format                NRRD",
        "  bounds                (1, 2, 3) to (1.5, 6, 6.75)",
        "  voxels                24",
        "  volume                a",
        "    dimensions          2 x 3 x 4",
        "    type                u8",
        "    spacing             0.5 x 2 x 1.25",
        "    origin              (1, 2, 3)",
        "    steps of time       1",
        "    range               10 to 23",
        "    mean                11.9167",
        "    histogram           █",
    ] {
        assert!(done.out.lines().any(|found| found == line), "{line}\n{}", done.out);
    }
    assert!(done.out.contains("the highest is 20"), "{}", done.out);
    assert!(done.err.contains("a: 24 voxels, loaded in"), "{}", done.err);

    let object = info(&folder, &["a.nrrd"]);
    assert_eq!(object["format"], "NRRD");
    assert_eq!(object["dimensions"], serde_json::json!([2, 3, 4]));
    assert_eq!(object["spacing"], serde_json::json!([0.5, 2.0, 1.25]));
    assert_eq!((&object["type"], &object["steps"]), (&"u8".into(), &1.into()));
    assert_eq!(object["range"], serde_json::json!([10.0, 23.0]));
    assert_eq!(object["bounds"], serde_json::json!([[1.0, 2.0, 3.0], [1.5, 6.0, 6.75]]));
    let histogram = object["histogram"].as_array().unwrap();
    assert_eq!((histogram.len(), &histogram[0], &histogram[63]), (64, &20.into(), &1.into()));
    assert_eq!((&object["voxels"], &object["triangles"]), (&24.into(), &0.into()));
    assert_eq!(object["volumes"].as_array().unwrap().len(), 1);
}

#[test]
fn files_whose_names_differ_in_a_number_are_steps() {
    let folder = Folder::new("volume-steps");
    for i in [0, 9, 10] {
        folder.write(&format!("t{i}.nrrd"), nrrd("2 2 2", "", &[i as u8; 8]));
    }
    folder.write("t11.nrrd", nrrd("2 2 3", "", &[1; 12]));
    folder.write("other.nrrd", nrrd("2 2 2", "", &[2; 8]));
    folder.write("p1.obj", PYRAMID);
    folder.write("p2.obj", PYRAMID);
    // As a shell sorts them, and expanded here.
    for arguments in [&["t0.nrrd", "t10.nrrd", "t9.nrrd"][..], &["t10.nrrd", "t?.nrrd"], &["t*.nrrd"]] {
        let object = info(&folder, arguments);
        let several = arguments == ["t*.nrrd"];
        assert_eq!((&object["steps"], &object["volume"]), (&3.into(), &"t*".into()), "{arguments:?}");
        assert_eq!(object["volumes"].as_array().unwrap().len(), if several { 2 } else { 1 });
        assert_eq!(object["voxels"], if several { 36 } else { 24 });
        assert_eq!(object["range"], serde_json::json!([0.0, 10.0]));
    }
    let object = info(&folder, &["t0.nrrd", "other.nrrd"]);
    assert_eq!((&object["steps"], object["volumes"].as_array().unwrap().len()), (&1.into(), 2));
    let object = info(&folder, &["p#.obj", "t9.nrrd"]);
    // Meshes of the same triangles are steps, too: they are counted once.
    assert_eq!((&object["triangles"], &object["voxels"]), (&6.into(), &8.into()));
    assert_eq!(object["volume"], "t9");
    let done = folder.run(&["info", "none*.nrrd"]);
    assert_eq!(done.code, Some(1));
    assert!(done.err.ends_with("none*.nrrd: no file has a name like this; check the path\n"), "{}", done.err);
}

#[test]
fn raw_files_are_what_options_say() {
    let folder = Folder::new("volume-raw");
    folder.write("a.raw", [0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7, 0, 8]);
    let raw = ["--raw-dims", "2,2,2", "--raw-type", "u16be"];
    let object = info(&folder, &[&["a.raw", "--raw-spacing", "1,2,0.5"], &raw[..]].concat());
    assert_eq!((&object["type"], &object["range"]), (&"u16".into(), &serde_json::json!([1.0, 8.0])));
    assert_eq!(object["spacing"], serde_json::json!([1.0, 2.0, 0.5]));
    let object = info(&folder, &["a.raw", "--raw-dims", "2,2,2,2", "--raw-type", "u8"]);
    assert_eq!((&object["steps"], &object["not_numbers"]), (&2.into(), &0.into()));

    for (options, code, expected) in [
        (&["--raw-dims", "2,2,2"][..], 2, "--raw-type"),
        (&["--raw-type", "u8"], 2, "--raw-dims"),
        (&["--raw-dims", "2,2", "--raw-type", "u8"], 2, "three whole numbers"),
        (&["--raw-dims", "2,2,2", "--raw-type", "u64"], 2, "the types of voxels are u8, i8, u16"),
        (
            &["--raw-dims", "2,2,5", "--raw-type", "u8"],
            1,
            "a.raw: 4 bytes of voxels missing: 2 x 2 x 5 voxels of type u8",
        ),
        (&[], 1, "a.raw: this is in no format that Mobula knows; say of what: --raw-dims"),
    ] {
        if options.is_empty() {
            // What could be UTF-16 is something else here.
            folder.write("a.raw", [200; 16]);
        }
        let done = folder.run(&[&["info", "a.raw"], options].concat());
        assert_eq!(done.code, Some(code), "{options:?}: {done:?}");
        assert!(done.err.contains(expected), "{options:?}: {}", done.err);
    }
}

#[test]
fn broken_volumes_are_1_and_one_line() {
    let folder = Folder::new("volume-broken");
    folder.write("a.nrrd", nrrd("2000 2000 2000", "", &[0; 1000]));
    folder.write("a.nii", [0; 348]);
    folder.write("a.mha", "NDims = 2\n");
    for (name, expected) in [
        (
            "a.nrrd",
            "a.nrrd: 7999999000 bytes of voxels missing: 2000 x 2000 x 2000 voxels of type u8 take 8000000000 bytes;",
        ),
        ("a.nii", "a.nii: not a NIfTI file: "),
        ("a.mha", "a.mha:1: NDims is 2: a volume has three dimensions; "),
    ] {
        for command in ["info", "render"] {
            let done = folder.run(&[command, name]);
            assert_eq!((done.code, done.out.as_str()), (Some(1), ""), "{done:?}");
            let errors: Vec<_> = done.err.lines().filter(|line| line.starts_with("mobula: error: ")).collect();
            let [error] = errors[..] else { panic!("{}", done.err) };
            assert!(error.strip_prefix("mobula: error: ").unwrap().starts_with(expected), "{error}");
        }
    }
}

/// A ball that is brighter inside.
fn ball() -> Vec<u8> {
    let value = |i: i32| {
        let [x, y, z] = [i % 17 - 8, i / 17 % 17 - 8, i / 289 - 8];
        (200 - 3 * (x * x + y * y + z * z)).max(0) as u8
    };
    nrrd("17 17 17", "", &(0..17 * 17 * 17).map(value).collect::<Vec<_>>())
}

#[test]
fn volumes_are_shown_as_media() {
    let folder = Folder::new("volume-media");
    folder.write("ball.nrrd", ball());
    folder.write("own.txt", "mobula transfer 1\n0 1 0 0 0\n100 1 0 0 0\n120 1 0.9 0.5 2\n");
    folder.write(
        "maps.json",
        r#"[{"Name": "x", "RGBPoints": [0, 0, 0, 1, 200, 1, 0, 0], "Points": [0, 0, 0.5, 0, 200, 0.3, 0.5, 0]}]"#,
    );
    folder.write("pyramid.obj", PYRAMID);
    let mut seen = Vec::new();
    for options in [
        &["--transfer", "fire"][..],
        &["--transfer", "FIRE", "--shading", "on"],
        &["--transfer", "fire", "--window", "-20,90"],
        &["--transfer", "fire", "--cut", "-1,0,0,-9"],
        &["--transfer", "fire", "--iso", "150"],
        &["--transfer", "fire", "--volume-origin", "-8,-8,-8", "pyramid.obj"],
        &["--transfer", "labels"],
        &["--transfer", "bone"],
        &["--transfer", "own.txt"],
        &["--transfer", "maps.json"],
        &["--iso", "150"],
    ] {
        let how = ["--size", "60x40", "--samples", "1", "--json", "-o", "out.png"];
        let done = folder.run(&[&["render", "ball.nrrd"], options, &how[..]].concat());
        assert_eq!(done.code, Some(0), "{options:?}: {done:?}");
        let object: serde_json::Value = serde_json::from_str(&done.out).unwrap();
        assert_eq!(object["media"], usize::from(options[0] == "--transfer"), "{options:?}");
        let picture = support::picture(&folder.0.join("out.png"));
        assert!(!seen.contains(&picture), "{options:?} is as one before");
        seen.push(picture);
    }
    // Short steps come to nearly the same.
    let pictures = ["0.5", "0.125"].map(|cells| {
        let how = ["--step-length", cells, "--size", "60x40", "--samples", "1", "-o", "step.png"];
        let done = folder.run(&[&["render", "ball.nrrd", "--transfer", "viridis"], &how[..]].concat());
        assert_eq!(done.code, Some(0), "{done:?}");
        support::picture(&folder.0.join("step.png")).2
    });
    let worst = pictures[0].iter().zip(&pictures[1]).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(worst <= Some(2), "{worst:?}");
}

#[test]
fn what_is_wrong_with_options_of_media_is_told() {
    let folder = Folder::new("volume-media-wrong");
    folder.write("ball.nrrd", ball());
    folder.write("bad.txt", "mobula transfer 1\n5 1 0 0 0\n4 1 0 0 1\n");
    for (options, code, expected) in [
        (
            &["--transfer", "bones"][..],
            2,
            "neither a transfer function of this name nor such a file; there are bone, skin,",
        ),
        (&["--transfer", "bad.txt"], 1, "bad.txt:3: "),
        (&["--transfer", "ball.nrrd"], 1, "ball.nrrd"),
        (&["--window", "1,2"], 2, "--transfer"),
        (&["--transfer", "bone", "--window", "1"], 2, "two numbers with a comma"),
        (&["--transfer", "bone", "--window", "1,0"], 2, "the second above 0"),
        (&["--transfer", "bone", "--step-length", "0"], 2, "from 0.03125 to 16"),
        (&["--transfer", "bone", "--step", "1"], 2, "there is no step 1"),
        (&["--volume-origin", "1,2"], 2, "three numbers"),
    ] {
        let done = folder.run(&[&["render", "ball.nrrd", "--size", "8x8"], options].concat());
        assert_eq!((done.code, done.out.as_str()), (Some(code), ""), "{options:?}: {done:?}");
        assert!(done.err.contains(expected), "{options:?}: {}", done.err);
    }
}

#[test]
fn what_options_do_not_do_is_told() {
    let folder = Folder::new("volume-without-effect");
    folder.write("ball.nrrd", ball());
    folder.write("flat.nrrd", nrrd("4 4 1", "", &[7; 16]));
    folder.write("pyramid.obj", PYRAMID);
    for (options, message) in [
        (
            &["pyramid.obj", "--transfer", "bone", "--iso", "3", "--step", "4"][..],
            "--iso, --transfer, --step: there is no volume",
        ),
        (&["ball.nrrd", "--step-length", "1", "--shading", "on"], "--shading, --step-length: this is for --transfer"),
        (&["ball.nrrd", "--transfer", "bone", "--transfer", "fire"], "1 more of it than volumes (1)"),
        (&["ball.nrrd", "--transfer", "bone", "--transparent", "0.5"], "--transparent: this is for iso-surfaces"),
        (&["ball.nrrd", "--transfer", "bone", "--renderer", "depth"], "the renderer depth shows no media"),
        (&["flat.nrrd", "--transfer", "bone"], "flat: there is nothing between samples where an axis has only one"),
    ] {
        let how = ["--size", "16x16", "-o", "out.png", "-q"];
        let done = folder.run(&[&["render"], options, &how].concat());
        assert_eq!(done.code, Some(0), "{done:?}");
        let warned = done.err.lines().any(|line| line.starts_with("mobula: warning: ") && line.contains(message));
        assert!(warned, "{options:?}: {}", done.err);
    }
    let done = folder.run(&["render", "ball.nrrd", "--transfer", "bone", "--size", "16x16", "-o", "out.png", "-q"]);
    assert_eq!((done.code, done.err.as_str()), (Some(0), ""), "{done:?}");
}
