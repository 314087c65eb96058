//! What the command says of particles, and what it shows: attributes, radii, tiles, steps of time, raw files.

mod support;

use support::{Folder, picture};

fn info(folder: &Folder, arguments: &[&str]) -> serde_json::Value {
    let done = folder.run(&[&["info", "--json"], arguments].concat());
    assert_eq!(done.code, Some(0), "{done:?}");
    serde_json::from_str(&done.out).unwrap()
}

#[test]
fn info_lists_attributes() {
    let folder = Folder::new("particles-info");
    folder.write(
        "a.csv",
        "# box 8 8 8\nx,y,z,speed,kind,radius\n0,0,0,0.5,1,0.5\n1,2,3,2.5,7,0.25\n3,1,2,nan,7,0.25\nnan,0,0,9,9,9\n",
    );
    let done = folder.run(&["info", "a.csv"]);
    assert_eq!(done.code, Some(0), "{done:?}");
    let spaces = " ".repeat(62);
    for line in [
        "  format                table of particles",
        "  bounds                (-0.5, -0.5, -0.5) to (3.25, 2.25, 3.25)",
        "  particles             4",
        "    particles that are not finite 1",
        "  particle set          a",
        "    steps of time       1",
        "    periodic box        8 x 8 x 8",
        "    radius              f32, 0.25 to 0.5, mean 0.333333",
        "    speed               f32, 0.5 to 2.5, mean 1.5, 1 not numbers",
        &format!("                        █{spaces}█"),
        "    kind                u8, 1 to 7, mean 5",
    ] {
        assert!(done.out.lines().any(|found| found == line), "{line}\n{}", done.out);
    }
    let object = info(&folder, &["a.csv"]);
    assert_eq!(
        (&object["particles"], &object["steps"], &object["non_finite_particles"]),
        (&4.into(), &1.into(), &1.into())
    );
    let kind = &object["attributes"][1];
    assert_eq!(
        (&kind["name"], &kind["type"], &kind["min"], &kind["max"]),
        (&"kind".into(), &"u8".into(), &1.0.into(), &7.0.into())
    );
    assert_eq!((&kind["histogram"][0], &kind["histogram"][63]), (&1.into(), &2.into()));
    assert_eq!((&object["radius"]["max"], &object["box"][1][1]), (&0.5.into(), &8.0.into()));
    assert_eq!(object["particle_sets"].as_array().unwrap().len(), 1);
}

#[test]
fn files_whose_names_differ_in_a_number_are_steps() {
    let folder = Folder::new("particles-steps");
    for (number, rows) in [(1, "0,0,0,1\n"), (2, "0,0,0,2\n1,1,1,3\n"), (10, "5,0,0,300\n")] {
        folder.write(&format!("t{number}.csv"), format!("x,y,z,kind\n{rows}"));
    }
    folder.write("t3.csv", "x,y,z,other\n1,2,3,4\n");
    let object = info(&folder, &["t10.csv", "t1.csv", "t2.csv"]);
    assert_eq!((&object["steps"], &object["name"]), (&3.into(), &"t*".into()));
    assert_eq!(object["particles_by_step"], serde_json::json!([1, 2, 1]));
    let kind = &object["attributes"][0];
    assert_eq!((&kind["type"], &kind["max"]), (&"f32".into(), &300.0.into()));
    assert_eq!(info(&folder, &["t?.csv"])["particle_sets"].as_array().unwrap().len(), 2);

    let small = ["--size", "32x24", "--samples", "1", "--radius", "0.5"];
    let shot = |step: &str, output: &str| {
        let done = folder
            .run(&[&["render", "t1.csv", "t2.csv", "t10.csv", "--step", step, "-o", output][..], &small].concat());
        assert_eq!(done.code, Some(0), "{done:?}");
        picture(&folder.0.join(output)).2
    };
    assert_ne!(shot("0", "a.png"), shot("1", "b.png"));
    let done = folder.run(&["render", "t1.csv", "t2.csv", "--step", "2"]);
    assert!(
        done.code == Some(2) && done.err.contains("t* has 2 steps of time, from 0; there is no step 2"),
        "{done:?}"
    );
}

