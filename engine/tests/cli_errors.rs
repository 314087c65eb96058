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
        (&["--frames", "0"], "1 or more"),
        (&["--packet", "-1"], "packets hold 1, 16, 64 or 256 rays, not -1"),
        (&["--packet", "7"], "packets hold 1, 16, 64 or 256 rays"),
        (&["--isa", "mmx"], "scalar, sse2, avx2, avx512"),
        (&["--renderer", "x"], "raytracer, ao, primary"),
        (&["--balancer", "x"], "work-queue"),
        (&["--sampler", "x"], "sobol"),
        (&["--samples", "0"], "1 to 65536 samples"),
        (&["--accel", "x"], "bvh, bvh-fast, brute"),
        (&["--eye", "1,2"], "three numbers"),
        (&["--up", "x"], "y, z and auto"),
        (&["--fov", "400"], "1 to 170"),
        (&["--fov", "180"], "pinhole has a field of view of at most 170 degrees"),
        (&["--background", "2,0,0"], "0 to 1"),
        (&["-o", "a.gif"], "png, jpg, jpeg, ppm or exr; name it a.png"),
        (&["-o", "a"], "name it a.png"),
        (&["--aperture", "-1"], "0 or more"),
        (&["--focus", "0"], "above 0"),
        (&["--turntable", "3", "--channels", "2"], "cannot be used with"),
        (&["--turntable", "3", "--traverser", "progressive"], "leave out --traverser"),
        (&["-o", "."], "that is a folder; name a file in it, such as ./mobula.png"),
        (&["--eye", "1,1,1", "--at", "1,1,1"], "--eye and --at must be different points"),
        (&["--nonsense"], "--help"),
    ] {
        let done = folder.run(&[&["render", "pyramid.obj"], options].concat());
        assert_eq!(done.code, Some(2), "{options:?}: {done:?}");
        assert!(done.err.contains(expected), "{options:?}: {}", done.err);
        assert_eq!(done.out, "");
    }
    for (words, expected) in [
        (&["rendr"][..], "is it `mobula render`?"),
        (&["inof", "pyramid.obj"], "is it `mobula info`?"),
        (&["--size", "8x8", "render"], "mobula render ..."),
        (&["RENDER"], "is it `mobula render`?"),
        (&["man", "rendr"], "there are render, "),
    ] {
        let done = folder.run(words);
        assert_eq!(done.code, Some(2), "{words:?}: {done:?}");
        assert!(error_line(&done.err).contains(expected), "{words:?}: {}", done.err);
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
    for (file, expected) in [
        ("missing.obj", "missing.obj: no such file; check the path"),
        ("index.obj", "index.obj:4: vertex index 4 is out of range: 3 are defined; count the vertices"),
        ("number.obj", "number.obj:1: coordinate 'zero' is not a number; "),
        ("empty.obj", "empty.obj:1: the file is empty; "),
        ("junk.obj", "junk.obj:1: not an OBJ file: "),
        ("cut.obj.gz", "cut.obj.gz:1: the gzip data ends too early; "),
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
        assert_eq!(done.err.contains("nan.obj:15: 1 vertex that is not finite"), file == "nan.obj", "{}", done.err);
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
    let mut cases = vec![("none/out.png", "none/out.png: cannot be written: ")];
    if std::path::Path::new("/dev/full").exists() {
        cases.push(("/dev/full", "/dev/full: cannot be written: "));
    }
    for (file, expected) in cases {
        let done = folder.run(&["render", "pyramid.obj", "--size", "32x32", "-o", file]);
        assert_eq!(done.code, Some(1), "{file}: {done:?}");
        assert!(error_line(&done.err).starts_with(expected), "{file}: {}", done.err);
    }
    assert_eq!(folder.files(), ["pyramid.obj"]);
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
    // Each frame takes many minutes.
    let size = ["--size", "4096x4096", "--samples", "1024", "--frames", "1000000000"];
    let arguments = [&["render", "pyramid.obj", "-o", "out.png"], &size[..]].concat();
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
    assert!(sent.elapsed() < Duration::from_secs(60), "neither a billion frames nor one are waited for");
    assert_eq!(folder.files(), ["pyramid.obj"]);
    let rest: Vec<_> = lines.map(Result::unwrap).collect();
    assert!(rest.iter().any(|line| line == "mobula: error: interrupted; nothing was written"), "{rest:?}");
}

#[test]
fn what_cannot_be_said_is_lost_and_what_cannot_be_delivered_is_1() {
    let folder = Folder::new("unsaid");
    folder.write("pyramid.obj", PYRAMID);
    let render = ["render", "pyramid.obj", "--size", "32x32", "--stats", "-o", "out.png"];
    let closed = || {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        writer
    };
    let written = || fs::remove_file(folder.0.join("out.png")).is_ok();
    let code = |command: &mut std::process::Command| command.status().unwrap().code();
    assert_eq!((code(folder.mobula(&render).stderr(closed())), written()), (Some(0), true));
    assert_eq!(code(folder.mobula(&["render", "none.obj"]).stderr(closed())), Some(1));
    assert_eq!(code(folder.mobula(&["--nonsense"]).stderr(closed())), Some(2));
    let answers = [&["info", "pyramid.obj"][..], &["info", "pyramid.obj", "--json"], &["--help"], &["--version"]];
    for arguments in answers {
        // Who closed the pipe knows.
        let done = support::Done::new(folder.mobula(arguments).stdout(closed()).output().unwrap());
        assert_eq!((done.code, done.err.contains("error")), (Some(1), false), "{arguments:?}: {done:?}");
    }
    let full = || fs::OpenOptions::new().write(true).open("/dev/full");
    if full().is_err() {
        return;
    }
    assert_eq!((code(folder.mobula(&render).stderr(full().unwrap())), written()), (Some(0), true));
    for arguments in answers.into_iter().chain([&[&render[..], &["--json"]].concat()[..]]) {
        let done = support::Done::new(folder.mobula(arguments).stdout(full().unwrap()).output().unwrap());
        assert_eq!(done.code, Some(1), "{arguments:?}: {done:?}");
        assert!(error_line(&done.err).starts_with("standard output cannot be written: "), "{done:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_is_overwritten_stays_what_it_is() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
    let folder = Folder::new("overwrite");
    folder.write("pyramid.obj", PYRAMID);
    folder.write("out.png", "");
    let longest = "n".repeat(251) + ".png";
    fs::set_permissions(folder.0.join("out.png"), PermissionsExt::from_mode(0o600)).unwrap();
    symlink("made.png", folder.0.join("link.png")).unwrap();
    for (name, file) in [("out.png", "out.png"), ("link.png", "made.png"), (&longest, &longest)] {
        let done = folder.run(&["render", "pyramid.obj", "--size", "16x8", "-o", name]);
        assert_eq!(done.code, Some(0), "{done:?}");
        assert_eq!(support::picture(&folder.0.join(file)).0, 16);
    }
    assert_eq!(fs::metadata(folder.0.join("out.png")).unwrap().mode() & 0o777, 0o600);
    assert!(folder.0.join("link.png").is_symlink());
    assert_eq!(folder.files(), ["link.png", "made.png", &longest, "out.png", "pyramid.obj"]);
}

#[cfg(unix)]
#[test]
fn signals_leave_no_unfinished_file() {
    use std::process::{Command, Stdio};
    let folder = Folder::new("unfinished");
    folder.write("pyramid.obj", PYRAMID);
    for (signals, expected) in [(&["-TERM"][..], 143), (&["-INT", "-INT"], 130)] {
        // Who is slow to look may miss it.
        let caught = (0..20).any(|_| {
            let arguments = ["render", "pyramid.obj", "--size", "2500x2000", "-o", "out.png"];
            let mut child = folder.mobula(&arguments).stderr(Stdio::null()).spawn().unwrap();
            let unfinished = || folder.files().iter().any(|name| name.ends_with(".tmp"));
            while !unfinished() && child.try_wait().unwrap().is_none() {
                std::thread::sleep(std::time::Duration::from_millis(1));
            }
            for signal in signals {
                Command::new("kill").args([*signal, &child.id().to_string()]).stderr(Stdio::null()).status().unwrap();
            }
            let code = child.wait().unwrap().code();
            let written = fs::remove_file(folder.0.join("out.png")).is_ok();
            assert_eq!(folder.files(), ["pyramid.obj"], "{signals:?}: {code:?}");
            code == Some(expected) && !written
        });
        assert!(caught, "{signals:?}: no signal came while the file was written");
    }
}

/// No stack is that large, so no thread can be started.
const NO_THREADS: (&str, &str) = ("RUST_MIN_STACK", "1152921504606846976");

#[test]
fn where_there_are_no_threads_one_renders() {
    let folder = Folder::new("threads");
    folder.write("pyramid.obj", PYRAMID);
    let render = ["render", "pyramid.obj", "gen:terr20k", "--size", "60x40", "--threads", "4", "-o"];
    let run = |out: &str| folder.mobula(&[&render[..], &[out]].concat()).env(NO_THREADS.0, NO_THREADS.1).output();
    let done = support::Done::new(run("alone.png").unwrap());
    assert_eq!(done.code, Some(0), "{done:?}");
    assert!(done.err.contains("mobula: warning: only 1 of 4 threads could be started"), "{done:?}");
    assert_eq!(folder.run(&[&render[..], &["out.png"]].concat()).code, Some(0));
    assert!(fs::read(folder.0.join("alone.png")).unwrap() == fs::read(folder.0.join("out.png")).unwrap());
    let scale = ["scale", "pyramid.obj", "--size", "16x16", "--rounds", "1", "--threads", "2"];
    let done = support::Done::new(folder.mobula(&scale).env(NO_THREADS.0, NO_THREADS.1).output().unwrap());
    assert_eq!(done.code, Some(1), "{done:?}");
    assert!(error_line(&done.err).contains("threads could be started"), "{done:?}");
}

#[cfg(all(target_os = "linux", target_pointer_width = "64"))]
#[test]
fn memory_that_is_refused_is_an_error() {
    let folder = Folder::new("memory");
    folder.write("pyramid.obj", PYRAMID);
    for (scene, size, expected) in [
        ("pyramid.obj", "16384x16384", "there is no memory for a picture of 16384x16384: it takes 1024 MiB"),
        ("pyramid.obj", "268435456x1", "there is no memory for a picture of 268435456x1: it takes 1024 MiB"),
        ("gen:terr1m", "16x16", "there is no memory to build over 1036288 primitives"),
        ("gen:terr10m", "16x16", "gen:terr10m: there is no memory"),
    ] {
        let limited = "ulimit -v 220000 && exec \"$0\" render --threads 1 -o out.png \"$@\"";
        let mut command = std::process::Command::new("sh");
        command.args(["-c", limited, env!("CARGO_BIN_EXE_mobula"), scene, "--size", size]).current_dir(&folder.0);
        let done = support::Done::new(command.output().unwrap());
        assert_eq!(done.code, Some(1), "{scene} {size}: {done:?}");
        assert!(error_line(&done.err).starts_with(expected), "{}", done.err);
    }
    assert_eq!(folder.files(), ["pyramid.obj"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_that_may_not_grow_is_an_error() {
    let folder = Folder::new("growth");
    folder.write("pyramid.obj", PYRAMID);
    let mut command = std::process::Command::new("sh");
    let limited = "ulimit -f 8 && exec \"$0\" render pyramid.obj --size 900x900 -o out.png";
    command.args(["-c", limited, env!("CARGO_BIN_EXE_mobula")]).current_dir(&folder.0);
    let done = support::Done::new(command.output().unwrap());
    assert_eq!(done.code, Some(1), "{done:?}");
    assert!(error_line(&done.err).starts_with("out.png: cannot be written: "), "{done:?}");
    assert_eq!(folder.files(), ["pyramid.obj"]);
}

#[cfg(all(feature = "window", target_os = "linux"))]
#[test]
fn without_a_display_scenes_are_told_of_first() {
    let folder = Folder::new("display");
    folder.write("pyramid.obj", PYRAMID);
    let done = folder.run(&["view", "pyramid.obj"]);
    assert_eq!(done.code, Some(1), "{done:?}");
    let line = error_line(&done.err);
    assert!(line.starts_with("cannot open a window: ") && line.ends_with("writes a picture instead"), "{line}");
    assert!(!line.contains(".rs") && !line.contains("/"), "{line}");
    let done = folder.run(&["view", "none.obj"]);
    assert!(error_line(&done.err).starts_with("none.obj: no such file"), "{done:?}");
}

#[cfg(all(target_os = "linux", target_pointer_width = "64"))]
#[test]
fn no_memory_in_the_middle_of_something_is_a_failure_too() {
    let folder = Folder::new("little");
    folder.write("pyramid.obj", PYRAMID);
    for (limit, words) in [
        (360_000, &["-s", "4000", "--samples", "1", "--stereo", "anaglyph", "pyramid.obj"][..]),
        (150_000, &["-s", "3000", "--samples", "1", "--stereo", "side-by-side", "pyramid.obj"]),
        (75_000, &["-s", "64", "-t", "16", "gen:terr245k"]),
    ] {
        let limited = format!("ulimit -v {limit} && exec \"$0\" render -o out.png \"$@\"");
        let mut command = std::process::Command::new("sh");
        command.args(["-c", &limited, env!("CARGO_BIN_EXE_mobula")]).args(words).current_dir(&folder.0);
        let done = support::Done::new(command.output().unwrap());
        assert_eq!(done.code, Some(1), "{words:?}: {done:?}");
        assert!(done.err.contains("memory"), "{words:?}: {}", done.err);
    }
    assert_eq!(folder.files(), ["pyramid.obj"]);
}
