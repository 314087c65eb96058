//! NRRD: types, byte orders, encodings, axes, data files.

use glam::DVec3;
use mobula::view::Up;

use super::{Folder, gzip, samples, values};

/// A header with the fields that all have, and more.
fn header(kind: &str, sizes: &str, more: &str) -> String {
    let dimension = sizes.split(' ').count();
    format!(
        "NRRD0004\n# made by a test\ntype: {kind}\ndimension: {dimension}\nsizes: {sizes}\n{}\n",
        more.trim_end_matches('\n')
    )
}

fn attached(header: &str, bytes: &[u8]) -> Vec<u8> {
    [header.as_bytes(), b"\n", bytes].concat()
}

/// Twelve bytes from 0, in two steps or so.
const BYTES: [u8; 12] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];

#[test]
fn every_type_order_and_encoding() {
    let folder = Folder::new("nrrd-types");
    let names = [
        ["uchar", "unsigned char", "uint8", "uint8_t"],
        ["signed char", "int8", "int8_t", "Int8"],
        ["ushort", "unsigned short", "unsigned short int", "uint16_t"],
        ["short", "short int", "signed  short", "int16"],
        ["uint", "unsigned int", "uint32", "uint32_t"],
        ["int", "signed int", "int32", "int32_t"],
        ["float"; 4],
        ["double"; 4],
    ];
    for (sample, names) in samples().iter().zip(names) {
        let text: Vec<String> = sample.values.iter().map(f64::to_string).collect();
        let text = text.join(" ").replacen(' ', ",\n", 3);
        for kind in names {
            for (encoding, bytes) in [
                ("raw\nendian: little", sample.little.clone()),
                ("RAW\nendian: big", sample.big.clone()),
                ("gzip\nendian: little", gzip(&sample.little)),
                ("gz\nendian: big", gzip(&sample.big)),
                ("ascii", format!("{text}\n").into_bytes()),
                ("text", text.clone().into_bytes()),
            ] {
                let header = header(kind, "2 3 4", &format!("encoding: {encoding}"));
                let file = attached(&header, &bytes);
                for (name, file) in [("a.nrrd", file.clone()), ("a.nrrd.gz", gzip(&file)), ("unnamed", file)] {
                    let grid = folder.grid(name, file);
                    assert_eq!(grid.dims(), [2, 3, 4]);
                    assert_eq!((grid.voxels().type_name(), values(&grid)), (sample.name, sample.values.clone()));
                }
            }
        }
    }
}

#[test]
fn places() {
    let folder = Folder::new("nrrd-places");
    let place = |more: &str| {
        let file = attached(&header("uint8", "2 3 2", &format!("encoding: raw\n{more}")), &BYTES);
        *folder.grid("a.nrrd", file).place()
    };
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    for (more, origin, axes) in [
        ("", DVec3::ZERO, [x, y, z]),
        ("spacings: 0.5 2 1e-2", DVec3::ZERO, [x * 0.5, y * 2.0, z * 0.01]),
        ("Spacings:1 -2 3\r", DVec3::ZERO, [x, y * -2.0, z * 3.0]),
        (
            "space: left-posterior-superior\nspace directions: (0,2,0) (-1,0,0)  ( 0, 0, 4 )\nspace origin: (1, -2,3.5)",
            DVec3::new(1.0, -2.0, 3.5),
            [y * 2.0, -x, z * 4.0],
        ),
        ("axis mins: 10 20 30\naxis maxs: 12 26 34", DVec3::new(10.5, 21.0, 31.0), [x, y * 2.0, z * 2.0]),
        (
            "axismins: 10 20 30\naxismaxs: 12 26 34\ncenters: node node node",
            DVec3::new(10.0, 20.0, 30.0),
            [x * 2.0, y * 3.0, z * 4.0],
        ),
    ] {
        let place = place(more);
        assert_eq!((place.origin, place.axes), (origin, axes), "{more}");
    }
    let loaded = |more: &str| {
        let file = attached(&header("uint8", "2 3 2", &format!("encoding: raw\n{more}")), &BYTES);
        folder.load("a.nrrd", file).unwrap()
    };
    assert_eq!(loaded("space: RAS").scene.up, Some(Up::Z));
    assert_eq!(loaded("space: right-up").scene.up, None);
    assert_eq!(loaded("spacings: 2 2 -3").report.bounds(), Some([[0.0, 0.0, -3.0], [2.0, 4.0, 0.0]]));
    let far = loaded("space dimension: 3\nspace origin: (1e6,2e6,3e6)");
    assert!(far.report.warnings[0].contains("far from the origin"), "{:?}", far.report.warnings);
    assert_eq!(far.report.bounds(), Some([[0.0; 3], [1.0, 2.0, 1.0]]));
}

