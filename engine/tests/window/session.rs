//! A viewer on a virtual display of its own: what it is sent, what it shows and says.

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use super::support::{self, Folder, PYRAMID};

/// Ends a process that was started here when a test is over, however it ends.
pub(crate) struct Owned(pub(crate) Child);

impl Drop for Owned {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A virtual display, and its name.
pub(crate) fn display() -> Option<(Owned, String)> {
    display_with("800x600x24", &[])
}

/// As [`display`], with a screen of a size and options of the server's.
pub(crate) fn display_with(screen: &str, options: &[&str]) -> Option<(Owned, String)> {
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
pub(crate) struct Session {
    pub(crate) display: String,
    pub(crate) window: String,
    pub(crate) folder: Folder,
    pub(crate) viewer: Owned,
    /// What the viewer says on standard error, line by line.
    pub(crate) said: Arc<Mutex<Vec<String>>>,
}

impl Session {
    /// Starts a viewer and waits for its window.
    pub(crate) fn start(display: String, test: &str, options: &[&str]) -> Self {
        Self::show(display, test, &[&["a pyramid's.obj"], options].concat())
    }

    /// Gives the window the keyboard, and waits until it hears it.
    pub(crate) fn focus(&self) {
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
    pub(crate) fn dismiss(&self) {
        self.xdotool("key shift");
    }

    /// Waits until something was said that contains a text; the last such line.
    pub(crate) fn heard(&self, text: &str) -> String {
        let mut found = None;
        wait(text, || {
            found = self.said.lock().unwrap().iter().rev().find(|line| line.contains(text)).cloned();
            found.is_some()
        });
        found.unwrap()
    }

    /// The same with a scene of the options.
    pub(crate) fn show(display: String, test: &str, options: &[&str]) -> Self {
        Self::show_in(Folder::new(test), display, options)
    }

    pub(crate) fn show_in(folder: Folder, display: String, options: &[&str]) -> Self {
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
    pub(crate) fn end(&mut self) -> Option<i32> {
        let mut status = None;
        wait("end", || {
            status = self.viewer.0.try_wait().unwrap();
            status.is_some()
        });
        status.unwrap().code()
    }

    pub(crate) fn xdotool(&self, arguments: &str) -> String {
        let output = Command::new("xdotool").args(arguments.split(' ')).env("DISPLAY", &self.display).output().unwrap();
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    pub(crate) fn title(&self) -> String {
        self.xdotool(&format!("getwindowname {}", self.window))
    }

    /// Waits until the title says something.
    pub(crate) fn wait_title(&self, text: &str) {
        wait(&format!("'{text}' in the title"), || self.title().contains(text));
    }

    /// Takes a screenshot by key. It must be, byte for byte, what `mobula render` makes of the options that the viewer tells,
    /// and the window must show it. Returns its pixels.
    pub(crate) fn screenshot(&self, number: u32) -> (u32, u32, Vec<u8>) {
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
    pub(crate) fn save(&self, number: u32, screenshot: u32) -> String {
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
    pub(crate) fn pixels(&self) -> Option<(u32, u32, Vec<u8>)> {
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

pub(crate) fn wait(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(60), "no {what} within 60 s");
        std::thread::sleep(Duration::from_millis(50));
    }
}