#[test]
fn steps_that_do_not_fit_into_memory_are_read_when_they_are_shown() {
    let folder = Folder::new("particles-memory");
    for step in 0..5 {
        folder.write(&format!("t{step}.csv"), format!("x,y,z,heat\n{step},0,0,{step}\n{step},1,0,5\n4,{step},1,2\n"));
    }
    folder.write("all.toml", "mobula = 1\n[[object]]\nparticles = \"t*.csv\"\nradius = 0.4\ncolor = [1, 0, 0]\n");
    let render = |name: &str, arguments: &[&str]| {
        let name = format!("{name}.png");
        let usual = ["render", "--size", "48x36", "--samples", "1", "--step", "4", "-o", &name];
        let done = folder.run(&[&usual[..], arguments].concat());
        assert_eq!(done.code, Some(0), "{done:?}");
        picture(&folder.0.join(name))
    };
    let options = ["t*.csv", "--radius", "0.4", "--color-by", "heat", "--range", "0,5"];
    assert!(render("whole", &options) == render("some", &[&options[..], &["--memory", "1"]].concat()));
    assert!(render("scene", &["all.toml"]) == render("some", &["all.toml", "--memory", "1"]));

    let done = folder.run(&["info", "--memory", "1", "t*.csv"]);
    assert!(done.out.contains("steps of time       5, of which 1 were looked at (see --memory)"), "{done:?}");
    let object = info(&folder, &["--memory", "1", "t*.csv"]);
    assert_eq!(object["particles_by_step"].to_string(), "[3,null,null,null,null]");
    let done = folder.run(&["render", "--memory", "4 sheep", "t1.csv"]);
    assert!(done.code == Some(2) && done.err.contains("this is no size: write"), "{done:?}");
    folder.write("t4.csv", "x,y,z,heat\n1,2\n");
    let done =
        folder.run(&["render", "--memory", "1", "--step", "4", "t0.csv", "t1.csv", "t4.csv", "t2.csv", "t3.csv"]);
    assert!(done.code == Some(1) && done.err.contains("t4.csv:2: "), "{done:?}");
}

#[test]
fn radii_and_tiles() {
    let folder = Folder::new("particles-tiles");
    folder.write("a.csv", "x,y,z\n0,0,0\n1,1,1\n");
    folder.write("b.csv", "# box 2\nx,y,z,radius\n0,0,0,0.5\n1,1,1,0.5\n");
    let render = |options: &[&str]| {
        let done = folder.run(&[&["render", "--size", "32x24", "--samples", "1", "--json"], options].concat());
        assert!(done.code != Some(0) || done.err.contains("wrote"), "{done:?}");
        done
    };
    let guessed = render(&["a.csv"]);
    assert!(
        guessed.err.contains("a: particles have no radius; ") && guessed.err.contains("choose another with --radius")
    );
    assert!(!render(&["a.csv", "--radius", "0.3"]).err.contains("no radius"));
    assert!(!render(&["b.csv"]).err.contains("no radius"));
    let seen = |options: &[&str]| {
        assert_eq!(render(options).code, Some(0));
        picture(&folder.0.join("mobula.png")).2
    };
    let eye = ["--eye", "9,9,9", "--at", "1,1,1"];
    let one = seen(&[&["b.csv"][..], &eye].concat());
    let tiled = seen(&[&["b.csv", "--tile", "2,2,1"][..], &eye].concat());
    assert_ne!(one, tiled);
    assert_eq!(tiled, seen(&[&["a.csv", "--tile", "2,2,1", "--box", "2,2,2", "--radius", "0.5"][..], &eye].concat()));
    for (options, code, expected) in [
        (
            &["a.csv", "--tile", "2,2,2"][..],
            2,
            "--tile: a does not say how large its periodic box is: give its edges with --box X,Y,Z",
        ),
        (&["b.csv", "--tile", "99999,99999,99999"], 2, "particles are too many"),
        (&["b.csv", "--tile", "0,1,1"], 2, "three whole numbers above 0"),
        (&["b.csv", "--box", "1,1,1"], 2, "--tile"),
        (&["b.csv", "--radius", "-1"], 2, "--radius"),
        (&["b.csv", "--raw-layout", "x,y"], 2, "there is no z; write names"),
        (&["b.csv", "--raw-layout", "x,y,z", "--raw-dims", "1,1,1", "--raw-type", "f32"], 2, "cannot be used with"),
    ] {
        let done = render(options);
        assert_eq!(done.code, Some(code), "{options:?}: {done:?}");
        assert!(done.err.contains(expected), "{options:?}: {}", done.err);
    }
}

