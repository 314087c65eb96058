//! What the command says when something is wrong: one line, the right exit status, within a second or so.

mod support;

use std::fs;

use support::{Folder, PYRAMID};

/// The only line that is an error.
fn error_line(err: &str) -> &str {
    let lines: Vec<_> = err.lines().filter(|line| line.starts_with("mobula: error: ")).collect();
    assert_eq!(lines.len(), 1, "{err}");
    assert!(err.ends_with(&format!("{}\n", lines[0])) && !err.contains("panicked"), "{err}");
    lines[0].strip_prefix("mobula: error: ").unwrap()
}

#[test]
fn wrong_usage_is_2_and_says_what_is_right() {
    let folder = Folder::new("usage");
    folder.write("pyramid.obj", PYRAMID);
    for (options, expected) in [
        (&["--size", "0x0"][..], "both sides must be at least 1"),
        (&["--size", "100000x100000"], "at most 268435456 pixels (16384x16384)"),
        (&["--size", "99999999999999999999x9"], "at most 268435456 pixels"),
        (&["--size", "huge"], "WIDTHxHEIGHT"),
        (&["--threads", "0"], "1 to 1024 threads"),
        (&["--frames", "0"], "0 is not in 1.."),
        (&["--packet", "7"], "packets hold 1, 16, 64 or 256 rays"),
        (&["--isa", "mmx"], "scalar, sse2, avx2, avx512"),
        (&["--renderer", "x"], "raytracer, primary"),
        (&["--balancer", "x"], "work-queue"),
        (&["--sampler", "x"], "jittered"),
        (&["--samples", "3"], "square number"),
        (&["--accel", "x"], "bvh, bvh-fast, brute"),
        (&["--eye", "1,2"], "three numbers"),
        (&["--up", "x"], "y, z and auto"),
        (&["--fov", "180"], "1 to 170"),
        (&["--background", "2,0,0"], "0 to 1"),
        (&["-o", "a.jpg"], "a.jpg.png"),
        (&["--nonsense"], "--help"),
    ] {
        let done = folder.run(&[&["render", "pyramid.obj"], options].concat());
        assert_eq!(done.code, Some(2), "{options:?}: {done:?}");
        assert!(done.err.contains(expected), "{options:?}: {}", done.err);
        assert_eq!(done.out, "");
    }
    let done = folder.run(&["render", "gen:nothing"]);
    assert_eq!(done.code, Some(2));
    assert!(error_line(&done.err).contains("gen:terr1m"), "{}", done.err);
    let done = folder.mobula(&["render", "pyramid.obj"]).env("MOBULA_ISA", "mmx").output().unwrap();
    assert_eq!(done.status.code(), Some(2));
    assert_eq!(folder.files(), ["pyramid.obj"]);
}

