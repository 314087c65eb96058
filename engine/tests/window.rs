//! The window, end to end, on a display of its own. Needs `Xvfb` and `xdotool`; says so where they are missing.
#![cfg(target_os = "linux")]

mod support;

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use support::{Folder, PYRAMID};

/// Ends a process that was started here when a test is over, however it ends.
struct Owned(Child);

impl Drop for Owned {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A virtual display, and its name.
fn display() -> Option<(Owned, String)> {
    for (program, argument) in [("Xvfb", "-help"), ("xdotool", "version")] {
        let found = Command::new(program).arg(argument).stdout(Stdio::null()).stderr(Stdio::null()).status();
        if found.is_err() {
            eprintln!("skipped: {program} is not installed (Debian: apt-get install xvfb xdotool)");
            return None;
        }
    }
    let mut server = Command::new("Xvfb");
    server.args(["-displayfd", "1", "-screen", "0", "800x600x24", "-nolisten", "tcp"]);
    let mut child = server.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut number = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut number).unwrap();
    Some((Owned(child), format!(":{}", number.trim())))
}

struct Session {
    name: String,
    window: String,
}

impl Session {
    fn xdotool(&self, arguments: &str) -> String {
        let output = Command::new("xdotool").args(arguments.split(' ')).env("DISPLAY", &self.name).output().unwrap();
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    fn title(&self) -> String {
        self.xdotool(&format!("getwindowname {}", self.window))
    }

    /// Waits until the title says something.
    fn wait_title(&self, text: &str) {
        wait(&format!("'{text}' in the title"), || self.title().contains(text));
    }
}

fn wait(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(30), "no {what} within 30 s");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn keys_mouse_size_and_screenshots() {
    let Some((_server, name)) = display() else { return };
    let folder = Folder::new("window");
    folder.write("pyramid.obj", PYRAMID);
    let mut command = folder.mobula(&["view", "pyramid.obj", "--size", "320x240", "--threads", "1"]);
    let mut viewer = Owned(command.env("DISPLAY", &name).stderr(Stdio::null()).spawn().unwrap());
    let mut session = Session { name, window: String::new() };
    wait("window", || {
        session.window = session.xdotool("search --name mobula:").lines().next().unwrap_or_default().to_owned();
        !session.window.is_empty()
    });
    session.xdotool(&format!("windowfocus --sync {}", session.window));
    session.wait_title("pyramid | 320x240 |");
    let picture = |number: u32, key: &str| {
        session.xdotool(&format!("key {key}"));
        let file = folder.0.join(format!("mobula-{number:04}.png"));
        wait(&format!("file {}", file.display()), || file.exists());
        fs::read(file).unwrap()
    };

    // The first picture is what the command without a window makes.
    let first = picture(1, "p");
    let done = folder.run(&["render", "pyramid.obj", "--size", "320x240", "-o", "same.png"]);
    assert_eq!(done.code, Some(0), "{done:?}");
    assert!(first == fs::read(folder.0.join("same.png")).unwrap(), "the screenshot differs from the rendered file");

    session.xdotool("mousemove 100 100 mousedown 1 mousemove --sync 160 130 mouseup 1");
    let turned = picture(2, "p");
    assert!(turned != first, "dragging turned nothing");
    session.xdotool("key Home");
    assert!(picture(3, "p") == first, "Home does not lead back");
    session.xdotool("click 4");
    assert!(picture(4, "p") != first, "the wheel moved nothing");

    session.xdotool("key s");
    session.wait_title("no shadows");
    session.xdotool("key plus");
    session.wait_title("2 threads");
    session.xdotool("key r");
    session.wait_title("primary");
    session.xdotool(&format!("windowsize {} 200 150", session.window));
    session.wait_title("200x150");
    let small = picture(5, "p");
    assert_eq!(support::picture(&folder.0.join("mobula-0005.png")).0, 200);
    assert!(!small.is_empty());

    session.xdotool("key Escape");
    let mut status = None;
    wait("end", || {
        status = viewer.0.try_wait().unwrap();
        status.is_some()
    });
    assert_eq!(status.unwrap().code(), Some(0));
}