#[test]
fn time_is_first_last_or_between() {
    let folder = Folder::new("nrrd-time");
    for (sizes, more, expected) in [
        ("2 1 3 2", "kinds: domain domain domain time", [[0, 1, 2, 3, 4, 5], [6, 7, 8, 9, 10, 11]]),
        ("2 1 3 2", "spacings: 1 1 1 nan", [[0, 1, 2, 3, 4, 5], [6, 7, 8, 9, 10, 11]]),
        ("2 2 1 3", "kinds: list space space space", [[0, 2, 4, 6, 8, 10], [1, 3, 5, 7, 9, 11]]),
        (
            "2 1 3 2",
            "space dimension: 4\nkinds: domain domain domain domain\nspace origin: (0,0,0,5)\n\
             space directions: (1,0,0,0) (0,1,0,0) (0,0,1,0) (0,0,0,2)",
            [[0, 1, 2, 3, 4, 5], [6, 7, 8, 9, 10, 11]],
        ),
        ("2 2 1 3", "space directions: none (1,0,0) (0,1,0) (0,0,1)", [[0, 2, 4, 6, 8, 10], [1, 3, 5, 7, 9, 11]]),
        (
            "2 2 1 3",
            "kinds: none domain domain domain\nspacings: nan 1 1 1",
            [[0, 2, 4, 6, 8, 10], [1, 3, 5, 7, 9, 11]],
        ),
        ("2 2 1 3", "kinds: domain time domain domain", [[0, 1, 4, 5, 8, 9], [2, 3, 6, 7, 10, 11]]),
        ("2 1 3 2 1", "kinds: domain domain domain time stub", [[0, 1, 2, 3, 4, 5], [6, 7, 8, 9, 10, 11]]),
    ] {
        for (encoding, bytes) in [("raw", BYTES.to_vec()), ("gzip", gzip(&BYTES)), ("txt", text().into_bytes())] {
            let header = header("uchar", sizes, &format!("{more}\nencoding: {encoding}"));
            let volume = folder.volume("a.nrrd", attached(&header, &bytes));
            assert_eq!(volume.steps.len(), 2, "{more}");
            for (step, expected) in volume.steps.iter().zip(expected) {
                assert_eq!(step.dims(), [2, 1, 3], "{more}");
                assert_eq!(values(step), expected.map(f64::from), "{more}");
            }
        }
    }
    let silent = attached(&header("uchar", "2 1 3 2", "encoding: raw"), &BYTES);
    assert_eq!(
        folder.warning("a.nrrd", silent),
        "a.nrrd: the header does not say which dimension is time; the last is taken"
    );
}

fn text() -> String {
    BYTES.map(|byte| byte.to_string()).join("\n")
}