#[test]
fn broken_files_are_1_and_name_file_and_line() {
    let folder = Folder::new("broken");
    folder.write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
    folder.write("number.obj", "v 0 0 zero\n");
    folder.write("empty.obj", "");
    folder.write("junk.obj", [0xff, 0xfe, 0, 3, 9, 10, 0, 0]);
    folder.write("cut.obj.gz", [0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3, 0x4b]);
    folder.write("mtl.obj", "mtllib bad.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("bad.mtl", "newmtl a\nKd red\n");
    for (file, expected) in [
        ("missing.obj", "missing.obj: no such file; check the path"),
        ("index.obj", "index.obj:4: vertex index 4 is out of range: 3 are defined; export the mesh again"),
        ("number.obj", "number.obj:1: coordinate 'zero' is not a number; "),
        ("empty.obj", "empty.obj:1: the file is empty; "),
        ("junk.obj", "junk.obj:1: binary data in a text file; "),
        ("cut.obj.gz", "cut.obj.gz:1: the gzip data ends too early; "),
        ("mtl.obj", "bad.mtl:2: Kd 'red' is not a finite number; "),
    ] {
        for command in [&["render", file][..], &["info", file]] {
            let done = folder.run(command);
            assert_eq!(done.code, Some(1), "{file}: {done:?}");
            assert!(error_line(&done.err).starts_with(expected), "{file}: {}", done.err);
            assert_eq!(done.out, "");
        }
    }
    assert!(!folder.files().contains(&"mobula.png".to_owned()));
}

#[test]
fn vertices_that_are_not_finite_are_a_warning() {
    let folder = Folder::new("nan");
    folder.write("nan.obj", format!("{PYRAMID}v nan 0 0\nv 1e39 1 1\nf 1 2 10\nf 1 2 11\n"));
    folder.write("pyramid.obj", PYRAMID);
    let view = ["--eye", "5,4,6", "--at", "0,0,0", "--size", "60x40", "-o"];
    for (file, out) in [("nan.obj", "nan.png"), ("pyramid.obj", "plain.png")] {
        let done = folder.run(&[&["render", file][..], &view, &[out]].concat());
        assert_eq!(done.code, Some(0), "{done:?}");
        assert_eq!(done.err.contains("nan.obj:15: 2 vertices are not finite"), file == "nan.obj", "{}", done.err);
    }
    assert!(fs::read(folder.0.join("nan.png")).unwrap() == fs::read(folder.0.join("plain.png")).unwrap());
}

#[test]
fn enormous_coordinates_end_well() {
    let folder = Folder::new("enormous");
    for scale in ["1e18", "1e30", "3e38", "1e-30", "1e-44"] {
        let text = format!("v 0 0 0\nv {scale} 0 0\nv 0 {scale} 0\nv 0 0 -{scale}\nf 1 2 3\nf 1 3 4\nf 2 3 4\n");
        folder.write("large.obj", text);
        let done = folder.run(&["render", "large.obj", "--size", "32x32"]);
        assert_eq!(done.code, Some(0), "{scale}: {done:?}");
    }
}

#[test]
fn pictures_that_cannot_be_written_are_1_and_name_the_file() {
    let folder = Folder::new("unwritable");
    folder.write("pyramid.obj", PYRAMID);
    fs::create_dir(folder.0.join("folder.png")).unwrap();
    let mut cases =
        vec![("none/out.png", "none/out.png: cannot be written: "), ("folder.png", "folder.png: cannot be ")];
    if std::path::Path::new("/dev/full").exists() {
        cases.push(("/dev/full", "/dev/full: cannot be written: "));
    }
    for (file, expected) in cases {
        let done = folder.run(&["render", "pyramid.obj", "--size", "32x32", "-o", file]);
        assert_eq!(done.code, Some(1), "{file}: {done:?}");
        assert!(error_line(&done.err).starts_with(expected), "{file}: {}", done.err);
    }
    assert_eq!(folder.files(), ["folder.png", "pyramid.obj"]);
}

/// Whether a process has a handler for the signal of Ctrl-C (2, the second bit); true where the system does not tell.
#[cfg(unix)]
fn catches_interrupts(process: u32) -> bool {
    let Ok(status) = fs::read_to_string(format!("/proc/{process}/status")) else { return true };
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    caught.is_none_or(|mask| u64::from_str_radix(mask.trim(), 16).unwrap() & 2 != 0)
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_no_half_written_picture() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    let folder = Folder::new("interrupt");
    folder.write("pyramid.obj", PYRAMID);
    let arguments = ["render", "pyramid.obj", "--size", "64x64", "--frames", "1000000000", "-o", "out.png"];
    let mut child = folder.mobula(&arguments).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.next().unwrap().unwrap().starts_with("mobula: "));
    let begun = Instant::now();
    while !catches_interrupts(child.id()) {
        assert!(begun.elapsed() < Duration::from_secs(60), "it catches no interrupt");
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(Duration::from_millis(200));
    let sent = Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130), "{status:?}");
    assert!(sent.elapsed() < Duration::from_secs(60), "a billion frames are not waited for");
    assert_eq!(folder.files(), ["pyramid.obj"]);
    let rest: Vec<_> = lines.map(Result::unwrap).collect();
    assert!(rest.iter().any(|line| line == "mobula: error: interrupted; nothing was written"), "{rest:?}");
}