#[test]
fn raw_files_have_a_layout() {
    let folder = Folder::new("particles-raw");
    let bytes: Vec<u8> = [1.0_f32, 2.0, 3.0, 0.5, 7.0].iter().flat_map(|x| x.to_be_bytes()).collect();
    folder.write("a.raw", bytes);
    let object = info(&folder, &["a.raw", "--raw-layout", "x,y,z,radius,_", "--raw-type", "f32be"]);
    assert_eq!((&object["format"], &object["radius"]["min"]), (&"raw particles".into(), &0.5.into()));
    let done = folder.run(&["info", "a.raw", "--raw-layout", "x,y,z"]);
    assert!(done.code == Some(1) && done.err.contains("a.raw: 20 bytes are no whole number of particles"), "{done:?}");
}

/// A row of ten particles, of which each is faster than the one before; every second is of kind 2.
fn row() -> String {
    let line = |i: usize| format!("{i},0,0,{},{},0.4\n", i as f32 * 0.5, 1 + i % 2);
    format!("x,y,z,speed,kind,radius\n{}", (0..10).map(line).collect::<String>())
}

#[test]
fn attributes_decide_about_colours_and_what_is_shown() {
    let folder = Folder::new("particles-colours");
    folder.write("a.csv", row());
    folder.write("alone.csv", "x,y,z,radius\n4,0,0,0.4\n5,0,0,0.4\n6,0,0,0.4\n");
    let how =
        ["--size", "200x40", "--samples", "1", "--eye", "4.5,-20,0", "--at", "4.5,0,0", "--up", "z", "-o", "out.png"];
    let shown = |options: &[&str]| {
        let done = folder.run(&[&["render"], options, &how].concat());
        assert_eq!(done.code, Some(0), "{options:?}: {done:?}");
        (picture(&folder.0.join("out.png")).2, done.err)
    };
    let (usual, said) = shown(&["a.csv"]);
    assert!(
        said.contains("a: coloured by speed (viridis from 0 to 4.5); choose with --color-by, --map and --range"),
        "{said}"
    );
    assert!(usual == shown(&["a.csv", "--color-by", "speed", "--map", "viridis", "--range", "0,4.5"]).0);
    assert!(shown(&["a.csv", "--map", "turbo"]).0 == shown(&["a.csv", "--color-by", "speed", "--map", "turbo"]).0);
    let plain = shown(&["a.csv", "--color-by", "none"]).0;
    let others = [
        plain.clone(),
        shown(&["a.csv", "--color-by", "speed", "--map", "turbo"]).0,
        shown(&["a.csv", "--color-by", "speed", "--range", "1,2"]).0,
        shown(&["a.csv", "--color-by", "kind"]).0,
        shown(&["a.csv", "--color-by", "kind", "--map", "elements"]).0,
        shown(&["a.csv", "--legend"]).0,
    ];
    for (i, one) in others.iter().enumerate() {
        assert!(*one != usual && !others[..i].contains(one), "{i}");
    }
    let small = shown(&["a.csv", "--radius", "0.2", "--color-by", "none"]).0;
    folder.write("sized.csv", row().replace("kind,radius", "kind,mass"));
    assert!(small == shown(&["sized.csv", "--radius-by", "mass", "--radius", "0.5", "--color-by", "none"]).0);
    assert!(plain == shown(&["sized.csv", "--radius-by", "mass", "--color-by", "none"]).0);
    // What is cropped is not there, for light neither.
    let light = ["--light", "30,-40,50", "--color-by", "none"];
    let alone = shown(&[&["alone.csv"], &light[..]].concat()).0;
    assert!(alone == shown(&[&["a.csv", "--crop", "speed=2,3"], &light[..]].concat()).0);
    assert!(alone != shown(&[&["a.csv", "--crop", "speed=2,3.5"], &light[..]].concat()).0);
    let odd = shown(&[&["a.csv", "--crop", "kind=1,1"], &light[..]].concat()).0;
    assert!(odd == shown(&[&["a.csv", "--crop", "speed=0,0,1,1,2,2,3,3,4,4"], &light[..]].concat()).0);
    assert!(alone == shown(&[&["a.csv", "--crop", "kind=-inf,inf", "--crop", "speed=2,3"], &light[..]].concat()).0);
    // Other structures show the same.
    for accel in ["bvh-fast", "brute"] {
        assert!(usual == shown(&["a.csv", "--accel", accel]).0, "{accel}");
        assert!(odd == shown(&[&["a.csv", "--crop", "kind=1,1", "--accel", accel], &light[..]].concat()).0, "{accel}");
    }
}