#[test]
fn data_files() {
    let folder = Folder::new("nrrd-files");
    folder.write("all.raw", BYTES);
    folder.write("below/all.raw.gz", gzip(&BYTES));
    folder.write("skip.raw", [b"two\nlines\n123".as_slice(), &BYTES].concat());
    folder.write("skip.raw.gz", [b"a line\n".as_slice(), &gzip(&[b"123".as_slice(), &BYTES].concat())].concat());
    folder.write("all.txt", text());
    folder.write("s08.raw", [&[9; 3][..], &BYTES[..6]].concat());
    folder.write("s10.raw", [&[9; 3][..], &BYTES[6..]].concat());
    for more in [
        "encoding: raw\ndata file: all.raw",
        "encoding: raw\ndatafile: ./all.raw\n",
        "encoding: gzip\ndata file: below/all.raw.gz",
        "encoding: gzip\ndata file: below\\all.raw.gz",
        "encoding: raw\nline skip: 2\nbyte skip: 3\ndata file: skip.raw",
        "encoding: raw\nbyteskip: -1\ndata file: skip.raw",
        "encoding: gzip\nlineskip: 1\nbyte skip: 3\ndata file: skip.raw.gz",
        "encoding: ascii\ndata file: all.txt",
        "encoding: raw\nbyte skip: 3\ndata file: s%02d.raw 8 10 2",
        "encoding: raw\nbyte skip: -1\ndata file: s%02d.raw 8 10 2 3",
        "encoding: raw\nbyte skip: 3\ndata file: LIST\ns08.raw\ns10.raw",
        "encoding: raw\nbyte skip: 3\ndata file: LIST 3\r\ns08.raw\r\n\r\ns10.raw\r\n",
    ] {
        let grid = folder.grid("a.nhdr", header("uint8", "2 3 2", more));
        assert_eq!(values(&grid), BYTES.map(f64::from), "{more}");
    }
    // Voxels behind the header may be skipped to as well.
    for skip in ["3", "-1"] {
        let header = header("uint8", "2 3 2", &format!("encoding: raw\nline skip: 1\nbyte skip: {skip}"));
        let grid = folder.grid("a.nrrd", attached(&header, &[b"a line\n123".as_slice(), &BYTES].concat()));
        assert_eq!(values(&grid), BYTES.map(f64::from));
    }
    let outside = folder.0.with_extension("outside.raw");
    std::fs::write(&outside, BYTES).unwrap();
    let outside_name = outside.file_name().unwrap().to_string_lossy().into_owned();
    let absolute = outside.display().to_string();
    for (name, expected) in [
        (format!("../{outside_name}"), "which is not below its own folder; put the file beside it"),
        (format!("below/../../{outside_name}"), "which is not below its own folder"),
        (absolute, "which is not below its own folder"),
        ("C:\\all.raw".to_owned(), "which is not below its own folder"),
        (String::new(), "which is not below its own folder"),
        ("none.raw".to_owned(), "its voxels are in the file 'none.raw', which is not there"),
        ("below".to_owned(), "which is not there"),
        ("LIST\ns08.raw\n./s08.raw".to_owned(), "data file names './s08.raw' twice; name each file once"),
        ("LIST".to_owned(), "data file names 0 files, which cannot share 12 voxels"),
        ("s%s.raw 1 2 1".to_owned(), "data file is no pattern with numbers; write it like"),
        ("s%d.raw 1 5 1".to_owned(), "data file names 5 files, which cannot share 12 voxels"),
    ] {
        let more = format!("encoding: raw\ndata file: {name}");
        let complaint = folder.complaint("a.nhdr", header("uint8", "2 3 2", &more));
        assert!(complaint.starts_with("a.nhdr:") && complaint.contains(expected), "{name}: {complaint}");
    }
    std::fs::remove_file(outside).unwrap();
    let short = header("uint8", "2 3 2", "encoding: raw\nbyte skip: 1\ndata file: all.raw");
    let complaint = folder.complaint("a.nhdr", short);
    assert!(complaint.starts_with("all.raw: 1 byte of voxels missing: 2 x 3 x 2 voxels"), "{complaint}");
}

