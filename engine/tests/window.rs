//! The window, end to end, on a display of its own. Needs `Xvfb` and `xdotool`; says so where they are missing.
#![cfg(target_os = "linux")]

mod support;

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
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
    display_with("800x600x24", &[])
}

/// As [`display`], with a screen of a size and options of the server's.
fn display_with(screen: &str, options: &[&str]) -> Option<(Owned, String)> {
    for (program, argument) in [("Xvfb", "-help"), ("xdotool", "version")] {
        let found = Command::new(program).arg(argument).stdout(Stdio::null()).stderr(Stdio::null()).status();
        if found.is_err() {
            eprintln!("skipped: {program} is not installed (Debian: apt-get install xvfb xdotool)");
            return None;
        }
    }
    let mut server = Command::new("Xvfb");
    // Without -noreset it starts anew when its last client leaves, which may be a search for the window, and drops who
    // comes meanwhile.
    server.args(["-displayfd", "1", "-screen", "0", screen, "-nolisten", "tcp", "-noreset"]).args(options);
    let mut child = server.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut number = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut number).unwrap();
    Some((Owned(child), format!(":{}", number.trim())))
}

/// A viewer on a display of its own.
struct Session {
    display: String,
    window: String,
    folder: Folder,
    viewer: Owned,
    /// What the viewer says on standard error, line by line.
    said: Arc<Mutex<Vec<String>>>,
}

impl Session {
    /// Starts a viewer and waits for its window.
    fn start(display: String, test: &str, options: &[&str]) -> Self {
        Self::show(display, test, &[&["a pyramid's.obj"], options].concat())
    }

    /// Gives the window the keyboard, and waits until it hears it.
    fn focus(&self) {
        self.xdotool(&format!("windowfocus --sync {}", self.window));
        // While the first keys of a virtual keyboard make it known to all, one may be missed. This one asks what is under the mouse.
        let before = self.said.lock().unwrap().len();
        wait("answer", || {
            self.xdotool("key x");
            self.said.lock().unwrap().len() > before
        });
        self.dismiss();
    }

    /// Any key ends messages over the picture.
    fn dismiss(&self) {
        self.xdotool("key shift");
    }

    /// Waits until something was said that contains a text; the last such line.
    fn heard(&self, text: &str) -> String {
        let mut found = None;
        wait(text, || {
            found = self.said.lock().unwrap().iter().rev().find(|line| line.contains(text)).cloned();
            found.is_some()
        });
        found.unwrap()
    }

    /// The same with a scene of the options.
    fn show(display: String, test: &str, options: &[&str]) -> Self {
        Self::show_in(Folder::new(test), display, options)
    }

    fn show_in(folder: Folder, display: String, options: &[&str]) -> Self {
        folder.write("a pyramid's.obj", PYRAMID);
        let header = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 9 9 9\nencoding: raw\n\n";
        let ball = (0..729_i32).map(|i| {
            let [x, y, z] = [i % 9 - 4, i / 9 % 9 - 4, i / 81 - 4];
            (200 - 4 * (x * x + y * y + z * z)).max(0) as u8
        });
        folder.write("ball.nrrd", header.bytes().chain(ball).collect::<Vec<u8>>());
        let particle = |i: usize| format!("{},{},1,{},{},0.7\n", i % 4 * 2, i / 4 * 2, i * 7 % 16, 1 + i % 3);
        let particles = (0..16).map(particle).collect::<String>();
        folder.write("cloud.csv", format!("x,y,z,heat,kind,radius\n{particles}"));
        for step in 0..3 {
            let header = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 9 9 9\nencoding: raw\n\n";
            let plane = (0..729).map(|i| if i / 81 > 2 * step { 200 } else { 20_u8 });
            folder.write(&format!("time{step}.nrrd"), header.bytes().chain(plane).collect::<Vec<u8>>());
        }
        // One sample, unless a test is about more: then the picture stays as it is.
        let usual: &[&str] = if options.contains(&"--samples") { &[] } else { &["--samples", "1"] };
        let mut command = folder.mobula(&[&["view"], options, usual].concat());
        let mut viewer = Owned(command.env("DISPLAY", &display).stderr(Stdio::piped()).spawn().unwrap());
        let said = Arc::<Mutex<Vec<String>>>::default();
        let (listener, lines) = (Arc::clone(&said), BufReader::new(viewer.0.stderr.take().unwrap()).lines());
        std::thread::spawn(move || lines.map_while(Result::ok).for_each(|line| listener.lock().unwrap().push(line)));
        let mut session = Self { display, window: String::new(), folder, viewer, said };
        wait("window", || {
            session.window = session.xdotool("search --name mobula:").lines().next().unwrap_or_default().to_owned();
            let ended = session.viewer.0.try_wait().unwrap();
            assert!(ended.is_none(), "no window, but {ended:?}: {:?}", session.said.lock().unwrap());
            !session.window.is_empty()
        });
        session
    }

