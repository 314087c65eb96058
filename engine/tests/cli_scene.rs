//! Scene files: the examples of their page, what goes wrong with them, and what wins.

mod support;

use serde_json::Value;
use support::{Folder, PYRAMID};

const PAGE: &str = include_str!("../src/load/scene_file/SCENES.md");

fn nrrd(value: impl Fn([i32; 3]) -> i32) -> Vec<u8> {
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 17 17 17\nencoding: raw\n\n";
    let voxel = |i: i32| value([i % 17 - 8, i / 17 % 17 - 8, i / 289 - 8]).clamp(0, 255) as u8;
    header.bytes().chain((0..17 * 17 * 17).map(voxel)).collect()
}

/// A picture that is bright in its upper half.
fn png(width: u32, height: u32) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let pixels =
        (0..width * height).flat_map(|i| [if i < width * height / 2 { 230 } else { 60 }, (i % width * 9) as u8, 90]);
    encoder.write_header().unwrap().write_image_data(&pixels.collect::<Vec<u8>>()).unwrap();
    file
}

/// A folder with all files that examples name.
fn folder(test: &str) -> Folder {
    let folder = Folder::new(test);
    folder.write("pyramid.obj", PYRAMID);
    folder.write("ball.nrrd", nrrd(|[x, y, z]| 200 - 3 * (x * x + y * y + z * z)));
    folder.write("around.png", png(16, 8));
    folder.write("flat.png", png(8, 8));
    for step in 0..3 {
        folder.write(&format!("wave_{step}.nrrd"), nrrd(|[x, y, z]| 200 - 20 * (z - 3 * step + x * y / 16).abs()));
    }
    for step in 0..3 {
        let row = |i: i32| format!("{},{},{},{}\n", i % 4 * 4, i / 4 % 4 * 4, i / 16 * 4 + step, f64::from(i) * 0.06);
        folder.write(&format!("flow_{step}.csv"), format!("x,y,z,speed\n{}", (0..64).map(row).collect::<String>()));
    }
    folder.write("smoke.raw", (0..4096_u32).map(|i| (i % 16 * 9 + i / 256) as u8).collect::<Vec<_>>());
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data");
    for name in ["fzk_house.obj.gz", "fzk_house.mtl"] {
        folder.write(name, std::fs::read(format!("{data}/{name}")).unwrap());
    }
    folder
}

fn examples() -> Vec<&'static str> {
    PAGE.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

fn json(folder: &Folder, arguments: &[&str]) -> Value {
    let done = folder.run(&[arguments, &["--json"]].concat());
    assert_eq!(done.code, Some(0), "{arguments:?}: {done:?}");
    serde_json::from_str(&done.out).unwrap()
}

/// Renders at a small size; the pixels.
fn render(folder: &Folder, arguments: &[&str]) -> Vec<u8> {
    let how = ["--size", "48x36", "--samples", "1", "-q", "-o", "out.png"];
    let done = folder.run(&[&["render"], arguments, &how].concat());
    assert_eq!((done.code, done.err.as_str()), (Some(0), ""), "{arguments:?}");
    support::picture(&folder.0.join("out.png")).2
}