#[test]
fn what_people_should_know() {
    let folder = Folder::new("nrrd-warnings");
    let file = |kind: &str, more: &str, bytes: &[u8]| attached(&header(kind, "2 3 2", more), bytes);
    let more = [&BYTES[..], &[1, 2]].concat();
    for (file, expected) in [
        (file("uint8", "encoding: raw", &more), "a.nrrd: 2 bytes behind the voxels left out"),
        (file("uint8", "encoding: gzip", &gzip(&more)), "a.nrrd: what is behind the voxels left out"),
        (file("uint8", "encoding: raw\nhello: 1\nyou: 2", &BYTES), "a.nrrd:7: 'hello' and 1 other fields, which NRRD"),
        (file("uint16", "encoding: raw", &[0; 24]), "a.nrrd: the header has no 'endian'; little is assumed"),
    ] {
        let warning = folder.warning("a.nrrd", file);
        assert!(warning.starts_with(expected), "{warning}");
    }
    // Keys of somebody's, and fields that say nothing of voxels.
    let more = "encoding: raw\ncontent: a: b\nunits: \"mm\" \"mm\" \"mm\"\nkey:=type: int\nlabels: \"\" \"\" \"\"";
    assert_eq!(folder.grid("a.nrrd", file("uint8", more, &BYTES)).dims(), [2, 3, 2]);
}