#[test]
fn what_is_wrong_with_colours_and_crops_is_told() {
    let folder = Folder::new("particles-wrong-colours");
    folder.write("a.csv", row());
    for (options, code, message) in [
        (&["a.csv", "--color-by", "sped"][..], 2, "a has no attribute sped; there are speed, kind"),
        (&["a.csv", "--crop", "mass=1,2"], 2, "a has no attribute mass"),
        (&["a.csv", "--radius-by", "mass"], 2, "a has no attribute mass"),
        (&["a.csv", "--crop", "speed=3,2"], 2, "such as speed=0.1,9"),
        (&["a.csv", "--crop", "speed=3"], 2, "such as speed=0.1,9"),
        (&["a.csv", "--crop", "speed=1,2", "--crop", "speed=3,4"], 2, "write all ranges of an attribute in one"),
        (&["a.csv", "--crop", "speed=5,inf"], 0, "a: nothing is shown of it: speed is from 0 to 4.5"),
        (&["a.csv", "--color-by", "speed", "--range", "1,1"], 2, "the second greater"),
        (&["a.csv", "--color-by", "speed", "--map", "virids"], 2, "neither a colour map of this name nor such a file"),
        (&["a.csv", "--step", "3"], 2, "there is no step 3"),
        (&["gen:terr20k", "--crop", "speed=1,2", "--legend"], 0, "--crop: there are no particles"),
        (
            &["gen:terr20k", "--opacity", "1", "--opacity-by", "speed"],
            0,
            "--opacity, --opacity-by: there are no particles",
        ),
        (&["a.csv", "--opacity-by", "sped"], 2, "a has no attribute sped; there are speed, kind"),
        (&["a.csv", "--opacity-by", "speed=0:2"], 2, "the opacity of point 1 is not from 0 to 1"),
        (&["a.csv", "--opacity", "nan"], 2, "a number from 0 to 1"),
        (&["a.csv", "--color-by", "none", "--legend"], 0, "--legend: there are no particles whose colours"),
    ] {
        let done =
            folder.run(&[&["render"], options, &["--size", "16x16", "--samples", "1", "-o", "out.png"]].concat());
        assert_eq!(done.code, Some(code), "{options:?}: {done:?}");
        assert!(done.err.contains(message), "{options:?}: {}", done.err);
    }
}

