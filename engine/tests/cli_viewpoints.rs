//! `mobula render` with several channels, and with two eyes.

mod support;

use serde_json::Value;
use support::{Folder, PYRAMID, picture};

const COMMON: [&str; 7] = ["render", "pyramid.obj", "--size", "60x40", "--threads", "2", "--json"];

fn render(folder: &Folder, more: &[&str]) -> Value {
    folder.write("pyramid.obj", PYRAMID);
    let done = folder.run(&[&COMMON, more].concat());
    assert_eq!(done.code, Some(0), "{done:?}");
    serde_json::from_str(&done.out).unwrap()
}

#[test]
fn channel_0_is_the_plain_picture_and_the_others_differ() {
    let folder = Folder::new("channels");
    render(&folder, &["-o", "plain.png"]);
    let json = render(&folder, &["-o", "c.png", "--channels", "3", "--frames", "2"]);
    assert_eq!(json["outputs"], serde_json::json!(["c-0.png", "c-1.png", "c-2.png"]));
    assert_eq!(json["rays"]["primary"], 3 * 2 * 60 * 40 * 16);
    assert_eq!(folder.files(), ["c-0.png", "c-1.png", "c-2.png", "plain.png", "pyramid.obj"]);
    let [plain, zero, one, two] =
        ["plain.png", "c-0.png", "c-1.png", "c-2.png"].map(|name| picture(&folder.0.join(name)));
    assert_eq!(plain, zero);
    assert!(one != zero && two != zero && one != two);
}

#[test]
fn two_eyes_differ_and_are_joined() {
    let folder = Folder::new("stereo");
    render(&folder, &["-o", "side.png", "--stereo", "side-by-side"]);
    render(&folder, &["-o", "red.png", "--stereo", "anaglyph"]);
    render(&folder, &["-o", "far.png", "--stereo", "anaglyph", "--eye-distance", "1"]);
    let (width, height, side) = picture(&folder.0.join("side.png"));
    assert_eq!((width, height), (120, 40));
    let eye = |x0: usize| -> Vec<&[u8]> { (0..40).map(|y| &side[(y * 120 + x0) * 3..][..180]).collect() };
    let (left, right) = (eye(0).concat(), eye(60).concat());
    let differing = left.chunks(3).zip(right.chunks(3)).filter(|(left, right)| left != right).count();
    assert!(differing > 60 * 40 / 20, "only {differing} pixels differ");
    let (_, _, red) = picture(&folder.0.join("red.png"));
    for ((both, left), right) in red.chunks(3).zip(left.chunks(3)).zip(right.chunks(3)) {
        assert_eq!(both, [left[0], right[1], right[2]]);
    }
    assert_ne!(picture(&folder.0.join("far.png")).2, red, "the eye distance counts");
}

#[test]
fn wrong_stereo_is_refused() {
    let folder = Folder::new("wrong-stereo");
    for wrong in [
        &["--stereo", "cross-eyed"][..],
        &["--stereo", "anaglyph", "--channels", "2"],
        &["--eye-distance", "1"],
        &["--stereo", "anaglyph", "--eye-distance", "0"],
        &["--channels", "0"],
    ] {
        let done = folder.run(&[&COMMON, wrong].concat());
        assert_eq!(done.code, Some(2), "{done:?}");
    }
}