#[test]
fn broken_headers() {
    let folder = Folder::new("nrrd-broken");
    let with = |sizes: &str, more: &str| attached(&header("uint8", sizes, &format!("encoding: raw\n{more}")), &BYTES);
    let typed = |kind: &str| attached(&header(kind, "2 3 2", "encoding: raw"), &BYTES);
    let encoded = |encoding: &str| attached(&header("uint8", "2 3 2", &format!("encoding: {encoding}")), &BYTES);
    let text = |text: &str| attached(&header("uint8", "2 1 1", "encoding: ascii"), text.as_bytes());
    for (file, expected) in [
        (Vec::new(), ":1: the file is empty; name a file with voxels in it"),
        (b"hello\n".to_vec(), ":1: not an NRRD file: it starts with 'hello', not NRRD0005"),
        (b"NRRD0009\n".to_vec(), ":1: version 9 of NRRD is not known"),
        (b"NRRD0004\n\n".to_vec(), ":2: the header has no 'dimension'"),
        (b"NRRD0004\ntype\n".to_vec(), ":2: 'type' is no field of NRRD, which has a colon"),
        (b"NRRD0004\ntype: a\0b\n".to_vec(), ":2: binary data in a text file"),
        ([&b"NRRD0004\n# "[..], &[b'x'; 70_000], b"\n"].concat(), ":2: a line of more than 64 KiB"),
        (b"NRRD0004\ntype: int8\ntype: int8\n\n".to_vec(), ":3: 'type' stands here and in line 2"),
        (typed("char"), ":3: type 'char' is not known; it is one of uint8"),
        (typed("block"), ":3: type block is not supported"),
        (typed("int64"), ":3: type int64 is not supported: integers have at most 32 bits"),
        (encoded("hex"), ":6: encoding hex is not supported; write it as raw, gzip or ascii"),
        (encoded("bzip2"), ":6: encoding bzip2 is not supported"),
        (encoded("zip"), ":6: encoding 'zip' is not known"),
        (encoded("raw\nendian: middle"), ":7: endian is 'middle'; it is little or big"),
        (encoded("raw\nbyte skip: -2"), ":7: byte skip is negative"),
        (encoded("gzip\nbyte skip: -1"), ":7: byte skip -1 is for raw voxels only"),
        (encoded("raw\nline skip: 9"), ": 9 lines before the voxels are to be skipped, but it has only 1"),
        (encoded("raw\nbyte skip: 99999999999"), ": 99999999999 bytes before the voxels are to be skipped"),
        (encoded("gzip"), ": the gzip data is damaged"),
        (with("4 3", ""), ":4: dimension is 2: a volume has three dimensions; pictures and lines cannot be loaded"),
        (with("12", ""), ":4: dimension is 1: a volume has three dimensions"),
        (
            with("2 3 2", "kinds: domain domain domain\nspace directions: none (0,1,0) (0,0,1)"),
            ":8: space directions has none for",
        ),
        (
            with("2 3 2", "space directions: (1,0,0,1) (0,1,0,0) (0,0,1,0)"),
            ":7: space directions has a direction of space and",
        ),
        (with("4 3 1", "kinds: domain domain time"), ":7: kinds give 2 dimensions of space"),
        (
            with("3 2 2 1", "kinds: RGB-color domain domain domain"),
            ":7: kinds 'RGB-color' of dimension 1 is not supported",
        ),
        (with("3 2 2 1", "kinds: vector domain domain domain"), ":7: kinds 'vector' of dimension 1 is not supported"),
        (with("3 2 2 1", "kinds: 3-gradient space space space"), "a voxel must be one number; write each component"),
        (with("3 2 2 1", "kinds: banana space space space"), ":7: kinds 'banana' of dimension 1 is not known"),
        (with("3 2 1 2", "kinds: time domain domain time"), ":7: kinds give 2 dimensions of space"),
        (with("3 2 1 2 1", "kinds: time domain domain domain list"), ":7: kinds give 2 dimensions beside space"),
        (with("1 1 1 3 4", ""), ":5: sizes give 5 dimensions of space: a volume has three; cut the others"),
        (with("2 3 2", "kinds: domain domain"), ":7: kinds has 2 values, not 3"),
        (with("2 3 2", "spacings: 1 1"), ":7: spacings has 2 values, not 3"),
        (with("2 3 2", "spacings: 1 0 1"), ":7: the spacing of the grid is zero"),
        (with("2 3 2", "spacings: 1 nan 1"), ":7: the spacing or a direction of the grid is not finite"),
        (with("2 3 2", "spacings: 1 inf 1"), ":7: the spacing or a direction of the grid is not finite"),
        (with("2 3 2", "spacings: 1 one 1"), ":7: spacings 'one' is not a number"),
        (with("2 3 2", "spacings: 1 1e-20 1"), ":7: the spacings of the grid are out of all proportion"),
        (
            with("2 3 2", "space directions: (1,2,3) (2,4,6) (0,0,1)"),
            ":7: the directions of the grid are all in a plane",
        ),
        (with("2 3 2", "space directions: (1,0) (0,1) (0,0)"), ":7: space directions has a vector of 2 numbers"),
        (with("2 3 2", "space directions: (1,0,0 (0,1,0)"), ":7: space directions "),
        (with("2 3 2", "space directions: 1 0 0"), ":7: space directions has '1 0 0' for a vector"),
        (with("2 3 2", "space origin: (1,nan,0)"), "the origin of the grid is not finite"),
        (with("2 3 2", "space origin: none"), ":7: space origin is not one point"),
        (with("2 0 2", ""), ":5: a grid of 2 x 0 x 2 has no samples"),
        (with("2 -3 2", ""), ":5: sizes '-3' is not a whole number"),
        (with("2 99999999999999999999 2", ""), ":5: sizes '99999999999999999999' is not a whole number, or too large"),
        (with("18446744073709551615 4294967296 2", ""), ":5: a grid of 18446744073709551615 x"),
        (with("65536 65536 65536 65536", ""), ":5: 65536 x 65536 x 65536 samples in 65536 steps are more than fit"),
        (with("2 2 2 99999999", ""), ":5: 99999999 steps of time are more than 65536"),
        (b"NRRD0004\ntype: int8\ndimension: 99\nsizes: 1\n\n".to_vec(), ":5: it has 99 dimensions, not 3 to 16"),
        (text("1 two"), ": voxel 'two' is not a number"),
        (text("1 256"), ": voxel '256' is no value of type u8; change the type"),
        (text("1 0.5"), ": voxel '0.5' is no value of type u8"),
        (text("1 "), ": voxels are missing: 2 x 1 x 1 voxels of type u8 take 2 bytes"),
        (text(&format!("1 {}", "1".repeat(100_000))), "' is not a number"),
    ] {
        let start = String::from_utf8_lossy(&file[..file.len().min(200)]).into_owned();
        let complaint = folder.complaint("a.nrrd", &file);
        assert!(complaint.starts_with("a.nrrd:") && complaint.contains(expected), "{start}\n{expected}\n{complaint}");
        // Packed, it is the same.
        let packed = folder.complaint("a.nrrd.gz", gzip(&file));
        let same =
            |text: &str| text.split_once(": ").map(|(_, text)| text.split(" missing").next().unwrap().to_owned());
        assert!(same(&complaint) == same(&packed) || complaint.contains("byte"), "{complaint}\n{packed}");
    }
}