#[test]
fn opacity_is_that_of_all_or_goes_by_an_attribute() {
    let folder = Folder::new("particles-opacity");
    folder.write("a.csv", row());
    let how =
        ["--size", "200x40", "--samples", "1", "--eye", "4.5,-20,0", "--at", "4.5,0,0", "--up", "z", "-o", "out.png"];
    let shown = |options: &[&str]| {
        let done = folder.run(&[&["render"], options, &how].concat());
        assert_eq!(done.code, Some(0), "{options:?}: {done:?}");
        picture(&folder.0.join("out.png")).2
    };
    let usual = shown(&["a.csv"]);
    assert!(usual == shown(&["a.csv", "--opacity", "1"]) && usual == shown(&["a.csv", "--opacity-by", "speed=0:1"]));
    let half = shown(&["a.csv", "--opacity", "0.5"]);
    assert!(half != usual && half == shown(&["a.csv", "--opacity-by", "speed=7:1", "--opacity", "0.5"]));
    let rising = shown(&["a.csv", "--opacity-by", "speed"]);
    assert!(rising != usual && rising == shown(&["a.csv", "--opacity-by", "speed=0:0,4.5:1"]));
    // What is wholly transparent is as if cropped.
    let slow = shown(&["a.csv", "--opacity-by", "speed=2:1,2:0"]);
    assert!(slow != usual && slow == shown(&["a.csv", "--crop", "speed=-inf,1.9"]));
    // Scene files say the same.
    let scene = |opacity: &str| {
        folder.write("a.toml", format!("mobula = 1\n[[object]]\nparticles = \"a.csv\"\nopacity = {opacity}\n"));
        shown(&["a.toml"])
    };
    assert!(scene("0.5") == half && scene("{ by = \"speed\", points = [[7, 1]], scale = 0.5 }") == half);
    assert!(scene("{ by = \"speed\" }") == rising);
}

#[test]
fn a_scene_file_says_what_raw_particles_are_and_shows_several_ranges() {
    let folder = Folder::new("particles-raw-scene");
    let numbers = (0..10).flat_map(|i| [9.0, i as f32, 0.0, 0.0, i as f32 * 0.5]);
    folder.write("a.raw", numbers.flat_map(f32::to_be_bytes).collect::<Vec<u8>>());
    folder.write(
        "a.toml",
        "mobula = 1\n[[object]]\nparticles = \"a.raw\"\nradius = 0.3\n\
         raw = { layout = [\"_\", \"x\", \"y\", \"z\", \"speed\"], type = \"f32be\" }\n\
         crop = { speed = [[0.5, 0.5], [2, inf]] }\n",
    );
    let shown = |options: &[&str]| {
        let done =
            folder.run(&[&["render"], options, &["--size", "100x30", "--samples", "1", "-o", "out.png"]].concat());
        assert_eq!(done.code, Some(0), "{options:?}: {done:?}");
        picture(&folder.0.join("out.png")).2
    };
    let raw = ["a.raw", "--raw-layout", "_,x,y,z,speed", "--raw-type", "f32be", "--radius", "0.3", "--crop"];
    let scene = shown(&["a.toml"]);
    assert!(scene == shown(&[&raw[..], &["speed=0.5,0.5,2,inf"]].concat()));
    assert!(scene != shown(&[&raw[..], &["speed=0.5,inf"]].concat()));
}

#[test]
fn a_scene_file_shows_particles_as_options_do() {
    let folder = Folder::new("particles-scene");
    folder.write("a.csv", row());
    let scene = "mobula = 1\n[materials]\ngrain = { kind = \"lambertian\", color = { by = \"speed\", map = \"inferno\", range = [0, 4] } }\n\
                 [[object]]\nparticles = \"a.csv\"\nradius = 0.3\nmaterial = \"grain\"\ncrop = { kind = [1, 1] }\n";
    folder.write("scene.toml", scene);
    folder.write("plain.toml", "mobula = 1\n[[object]]\nparticles = \"a.csv\"\n");
    folder.write("wrong.toml", "mobula = 1\n[[object]]\nparticles = \"a.csv\"\ncrop = { mass = [1, 2] }\n");
    let how = ["--size", "100x30", "--samples", "1", "-o", "out.png"];
    let shown = |options: &[&str]| {
        let done = folder.run(&[&["render"], options, &how].concat());
        assert_eq!(done.code, Some(0), "{options:?}: {done:?}");
        picture(&folder.0.join("out.png")).2
    };
    assert!(shown(&["plain.toml"]) == shown(&["a.csv"]));
    assert!(shown(&["scene.toml"]) != shown(&["plain.toml"]));
    let done = folder.run(&[&["render", "wrong.toml"], &how[..]].concat());
    assert!(done.code != Some(0) && done.err.contains("a has no attribute mass"), "{done:?}");
}