    /// Waits for the viewer's end; its exit status.
    fn end(&mut self) -> Option<i32> {
        let mut status = None;
        wait("end", || {
            status = self.viewer.0.try_wait().unwrap();
            status.is_some()
        });
        status.unwrap().code()
    }

    fn xdotool(&self, arguments: &str) -> String {
        let output = Command::new("xdotool").args(arguments.split(' ')).env("DISPLAY", &self.display).output().unwrap();
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    fn title(&self) -> String {
        self.xdotool(&format!("getwindowname {}", self.window))
    }

    /// Waits until the title says something.
    fn wait_title(&self, text: &str) {
        wait(&format!("'{text}' in the title"), || self.title().contains(text));
    }

    /// Takes a screenshot by key. It must be, byte for byte, what `mobula render` makes of the options that the viewer tells,
    /// and the window must show it. Returns its pixels.
    fn screenshot(&self, number: u32) -> (u32, u32, Vec<u8>) {
        let name = format!("mobula-{number:04}.png");
        let options = || {
            let said = self.said.lock().unwrap();
            let line = said.iter().find(|line| line.starts_with(&format!("mobula: wrote {name}; ")));
            line.and_then(|line| line.split_once("mobula render ")).map(|(_, options)| options.to_owned())
        };
        self.xdotool("key p");
        wait(&name, || options().is_some());
        let options = options().unwrap();
        // As the line is, by a shell.
        let mut shell = Command::new("sh");
        let line = format!("\"$0\" render {options} -o again.png --threads 2");
        shell.args(["-c", &line, env!("CARGO_BIN_EXE_mobula")]).current_dir(&self.folder.0);
        // The viewer has no level forced on it either.
        shell.env_remove("MOBULA_ISA");
        let done = support::Done::new(shell.output().unwrap());
        assert_eq!(done.code, Some(0), "{done:?}");
        let read = |name: &str| fs::read(self.folder.0.join(name)).unwrap();
        assert!(read(&name) == read("again.png"), "{name} is not what {options} renders");
        let picture = support::picture(&self.folder.0.join(&name));
        self.dismiss();
        wait(&format!("{name} in the window"), || self.pixels().is_none_or(|pixels| pixels == picture));
        picture
    }

    /// Has the view written as a scene file by key, in a folder with other files of the kind; it must render to the picture of a
    /// screenshot. Returns its text.
    fn save(&self, number: u32, screenshot: u32) -> String {
        let name = format!("mobula-{number:04}.toml");
        self.xdotool("key v");
        wait(&name, || {
            self.said.lock().unwrap().iter().any(|line| line.starts_with(&format!("mobula: wrote {name}; ")))
        });
        let done = self.folder.run(&["render", &name, "-o", "again.png", "--threads", "2"]);
        let text = fs::read_to_string(self.folder.0.join(&name)).unwrap();
        self.dismiss();
        assert_eq!(done.code, Some(0), "{text}{done:?}");
        let read = |name: &str| fs::read(self.folder.0.join(name)).unwrap();
        let picture = format!("mobula-{screenshot:04}.png");
        assert!(read(&picture) == read("again.png"), "{picture} is not what this renders to:\n{text}");
        text
    }

    /// What the window shows: width, height and RGB. None where there is no `xwd` to ask.
    fn pixels(&self) -> Option<(u32, u32, Vec<u8>)> {
        let mut command = Command::new("xwd");
        let dump = command.args(["-silent", "-id", &self.window]).env("DISPLAY", &self.display).output().ok()?.stdout;
        if dump.is_empty() {
            return Some((0, 0, Vec::new())); // it changed its size in between
        }
        let word = |index: usize| u32::from_be_bytes(dump[index * 4..][..4].try_into().unwrap());
        // XWDFile.h: header size, ..., width 4, height 5, ..., bits per pixel 11, bytes per line 12, ..., colours 19.
        let (width, height, stride) = (word(4), word(5), word(12) as usize);
        assert_eq!(word(11), 32, "the display has 32 bits a pixel");
        let start = (word(0) + word(19) * 12) as usize;
        let rows = dump[start..].chunks_exact(stride).take(height as usize);
        // Lowest byte first: blue, green, red, nothing.
        let rgb =
            rows.flat_map(|row| row[..width as usize * 4].chunks_exact(4).flat_map(|p| [p[2], p[1], p[0]])).collect();
        Some((width, height, rgb))
    }
}

fn wait(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(60), "no {what} within 60 s");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn keys_mouse_size_and_screenshots() {
    let Some((_server, name)) = display() else { return };
    let mut session = Session::start(name, "window", &["--size", "320x240", "--threads", "1"]);
    // The viewer sets this title when it listens to events: focus that comes earlier may be missed, and keys with it.
    session.wait_title("a pyramid's | 320x240 |");
    session.focus();

    // The first picture is what the command without a window makes.
    let first = session.screenshot(1);
    let done =
        session.folder.run(&["render", "a pyramid's.obj", "--size", "320x240", "--samples", "1", "-o", "same.png"]);
    assert_eq!(done.code, Some(0), "{done:?}");
    let read = |name: &str| fs::read(session.folder.0.join(name)).unwrap();
    assert!(read("mobula-0001.png") == read("same.png"), "the screenshot differs from the rendered file");
    // Help is laid over the picture, page after page, and is gone again.
    session.xdotool("key h");
    wait("help over the picture", || session.pixels().is_none_or(|pixels| pixels != first));
    wait("the picture alone", || {
        session.xdotool("key h");
        std::thread::sleep(Duration::from_millis(200));
        session.pixels().is_none_or(|pixels| pixels == first)
    });

    session.xdotool("mousemove 100 100 mousedown 1 mousemove --sync 160 130 mouseup 1");
    let turned = session.screenshot(2);
    assert!(turned != first, "dragging turned nothing");
    session.save(1, 2);
    session.xdotool("key s");
    session.wait_title("no shadows");
    let bright = session.screenshot(3);
    let sum = |picture: &(u32, u32, Vec<u8>)| picture.2.iter().map(|&byte| u64::from(byte)).sum::<u64>();
    assert!(sum(&bright) > sum(&turned), "no shadow has gone");
    session.xdotool("key s");
    session.xdotool("key plus");
    session.wait_title("2 threads");
    assert!(session.screenshot(4) == turned, "shadows do not come back, or threads change the picture");
    session.xdotool("key minus");
    session.wait_title("1 thread |");
    session.xdotool("key Home");
    assert!(session.screenshot(5) == first, "Home does not lead back");
    session.xdotool("click 4");
    assert!(session.screenshot(6) != first, "the wheel moved nothing");
    session.xdotool("key r");
    session.wait_title("| ao,");
    session.xdotool("key a");
    session.wait_title("sobol");
    session.xdotool("key a");
    session.wait_title("single");
    session.xdotool(&format!("windowsize {} 200 150", session.window));
    session.wait_title("200x150");
    let small = session.screenshot(7);
    assert_eq!((small.0, small.1), (200, 150));
    let text = session.save(2, 7);
    assert!(text.starts_with("mobula = 1\n") && text.contains("mesh = \"a pyramid's.obj\""), "{text}");

    session.xdotool("key Escape");
    assert_eq!(session.end(), Some(0));
}

/// A window that is closed while frames are rendered, by the window manager's way or by the display going down.
#[test]
fn a_display_that_goes_away_ends_the_viewer() {
    let Some((server, name)) = display() else { return };
    let mut session = Session::start(name, "gone", &["--size", "320x240"]);
    drop(server);
    // Not a success, and not a signal.
    assert_eq!(session.end(), Some(1), "{:?}", session.said.lock().unwrap());
}

/// More than one request of X11 may hold, on a server that has no shared memory.
#[test]
fn a_large_picture_is_drawn_in_parts() {
    let Some((_server, name)) = display_with("2600x1900x24", &["-extension", "MIT-SHM"]) else { return };
    let mut session = Session::start(name, "strips", &["--size", "2500x1800", "--renderer", "primary"]);
    session.wait_title("a pyramid's | 2500x1800 |");
    let options = ["--size", "2500x1800", "--renderer", "primary", "--samples", "1", "-o", "same.png"];
    let done = session.folder.run(&[&["render", "a pyramid's.obj"], &options[..]].concat());
    assert_eq!(done.code, Some(0), "{done:?}");
    let picture = support::picture(&session.folder.0.join("same.png"));
    wait("picture", || session.pixels().is_none_or(|pixels| pixels == picture));
    session.xdotool(&format!("windowfocus --sync {}", session.window));
    let mut ended = None;
    wait("end", || {
        session.xdotool("key Escape");
        ended = session.viewer.0.try_wait().unwrap();
        ended.is_some()
    });
    assert_eq!(ended.unwrap().code(), Some(0), "{:?}", session.said.lock().unwrap());
}

#[test]
fn iso_values_are_changed_by_keys() {
    let Some((_server, name)) = display() else { return };
    let mut session = Session::show(name, "iso", &["ball.nrrd", "--size", "160x120", "--iso", "120"]);
    session.wait_title("ball | 160x120 |");
    session.xdotool(&format!("windowfocus --sync {}", session.window));
    wait("another value", || {
        session.xdotool("key period");
        !session.title().contains(", iso 120 ")
    });
    let smaller = session.screenshot(1);
    for _ in 0..40 {
        session.xdotool("key comma");
    }
    let larger = session.screenshot(2);
    assert!(larger != smaller, "the value changes nothing");
    session.xdotool("key Escape");
    assert_eq!(session.end(), Some(0));
}

#[test]
fn time_and_transfer_functions_are_changed_by_keys_and_mouse() {
    let Some((_server, name)) = display() else { return };
    let mut session = Session::show(name, "time", &["time*.nrrd", "--size", "160x120", "--transfer", "viridis"]);
    session.wait_title("time* | 160x120 |");
    session.focus();
    for step in [1, 2] {
        session.xdotool("key Right");
        session.wait_title(&format!(", step {step} of 3"));
    }
    let last = session.screenshot(1);
    session.xdotool("key Left");
    session.wait_title(", step 1 of 3");
    assert!(session.screenshot(2) != last, "the step changes nothing");
    session.xdotool("key space");
    session.wait_title(" a second");
    for step in [0, 2] {
        session.wait_title(&format!(", step {step} of 3"));
    }
    session.xdotool("key space");
    wait("rest", || !session.title().contains(" a second"));
    let before = session.screenshot(3);
    let window = |title: &str| title.split(", level ").nth(1).map(|rest| rest.split(" |").next().unwrap().to_owned());
    let first = window(&session.title());
    session.xdotool("key bracketright");
    wait("another level", || window(&session.title()) != first);
    assert!(session.screenshot(4) != before, "the level changes nothing");
    let second = window(&session.title());
    session.xdotool("mousemove 60 60 keydown ctrl mousedown 1 mousemove --sync 100 40 mouseup 1 keyup ctrl");
    wait("another width", || window(&session.title()) != second);
    session.xdotool("key t");
    session.wait_title(", inferno, level");
    session.screenshot(5);
    session.save(1, 5);
    session.xdotool("key bracketleft");
    session.screenshot(6);
    session.save(2, 6);

    // The line that tells of a screenshot says what was changed.
    let line = session.said.lock().unwrap().iter().rev().find(|line| line.contains("mobula-0005.png")).cloned();
    let line = line.expect("screenshots are told");
    assert!(line.contains(" --transfer inferno") && line.contains(" --step "), "{line}");
    session.xdotool("key Escape");
    assert_eq!(session.end(), Some(0));
}

#[test]
fn particles_among_volumes_are_cropped_and_coloured_by_keys() {
    let Some((_server, name)) = display() else { return };
    let options = ["cloud.csv", "ball.nrrd", "--size", "160x120", "--transfer", "viridis", "--opacity-by", "heat"];
    let mut session = Session::show(name, "particles", &[&options[..], &["--crop", "kind=1,1,3,3"]].concat());
    session.wait_title("| 160x120 |");
    session.focus();
    // Without the legend, which screenshots do not have.
    session.xdotool("key l");
    let usual = session.screenshot(1);
    session.xdotool("key bracketleft");
    wait("another level", || session.title().contains(", level "));
    session.xdotool("key c");
    session.wait_title(", keys move particles");
    session.xdotool("key braceleft");
    session.wait_title(", heat ");
    session.xdotool("key m");
    session.wait_title(", coloured by heat (");
    let cropped = session.screenshot(2);
    assert!(cropped != usual, "nothing was changed");
    session.save(1, 2);
    session.xdotool("key b");
    session.wait_title(", coloured by kind");
    assert!(session.screenshot(3) != cropped, "the attribute changes nothing");
    let text = session.save(2, 3);
    assert!(text.contains("kind = [[1.0, 1.0], [3.0, 3.0]]") && text.contains("by = \"heat\""), "{text}");
    let line = session.said.lock().unwrap().iter().rev().find(|line| line.contains("mobula-0003.png")).cloned();
    let line = line.expect("screenshots are told");
    assert!(line.contains(" --color-by kind") && line.contains(" --crop heat="), "{line}");
    session.xdotool("key Escape");
    assert_eq!(session.end(), Some(0));
}

#[test]
fn scene_files_are_shown_and_saved() {
    let Some((_server, name)) = display() else { return };
    let scene = "mobula = 1\nsize = [160, 120]\nbackground = \"#102040\"\ntime = { step = 0.5, loop = false }\n\
                 camera = { eye = [25, 20, 15], at = [4, 4, 4] }\n[materials]\nred = { kind = \"lambertian\", color = [0.8, 0.2, 0.1] }\n\
                 [[object]]\nmesh = \"../a pyramid's.obj\"\nmaterial = \"red\"\n\
                 [[object]]\nvolume = \"../time*.nrrd\"\niso = [{ value = 100, material = \"red\" }]\n";
    let folder = Folder::new("scene-file");
    fs::create_dir(folder.0.join("below")).unwrap();
    folder.write("below/scene.toml", scene);
    let mut session = Session::show_in(folder, name, &["below/scene.toml"]);
    session.wait_title("scene | 160x120 |");
    session.focus();
    session.screenshot(1);
    session.save(1, 1);
    session.xdotool("key Right");
    session.wait_title(", step 1 of 3");
    session.xdotool("mousemove 60 60 mousedown 1 mousemove --sync 100 40 mouseup 1");
    session.screenshot(2);
    let text = session.save(2, 2);
    assert!(text.contains("background = \"#102040\"") && text.contains("material = \"red\""), "{text}");
    // Time ends at the last step.
    session.xdotool("key space");
    session.wait_title(", step 2 of 3");
    wait("rest", || !session.title().contains(" a second"));
    session.xdotool("key Escape");
    assert_eq!(session.end(), Some(0));
}

/// While nothing moves the picture gets as many samples as it may, and is then that of the command without a window.
#[test]
fn still_pictures_are_refined() {
    let Some((_server, name)) = display() else { return };
    let options = ["--size", "160x120", "--samples", "37", "--ao=2", "--threads", "2"];
    let mut session = Session::start(name, "refined", &options);
    session.wait_title("a pyramid's | 160x120 |");
    session.focus();
    session.wait_title(", sobol:37,");
    let first = session.screenshot(1);
    let line = session.heard("wrote mobula-0001.png");
    assert!(line.contains(" --sampler sobol:37 "), "{line}");
    let text = session.save(1, 1);
    assert!(text.contains("sampler = \"sobol:37\""), "{text}");
    session.xdotool("mousemove 60 60 mousedown 1 mousemove --sync 100 40");
    session.wait_title(", single,");
    session.screenshot(2);
    // While the mouse holds it, it stays as it is.
    std::thread::sleep(Duration::from_millis(300));
    session.screenshot(3);
    assert!(session.heard("wrote mobula-0003.png").contains(" --sampler single "));
    session.xdotool("mouseup 1");
    session.wait_title(", sobol:37,");
    assert!(session.screenshot(4) != first, "dragging turned nothing");
    // Whatever has been taken of the samples has a name too.
    for number in 5..8 {
        session.xdotool("key s");
        session.xdotool("key p");
        session.heard(&format!("wrote mobula-{number:04}.png"));
    }
    session.xdotool("key Escape");
    assert_eq!(session.end(), Some(0));
}

#[test]
fn views_are_chosen_by_keys_and_places_by_clicks() {
    let Some((_server, name)) = display() else { return };
    let mut session = Session::start(name, "views", &["--size", "320x240"]);
    session.wait_title("a pyramid's | 320x240 |");
    session.focus();
    let first = session.screenshot(1);
    // A click tells what is there, a double click brings it into the middle.
    session.xdotool("mousemove --sync 160 120 click 1");
    let line = session.heard("triangle ");
    assert!(line.contains(", material ") && line.contains(" away"), "{line}");
    std::thread::sleep(Duration::from_millis(500));
    session.xdotool("mousemove --sync 3 3 click 1");
    session.heard("nothing is there");
    std::thread::sleep(Duration::from_millis(500));
    session.xdotool("mousemove --sync 180 140 click 1 click 1");
    session.dismiss();
    wait("another view", || session.pixels().is_none_or(|pixels| pixels != first));
    assert!(session.screenshot(2) != first, "a double click moves nothing");
    session.xdotool("key Home");
    assert!(session.screenshot(3) == first, "Home does not lead back");
    // From above, kept, from the front, and brought back.
    session.xdotool("key 5");
    wait("another view", || session.pixels().is_none_or(|pixels| pixels != first));
    let top = session.screenshot(4);
    session.xdotool("key ctrl+8");
    session.xdotool("key 1");
    let front = session.screenshot(5);
    session.xdotool("key 8");
    assert!(front != top && session.screenshot(6) == top, "the view that was kept does not come back");
    session.xdotool("key f");
    session.screenshot(7);
    session.xdotool("key u");
    std::thread::sleep(Duration::from_millis(500));
    session.xdotool("key u");
    assert!(session.screenshot(8) != top, "the turntable turns nothing");
    let before = session.screenshot(9);
    session.xdotool("key g keydown w");
    std::thread::sleep(Duration::from_millis(300));
    session.xdotool("keyup w");
    assert!(session.screenshot(10) != before, "w does not fly");
    // The first ends the flight.
    session.xdotool("key Escape");
    session.xdotool("key i");
    wait("the status", || session.pixels().is_none_or(|pixels| pixels != before));
    session.xdotool("key Escape");
    assert_eq!(session.end(), Some(0));
}

#[test]
fn files_that_change_are_loaded_again() {
    let Some((_server, name)) = display() else { return };
    let mut session = Session::start(name, "reload", &["--size", "160x120"]);
    session.wait_title("a pyramid's | 160x120 |");
    session.focus();
    let first = session.screenshot(1);
    session.xdotool("mousemove 60 60 mousedown 1 mousemove --sync 100 40 mouseup 1");
    let turned = session.screenshot(2);
    assert!(turned != first);
    // What cannot be read changes nothing but what is said.
    session.folder.write("a pyramid's.obj", "v 0 0\nf 1 2 3\n");
    session.heard("warning: a pyramid's.obj");
    session.dismiss();
    wait("the old scene", || session.pixels().is_none_or(|pixels| pixels == turned));
    session.folder.write("a pyramid's.obj", PYRAMID);
    wait("the scene again", || {
        session.said.lock().unwrap().iter().filter(|line| line.contains("loaded in")).count() > 1
    });
    session.wait_title("a pyramid's | 160x120 |");
    session.focus();
    assert!(session.screenshot(3) == turned, "the view is not kept");
    session.xdotool("key F5");
    wait("the scene again", || {
        session.said.lock().unwrap().iter().filter(|line| line.contains("loaded in")).count() > 2
    });
    session.xdotool("key Escape");
    // While it is loaded, the first cancels.
    let mut ended = None;
    wait("end", || {
        session.xdotool("key Escape");
        ended = session.viewer.0.try_wait().unwrap();
        ended.is_some()
    });
    assert_eq!(ended.unwrap().code(), Some(0), "{:?}", session.said.lock().unwrap());
}

/// What cannot be loaded ends the viewer as it ends other commands.
#[test]
fn a_scene_that_cannot_be_loaded_ends_the_viewer() {
    let Some((_server, name)) = display() else { return };
    let folder = Folder::new("broken");
    folder.write("broken.obj", "v 0 0\nf 1 2 3\n");
    for (scene, status) in [("broken.obj", 1), ("missing.obj", 1), ("gen:nothing", 2)] {
        let mut command = folder.mobula(&["view", scene]);
        let output = command.env("DISPLAY", &name).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(status), "{said}");
        assert!(said.lines().last().unwrap().starts_with("mobula: error: ") && said.contains(scene), "{said}");
    }
}