#[test]
fn the_examples_of_the_page_are_rendered() {
    let folder = folder("scene-examples");
    let examples = examples();
    assert_eq!(examples.len(), 6);
    let mut seen = Vec::new();
    for (number, text) in examples.iter().enumerate() {
        let name = format!("example{number}.toml");
        folder.write(&name, text);
        let picture = render(&folder, &[&name]);
        let (first, others) = picture.as_chunks::<3>().0.split_first().unwrap();
        assert!(others.iter().any(|pixel| pixel != first), "{name} is of one colour");
        assert!(!seen.contains(&picture));
        seen.push(picture);
    }
    let found = |number: usize| json(&folder, &["info", &format!("example{number}.toml")]);
    let first = found(0);
    assert_eq!((&first["format"], &first["lights"]), (&"Mobula scene".into(), &1.into()));
    assert_eq!((&first["spheres"], &first["material_names"]), (&2.into(), &serde_json::json!(["clay", "glass"])));
    assert_eq!(
        first["objects"],
        serde_json::json!([
            { "kind": "mesh", "names": ["pyramid.obj"], "material": "clay" },
            { "kind": "spheres", "names": ["2 spheres"], "material": "glass" },
        ])
    );
    assert_eq!((&found(2)["steps"], &found(2)["volume"]), (&3.into(), &"wave_*".into()));
    assert_eq!((&found(2)["particles"], &found(2)["objects"][0]["material"]), (&192.into(), &"grain".into()));
    assert_eq!(found(3)["materials"], 1);
    assert_eq!((&found(4)["dimensions"], &found(4)["type"]), (&serde_json::json!([16, 16, 16]), &"u8".into()));
    let done = folder.run(&["info", "example0.toml"]);
    for line in ["  mesh                  pyramid.obj, clay", "  spheres               2 spheres, glass"] {
        assert!(done.out.lines().any(|found| found == line), "{}", done.out);
    }
    // What the file says of the picture.
    let object = json(&folder, &["render", "example0.toml", "-o", "own.png"]);
    assert_eq!((&object["size"], &object["camera"]), (&serde_json::json!([320, 240]), &"pinhole".into()));
    assert_eq!(json(&folder, &["render", "example2.toml", "--size", "8", "-o", "own.png"])["camera"], "orthographic");
    assert_eq!(json(&folder, &["render", "example1.toml", "--size", "8", "-o", "own.png"])["sampler"], "sobol:4");
    assert_eq!(json(&folder, &["render", "example3.toml", "--size", "8", "-o", "own.png"])["shadows"], false);
}

#[test]
fn files_say_what_options_say() {
    let folder = folder("scene-options");
    for (number, (text, options)) in [
        ("[[object]]\nmesh = \"pyramid.obj\"\n", &["pyramid.obj"][..]),
        (
            "background = \"#ff8800\"\nfog = { density = 0.1, color = [1, 0.5, 0] }\nshadows = false\n\
             camera = { eye = [3, 2, 5], at = [0, 1, 0], fov = 50 }\n[[object]]\nmesh = \"pyramid.obj\"\n\
             [[light]]\nkind = \"point\"\nat = [1, 9, 4]\ncolor = [0.95, 0.90, 0.82]\n",
            &[
                "pyramid.obj", "--background", "#ff8800", "--fog", "0.1,1,0.5,0", "--no-shadows", "--light", "1,9,4",
                "--eye", "3,2,5", "--at", "0,1,0", "--fov", "50",
            ],
        ),
        ("[[object]]\nvolume = \"ball.nrrd\"\niso = [150]\n", &["ball.nrrd", "--iso", "150"]),
        (
            "[[object]]\nvolume = \"ball.nrrd\"\ntransfer = \"bone\"\nwindow = [90, 200]\ncut = [[0, 0, 1, 10]]\n\
             iso = [{ value = 100, transparent = 0.5 }, 180]\n",
            &["ball.nrrd", "--transfer", "bone", "--window", "90,200", "--cut", "0,0,1,10", "--iso", "100,180", "--transparent", "0.5,0"],
        ),
        (
            "time = { show = 2 }\nrenderer = \"depth\"\n[[object]]\nvolume = [\"wave_0.nrrd\", \"wave_1.nrrd\", \"wave_2.nrrd\"]\niso = [120]\n",
            &["wave_*.nrrd", "--iso", "120", "--step", "2", "--renderer", "depth"],
        ),
        (
            "[[object]]\nvolume = \"smoke.raw\"\nraw = { dims = [16, 16, 16], type = \"u8\" }\niso = [90]\n",
            &["smoke.raw", "--raw-dims", "16,16,16", "--raw-type", "u8", "--iso", "90"],
        ),
        ("background = \"daylight:30,200\"\nground = true\n[[object]]\nmesh = \"pyramid.obj\"\n",
            &["pyramid.obj", "--background", "daylight:30,200,3", "--ground"]),
        ("background = { file = \"around.png\" }\n[[object]]\nmesh = \"pyramid.obj\"\n[[light]]\nkind = \"camera\"\n",
            &["pyramid.obj", "--background", "around.png", "--light", "camera"]),
        ("smooth = 180\n[[object]]\nmesh = \"pyramid.obj\"\n", &["pyramid.obj", "--smooth", "180"]),
        ("[[object]]\nmesh = \"gen:terr20k\"\n", &["gen:terr20k"]),
        ("[[object]]\nmesh = \"gen:built-in\"\n", &[]),
    ]
    .into_iter()
    .enumerate()
    {
        let name = format!("scene{number}.toml");
        folder.write(&name, format!("# A comment may stand before.\n\nmobula = 1\n{text}"));
        assert!(render(&folder, &[&name]) == render(&folder, options), "{text}");
    }
    // Options win; they are also for volumes of which the file says nothing.
    let plain = render(&folder, &["pyramid.obj"]);
    for options in [
        &["--background", "black"][..],
        &["--eye", "5,5,5"],
        &["--fog", "0.2"],
        &["--light", "9,9,0"],
        &["--light", "camera"],
        &["--ground"],
        &["--background", "daylight"],
        &["--background", "around.png"],
        &["--smooth", "120"],
    ] {
        let both = [&["scene0.toml"], options].concat();
        let pictures = [render(&folder, &both), render(&folder, &[&["pyramid.obj"], options].concat())];
        assert!(pictures[0] == pictures[1] && pictures[0] != plain, "{options:?}");
    }
    folder.write("unsaid.toml", "mobula = 1\n[[object]]\nvolume = \"ball.nrrd\"\n");
    assert!(render(&folder, &["unsaid.toml", "--iso", "150"]) == render(&folder, &["scene2.toml"]));
    // A scene beside other files, from another folder.
    std::fs::create_dir_all(folder.0.join("below")).unwrap();
    folder.write("below/up.toml", "mobula = 1\n[[object]]\nmesh = \"../pyramid.obj\"\n");
    assert!(render(&folder, &["below/up.toml"]) == plain);
    assert_eq!(json(&folder, &["info", "below/up.toml", "ball.nrrd"])["objects"].as_array().unwrap().len(), 2);
    let warned = folder.run(&["render", "scene2.toml", "--iso", "9", "--size", "8", "-q", "-o", "out.png"]);
    assert!(warned.err.contains("--iso: the scene says itself what its volumes are shown as"), "{}", warned.err);
}

