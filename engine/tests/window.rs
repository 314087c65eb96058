//! The window, end to end, on a display of its own. Needs `Xvfb` and `xdotool`; says so where they are missing.
#![cfg(target_os = "linux")]

#[path = "window/drag.rs"]
mod drag;
#[path = "window/session.rs"]
mod session;
mod support;

use std::fs;
use std::time::Duration;

use drag::drop_file;
use session::{Session, display, display_with, wait};
use support::{Folder, PYRAMID};

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
    // It may have come to rest at the first step, which is not told.
    if session.title().contains(", step 0 of 3") {
        session.xdotool("key Right");
        session.wait_title(", step 1 of 3");
    }
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