/// Drags a file from a window of another client onto a window, and drops it there: the XDND protocol, version 5.
fn drop_file(display: &str, window: u32, file: &std::path::Path) {
    use x11rb::connection::Connection as _;
    use x11rb::protocol::Event;
    use x11rb::protocol::xproto::{
        ClientMessageEvent, ConnectionExt as _, CreateWindowAux, EventMask, PropMode, SELECTION_NOTIFY_EVENT,
        SelectionNotifyEvent, WindowClass,
    };
    use x11rb::wrapper::ConnectionExt as _;

    let (client, screen) = x11rb::connect(Some(display)).unwrap();
    let atom = |name: &str| client.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom;
    let root = client.setup().roots[screen].root;
    let source = client.generate_id().unwrap();
    let nothing = CreateWindowAux::new();
    client.create_window(0, source, root, 0, 0, 1, 1, 0, WindowClass::INPUT_ONLY, 0, &nothing).unwrap();
    let (selection, list, status) = (atom("XdndSelection"), atom("text/uri-list"), atom("XdndStatus"));
    client.set_selection_owner(source, selection, 0_u32).unwrap();
    let send = |kind: &str, data: [u32; 5]| {
        let event = ClientMessageEvent::new(32, window, atom(kind), data);
        client.send_event(false, window, EventMask::NO_EVENT, event).unwrap();
        client.flush().unwrap();
    };
    send("XdndEnter", [source, 5 << 24, list, 0, 0]);
    send("XdndPosition", [source, 0, 50 << 16 | 50, 0, atom("XdndActionCopy")]);
    let (mut accepted, mut handed) = (false, false);
    wait("a drop that is accepted", || {
        while let Some(event) = client.poll_for_event().unwrap() {
            match event {
                Event::ClientMessage(message) if message.type_ == status => accepted = true,
                Event::SelectionRequest(request) => {
                    let text = format!("file://{}\r\n", file.display());
                    let property = if request.property == 0 { request.target } else { request.property };
                    let (requestor, target) = (request.requestor, request.target);
                    client.change_property8(PropMode::REPLACE, requestor, property, target, text.as_bytes()).unwrap();
                    let notify = SelectionNotifyEvent {
                        response_type: SELECTION_NOTIFY_EVENT,
                        sequence: 0,
                        time: request.time,
                        requestor,
                        selection: request.selection,
                        target,
                        property,
                    };
                    client.send_event(false, requestor, EventMask::NO_EVENT, notify).unwrap();
                    client.flush().unwrap();
                    handed = true;
                }
                _ => {}
            }
        }
        accepted && handed
    });
    send("XdndDrop", [source, 0, 0, 0, 0]);
    std::thread::sleep(Duration::from_millis(300));
}

#[test]
fn files_that_are_dropped_on_the_window_take_the_place_of_the_scene() {
    let Some((_server, name)) = display() else { return };
    let mut session = Session::start(name, "drop", &["--size", "160x120"]);
    session.wait_title("a pyramid's | 160x120 |");
    session.focus();
    let first = session.screenshot(1);
    let window = session.window.parse().unwrap();
    let folder = session.folder.0.canonicalize().unwrap();
    // What cannot be loaded changes nothing.
    session.folder.write("broken.obj", "v 0 0\nf 1 2 3\n");
    drop_file(&session.display, window, &folder.join("broken.obj"));
    session.heard("broken.obj");
    session.focus();
    assert!(session.screenshot(2) == first, "the old scene is gone");
    drop_file(&session.display, window, &folder.join("ball.nrrd"));
    session.wait_title("ball | 160x120 |");
    session.focus();
    assert!(session.screenshot(3) != first);
    assert!(session.heard("wrote mobula-0003.png").contains("ball.nrrd"));
    session.xdotool("key Escape");
    assert_eq!(session.end(), Some(0));
}