#[test]
fn what_is_wrong_with_a_scene_is_told_where_it_is() {
    let folder = folder("scene-wrong");
    folder.write("other.toml", "mobula = 1\n");
    let many = "[[object]]\nspheres = []\n".repeat(4097);
    let often = "[[object]]\nmesh = \"pyramid.obj\"\n".repeat(17);
    let several = (0..4097).map(|i| format!("a{i} = {{ kind = \"flat\" }}\n")).collect::<String>();
    let several = format!("[materials]\n{several}");
    let deep = format!("background = {}{}\n", "[".repeat(5000), "]".repeat(5000));
    let dotted = format!("{}x = 1\n", "a.".repeat(5000));
    let mut wrong = Vec::new();
    let glass = "[materials]\nglass = { kind = \"phong\" }\n";
    for (text, expected) in [
        // Line, column, and what may have been meant.
        (
            "camra = { fov = 3 }\n",
            "a.toml:2:1: there is no key `camra` here; do you mean camera? the keys here are mobula, size",
        ),
        ("camera = { fov = 30, eyes = [0, 0, 1] }\n", "a.toml:2:22: there is no key `eyes` here; do you mean eye?"),
        ("[[object]]\nmesh = \"pyramid.obj\"\nradius = 2\n", "a.toml:4:1: there is no key `radius` here; "),
        ("[[object]]\nmeshh = \"pyramid.obj\"\n", "a.toml:3:1: there is no key `meshh` here; do you mean mesh?"),
        (
            "[[object]]\nmesh = \"pyramid.obj\"\nmaterial = \"glas\"\n[materials]\nglass = { kind = \"phong\" }\n",
            "a.toml:4:12: no material is called \"glas\"; do you mean glass?",
        ),
        (
            "[[object]]\nmesh = \"pyramid.obj\"\nmaterial = \"glas\"\n",
            "a.toml:4:12: no material is called \"glas\"; define it",
        ),
        ("[materials]\na = { kind = \"fong\" }\n", "a.toml:3:14: no material is called \"fong\"; do you mean phong?"),
        (
            "[materials]\na = { color = 1 }\n",
            "a.toml:3:5: this material has no kind; write kind = \"...\"; there are lambertian",
        ),
        (
            "[materials]\na = { kind = \"flat\", ior = 1.5 }\n",
            "a.toml:3:22: there is no key `ior` here; the keys here are color",
        ),
        ("[materials]\na = 3\n", "a.toml:3:5: a material is a table"),
        ("materials = 3\n", "a.toml:2:13: materials is no table"),
        ("renderer = \"raytracr\"\n", "a.toml:2:12: no renderer is called \"raytracr\"; there are: raytracer"),
        ("sampler = \"sobol:0\"\n", "a.toml:2:11: no pixel sampler is called"),
        (
            "background = \"pink\"\n",
            "a.toml:2:14: invalid value: string \"pink\", expected sky, daylight, black, white, a colour",
        ),
        // Numbers.
        (
            "camera = { fov = nan }\n",
            "a.toml:2:18: invalid value: floating point `NaN`, expected an angle from 1 to 360",
        ),
        ("camera = { fov = 200 }\n", "a.toml:2:10: this camera has a field of view of at most 170"),
        (
            "[materials]\na = { kind = \"wireframe\", width = 1, relative_width = 0.1 }\n",
            "a.toml:3:5: there are several widths of lines",
        ),
        (
            "[materials]\na = { kind = \"principled\", roughness = 2 }\n",
            "a.toml:3:40: invalid value: integer `2`, expected a number from 0 to 1",
        ),
        ("camera = { eye = [0, 0, inf] }\n", "a.toml:2:25: invalid value: "),
        ("camera = { eye = [0, 0, 1e300] }\n", "a.toml:2:25: invalid value: "),
        ("camera = { eye = [0, 0] }\n", "a.toml:2:18: invalid length 2"),
        ("camera = { eye = [0, 0, 0], at = [0, 0, 0] }\n", "a.toml:2:10: the eye is where it looks at"),
        ("camera = { up = [0, 0, 0] }\n", "a.toml:2:10: up leads nowhere"),
        ("size = [0, 100]\n", "a.toml:2:9: invalid value: integer `0`, expected a whole number from 1 on"),
        ("size = [99999999999, 100]\n", "a.toml:2:8: "),
        ("size = [99999999999999999999, 100]\n", "a.toml:2:9: "),
        ("time = { show = -1 }\n", "a.toml:2:17: invalid value: integer `-1`, expected a whole number from 0 on"),
        ("time = { step = 0 }\n", "a.toml:2:17: invalid value: integer `0`, expected a number above 0"),
        ("shadows = \"no\"\n", "a.toml:2:11: invalid type: string \"no\", expected a boolean"),
        ("fog = { color = 1 }\n", "a.toml:2:7: the key `density` is missing; write density = ..."),
        ("ambient = [0.1, -0.1, 0]\n", "a.toml:2:11: invalid value: "),
        ("[[light]]\nkind = \"point\"\n", "a.toml:2:1: the key `at` is missing"),
        (
            "[[light]]\nkind = \"spott\"\n",
            "a.toml:3:8: no light is called \"spott\"; do you mean spot? there are point, spot, directional",
        ),
        ("[[light]]\nkind = \"spot\"\nat = [0, 1, 0]\nto = [0, 1, 0]\n", "a.toml:2:1: the light is where it shines to"),
        (
            "[[light]]\nkind = \"spot\"\nat = [0, 1, 0]\nto = [0, 0, 0]\ninner = 50\nouter = 40\n",
            "a.toml:2:1: the bright cone, of 50 degrees, is wider than the whole, of 40",
        ),
        (
            "[[light]]\nkind = \"rectangle\"\nat = [0, 1, 0]\nto = [0, 0, 0]\nsize = [1, 0]\n",
            "a.toml:6:12: invalid value: ",
        ),
        ("[[light]]\nkind = \"sphere\"\nat = [0, 1, 0]\nradius = -1\n", "a.toml:5:10: invalid value: "),
        ("[[light]]\nkind = \"disk\"\nat = [0, 1, 0]\nradius = 1\n", "a.toml:2:1: the key `to` is missing"),
        ("[[light]]\nkind = \"sun\"\ndirection = [0, 0, 0]\n", "a.toml:2:1: this direction leads nowhere"),
        ("background = \"daylight:100\"\n", "a.toml:2:14: invalid value: string"),
        (
            "background = { zenith = 1, file = \"x\" }\n",
            "a.toml:2:14: a background has either zenith, horizon and nadir, or file",
        ),
        (
            "background = { file = \"none.hdr\" }\n",
            "a.toml:2:23: there is no file \"none.hdr\"; name it as seen from the folder",
        ),
        ("background = { file = \"pyramid.obj\" }\n", "pyramid.obj: this is no PNG, JPEG, TGA, HDR or EXR picture"),
        ("background = { file = \"flat.png\" }\n", "flat.png: 8x8 pixels are no picture of everything around"),
        ("background = \"daylight\"\nambient = 1\n", "a.toml:3:11: this background lights the scene from everywhere"),
        (
            "ground = 3\n",
            "a.toml:2:10: invalid type: integer `3`, expected true, false, or a table with height and color",
        ),
        ("[[light]]\nkind = \"directional\"\ndirection = [0, 0, 0]\n", "a.toml:2:1: this direction leads nowhere"),
        ("light = 3\n", "a.toml:2:9: light is no list"),
        // Objects.
        (
            "[[object]]\nmaterial = \"x\"\n",
            "a.toml:2:1: an object has one of the keys mesh, particles, volume, spheres",
        ),
        ("[[object]]\nmesh = \"a\"\nvolume = \"b\"\n", "a.toml:2:1: an object has one of the keys"),
        ("object = [3]\n", "a.toml:2:11: an object is a table"),
        (
            "[[object]]\nmesh = \"none.obj\"\n",
            "a.toml:3:8: there is no file \"none.obj\"; name it as seen from the folder",
        ),
        ("[[object]]\nmesh = \"\"\n", "a.toml:3:8: there is no file \"\""),
        ("[[object]]\nmesh = \"-\"\n", "a.toml:3:8: there is no file \"-\""),
        ("[[object]]\nmesh = \"/dev/zero\"\n", "a.toml:3:8: there is no file \"/dev/zero\""),
        ("[[object]]\nmesh = \"none*.obj\"\n", "a.toml:3:8: there is no file \"none*.obj\""),
        ("[[object]]\nmesh = \"a\\u0000\"\n", "a.toml:3:8: there is no file"),
        (
            "[[object]]\nmesh = \"gen:terr21k\"\n",
            "a.toml:3:8: no generated scene is called \"gen:terr21k\"; do you mean gen:terr2",
        ),
        ("[[object]]\nmesh = 3\n", "a.toml:3:8: invalid type: integer `3`, expected the name of a file between quotes"),
        ("[[object]]\nmesh = \"ball.nrrd\"\n", "a.toml:3:8: this is a volume; write volume = instead"),
        ("[[object]]\nvolume = \"pyramid.obj\"\n", "a.toml:3:10: this is no volume; write mesh = instead"),
        // No cycles.
        ("[[object]]\nmesh = \"a.toml\"\n", "a.toml: this is a Mobula scene; a scene file names no other ones"),
        ("[[object]]\nmesh = \"other.toml\"\n", "other.toml: this is a Mobula scene; a scene file names no other ones"),
        (&often, "a.toml:35:8: more than 16 objects name these files; put what belongs together in one"),
        (&several, "a.toml:3:1: more than 4096 materials"),
        (&many, "a.toml:8194:1: more than 4096 objects"),
        ("[[object]]\nvolume = \"ball.nrrd\"\niso = [1, nan]\n", "a.toml:4:11: invalid value: "),
        (
            "[[object]]\nvolume = \"ball.nrrd\"\niso = [{ value = 1, transparent = 2 }]\n",
            "a.toml:4:35: invalid value: integer `2`",
        ),
        (
            "[[object]]\nvolume = \"ball.nrrd\"\niso = [{ valu = 1 }]\n",
            "a.toml:4:10: there is no key `valu` here; do you mean value?",
        ),
        (
            "[[object]]\nvolume = \"ball.nrrd\"\ntransfer = \"bones\"\n",
            "a.toml:4:12: no transfer function is called \"bones\"; do you mean bone?",
        ),
        ("[[object]]\nvolume = \"ball.nrrd\"\ncut = [[0, 0, 0, 1]]\n", "a.toml:4:8: the first three numbers are 0"),
        ("[[object]]\nvolume = \"ball.nrrd\"\nwindow = [1, 0]\n", "a.toml:4:14: invalid value: "),
        ("[[object]]\nvolume = \"ball.nrrd\"\nshading = \"maybe\"\n", "a.toml:4:11: write auto, on or off"),
        (
            "[[object]]\nvolume = \"ball.nrrd\"\nraw = { dims = [1, 1, 0], type = \"u8\" }\n",
            "a.toml:4:23: invalid value: ",
        ),
        ("[[object]]\nvolume = \"ball.nrrd\"\nraw = { dims = [1, 1, 1], type = \"u9\" }\n", "a.toml:4:34: "),
        (
            "[[object]]\nspheres = [[0, 0, 0, -1]]\n",
            "a.toml:3:22: invalid value: integer `-1`, expected a number above 0",
        ),
        // What has a name.
        ("[transfer]\na = []\n", "a.toml:3:5: a transfer function needs at least one point"),
        (
            "[transfer]\na = [[0, 0, 0, 2, 0]]\n",
            "a.toml:3:5: the colour of point 1 is not from 0 to 1; a point is [value",
        ),
        ("[transfer]\na = [[1, 0, 0, 0, 0], [0, 0, 0, 0, 0]]\n", "a.toml:3:5: the values must ascend"),
        ("[transfer]\na = [[0, 0, 0, 0, -1]]\n", "a.toml:3:5: the extinction of point 1 is negative"),
        ("[transfer]\na = [[0, 0]]\n", "a.toml:3:6: invalid length 2"),
        ("[transfer.a]\npoints = [[0, 0, 0, 0, 0]]\nvalues = \"absolut\"\n", "a.toml:4:10: write absolute or relative"),
        ("[maps]\na = [[2, 0, 0, 0]]\n", "a.toml:3:5: the place of point 1 is not from 0 to 1"),
        // Particles.
        ("[[object]]\nparticles = \"pyramid.obj\"\n", "a.toml:3:13: these are no particles; "),
        ("[[object]]\nmesh = \"flow_0.csv\"\n", "a.toml:3:8: these are particles; write particles = instead"),
        ("[[object]]\nvolume = \"flow_0.csv\"\n", "a.toml:3:10: these are particles; write particles = instead"),
        (
            "[[object]]\nparticles = \"x\"\nradius = 0.1\ncrop = { speed = [0.1, 9] }\ntile = [2, 2, 1]\nbox = [[0, 0, 0], [1, 1, 1]]\n",
            "a.toml:3:13: there is no file \"x\"",
        ),
        ("[[object]]\nparticles = \"x\"\ncrop = { speed = [9, 0.1] }\n", "a.toml:4:18: 0.1 is not above 9"),
        (
            "[[object]]\nparticles = \"x\"\ncrop = { speed = [[1, 1], [9, 0.1]] }\n",
            "a.toml:4:18: 0.1 is not above 9; write the lesser",
        ),
        ("[[object]]\nparticles = \"x\"\ncrop = { speed = [1] }\n", "a.toml:4:18: invalid length 1, expected a range"),
        (
            "[[object]]\nparticles = \"x\"\ncrop = { speed = [1, [2, 3]] }\n",
            "a.toml:4:18: invalid length 2, expected a",
        ),
        ("[[object]]\nparticles = \"x\"\ncrop = { speed = [nan, 1] }\n", "a.toml:4:19: invalid value: "),
        ("[[object]]\nparticles = \"x\"\nopacity = 1.5\n", "a.toml:4:11: invalid value: "),
        (
            "[[object]]\nparticles = \"x\"\nopacity = { by = \"a\", points = [[0, 2]] }\n",
            "a.toml:4:32: the opacity of point 1",
        ),
        (
            "[[object]]\nparticles = \"x\"\nopacity = { by = \"a\", points = [] }\n",
            "a.toml:4:32: there is no point; write [",
        ),
        ("[[object]]\nparticles = \"x\"\nopacity = { points = [[0, 1]] }\n", "a.toml:4:11: the key `by` is missing"),
        (
            "[[object]]\nparticles = \"x\"\nraw = { layout = [\"x\", \"y\"] }\n",
            "a.toml:4:18: there is no z; write names",
        ),
        ("[[object]]\nparticles = \"x\"\nraw = { layout = [\"\"] }\n", "a.toml:4:18: a name is empty"),
        ("[[object]]\nparticles = \"x\"\ntile = [0, 1, 1]\n", "a.toml:4:9: invalid value: "),
        ("[[object]]\nparticles = \"x\"\nbox = [[0, 0, 0], [1, 0, 1]]\n", "a.toml:4:7: this box is empty"),
        (
            "[[object]]\nparticles = \"x\"\ncolor = { by = \"speed\", map = \"virids\" }\n",
            "a.toml:4:31: no colour map is called \"virids\"; do you mean viridis?",
        ),
        (
            "[materials]\na = { kind = \"phong\", color = { by = \"speed\" } }\n[[object]]\nmesh = \"pyramid.obj\"\nmaterial = \"a\"\n",
            "a.toml:6:12: this material is coloured by speed, which only particles have",
        ),
        // TOML itself.
        ("a = \n", "a.toml:2:"),
        ("size = [1, 2]\nsize = [1, 2]\n", "a.toml:3:1: this is not TOML: duplicate key"),
        (&deep, "a.toml:2:"),
        (&dotted, "a.toml: this is not TOML: recursion limit; "),
    ] {
        folder.write("a.toml", format!("mobula = 1\n{text}"));
        let done = folder.run(&["info", "a.toml"]);
        let short: String = text.chars().take(200).collect();
        let error = done.err.lines().last().unwrap_or_default();
        let told = error.strip_prefix("mobula: error: ").is_some_and(|error| error.starts_with(expected));
        if !(told && error.len() < 600 && done.code == Some(1) && done.out.is_empty()) {
            wrong.push(format!("{short}\n{error}\nis not\n{expected}\n"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // Warnings may come before; what is wrong with the first line, and with the whole.
    for (text, expected) in [
        ("", "a.toml:1: this is no scene file of Mobula; a scene file starts with the line: mobula = 1"),
        ("size = [1, 2]\nmobula = 1\n", "a.toml:2:1: this is not the first line"),
        ("mobula = 2\n", "a.toml:1:10: this version of scene files is not known"),
        ("mobula = \"1\"\n", "a.toml:1:10: this version of scene files is not known"),
        (glass, "a.toml:1: this is no scene file of Mobula"),
    ] {
        folder.write("a.toml", text);
        let done = folder.run(&["info", "a.toml"]);
        assert_eq!(done.code, Some(1), "{text}: {done:?}");
        assert!(done.err.starts_with(&format!("mobula: error: {expected}")), "{}", done.err);
    }
    folder.write("a.toml", b"mobula = 1\n\xff\n");
    assert!(folder.run(&["info", "a.toml"]).err.contains("a.toml:2: this is not UTF-8 text"));
    folder.write("a.toml", [b"mobula = 1\n".as_slice(), &vec![b'#'; 1 << 20]].concat());
    assert!(folder.run(&["info", "a.toml"]).err.contains("a.toml: is larger than 1 MiB"));
    // By its content, and packed.
    folder.write("scene", "# what\n mobula = 1\n[[object]]\nmesh = \"pyramid.obj\"\n");
    assert_eq!(json(&folder, &["info", "scene"])["triangles"], 6);
    folder.write("empty.toml", "mobula = 1\n");
    assert_eq!(json(&folder, &["info", "empty.toml"])["triangles"], 0);
}

/// Particles, a mesh and a volume move together.
#[test]
fn the_scene_of_the_readme_has_six_steps() {
    let folder = Folder::new("scene-vortex");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/vortex.toml");
    let shown = |step: &str| {
        let done = folder.run(&["render", scene, "--size", "80x60", "--samples", "1", "--step", step, "-o", "out.png"]);
        assert_eq!(done.code, Some(0), "{done:?}");
        support::picture(&folder.0.join("out.png")).2
    };
    let pictures = ["0", "1", "2", "3", "4", "5"].map(shown);
    for (i, one) in pictures.iter().enumerate() {
        assert!(!pictures[..i].contains(one), "step {i}");
    }
    let done = folder.run(&["render", scene, "--step", "6"]);
    assert!(done.code == Some(2) && done.err.contains("there is no step 6"), "{done:?}");
}
