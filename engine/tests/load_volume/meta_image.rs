//! MetaImage: types, byte orders, packing, places, data files.

use glam::DVec3;

use super::{Folder, gzip, samples, values, zlib};

fn header(kind: &str, sizes: &str, more: &str) -> String {
    let count = sizes.split(' ').count();
    format!(
        "ObjectType = Image\nNDims = {count}\nDimSize = {sizes}\n{more}ElementType = MET_{kind}\nElementDataFile = "
    )
}

const BYTES: [u8; 12] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];

fn local(kind: &str, sizes: &str, more: &str, bytes: &[u8]) -> Vec<u8> {
    [header(kind, sizes, more).as_bytes(), b"LOCAL\n", bytes].concat()
}

#[test]
fn every_type_order_and_packing() {
    let folder = Folder::new("meta-types");
    let names = ["UCHAR", "CHAR", "USHORT", "SHORT", "UINT", "INT", "FLOAT", "DOUBLE"];
    for (sample, kind) in samples().iter().zip(names) {
        let text: Vec<String> = sample.values.iter().map(f64::to_string).collect();
        for (more, bytes) in [
            ("BinaryData = True\nBinaryDataByteOrderMSB = False\n", sample.little.clone()),
            ("ElementByteOrderMSB = True\n", sample.big.clone()),
            ("CompressedData = True\nCompressedDataSize = 5\n", zlib(&sample.little)),
            ("CompressedData = True\nBinaryDataByteOrderMSB = True\n", gzip(&sample.big)),
            ("BinaryData = False\n", text.join(" ").into_bytes()),
        ] {
            let file = local(kind, "2 3 4", more, &bytes);
            for (name, file) in [("a.mha", file.clone()), ("a.mha.gz", gzip(&file)), ("unnamed", file)] {
                let grid = folder.grid(name, file);
                assert_eq!(grid.dims(), [2, 3, 4]);
                assert_eq!((grid.voxels().type_name(), values(&grid)), (sample.name, sample.values.clone()));
            }
            folder.write("a.zraw", &bytes);
            let grid = folder.grid("a.mhd", header(kind, "2 3 4", more) + "a.zraw\n");
            assert_eq!(values(&grid), sample.values);
        }
    }
}

#[test]
fn places_steps_and_slopes() {
    let folder = Folder::new("meta-places");
    let grid = |more: &str| folder.grid("a.mha", local("UCHAR", "2 3 2", more, &BYTES));
    let place = |more: &str| (grid(more).place().origin, grid(more).place().axes);
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    assert_eq!(place(""), (DVec3::ZERO, [x, y, z]));
    assert_eq!(place("ElementSpacing = 0.5 2 4\n").1, [x * 0.5, y * 2.0, z * 4.0]);
    assert_eq!(place("ElementSize = 3 2 4\nModality = MET_MOD_CT\n").1, [x * 3.0, y * 2.0, z * 4.0]);
    for name in ["Offset", "Origin", "Position"] {
        assert_eq!(place(&format!("{name} = 1 -2 3\n")).0, DVec3::new(1.0, -2.0, 3.0));
    }
    let matrix = "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nElementSpacing = 0.5 2 4\n";
    assert_eq!(place(matrix).1, [y * 0.5, x * -2.0, z * 4.0]);
    let scaled = "ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = -1\n";
    assert_eq!(grid(scaled).scale(), [2.0, -1.0]);

    let more = "Offset = 1 2 3 9\nElementSpacing = 1 1 2 5\nTransformMatrix = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n";
    let volume = folder.volume("a.mha", local("UCHAR", "2 1 3 2", more, &BYTES));
    assert_eq!(volume.steps.len(), 2);
    assert_eq!(values(&volume.steps[1]), [6.0, 7.0, 8.0, 9.0, 10.0, 11.0]);
    assert_eq!(volume.steps[0].place().axes, [x, y, z * 2.0]);
}

#[test]
fn data_files() {
    let folder = Folder::new("meta-files");
    folder.write("all.raw", BYTES);
    folder.write("below/skip.raw", [&[9; 5][..], &BYTES].concat());
    folder.write("s01.raw", &BYTES[..6]);
    folder.write("s02.raw", &BYTES[6..]);
    for (more, name) in [
        ("", "all.raw"),
        ("HeaderSize = 5\n", "below/skip.raw"),
        ("HeaderSize = -1\n", "below/skip.raw"),
        ("", "s%02d.raw 1 2 1"),
        ("", "LIST\ns01.raw\ns02.raw"),
    ] {
        let grid = folder.grid("a.mhd", header("UCHAR", "2 3 2", more) + name + "\n");
        assert_eq!(values(&grid), BYTES.map(f64::from), "{name}");
    }
    for (name, expected) in [
        ("/etc/hostname", "which is not below its own folder"),
        ("../all.raw", "which is not below its own folder"),
        ("none.raw", "its voxels are in the file 'none.raw', which is not there; put the file beside it"),
        ("", "is not below its own folder"),
        ("s%d.raw 2 1 1", "ElementDataFile is no pattern with numbers"),
        ("LIST\n", "ElementDataFile names 0 files"),
    ] {
        let complaint = folder.complaint("a.mhd", header("UCHAR", "2 3 2", "") + name + "\n");
        assert!(complaint.starts_with("a.mhd:") && complaint.contains(expected), "{name}: {complaint}");
    }
}

#[test]
fn broken_headers() {
    let folder = Folder::new("meta-broken");
    let with = |sizes: &str, more: &str| local("UCHAR", sizes, more, &BYTES);
    for (file, expected) in [
        (Vec::new(), ":1: the file is empty"),
        (b"hello\n".to_vec(), ":1: 'hello' is no field of MetaImage"),
        (b"NDims = 3\n".to_vec(), ":1: the header has no 'DimSize'"),
        (b"NDims = 3\nDimSize = \0".to_vec(), ":2: binary data in a text file"),
        (b"ObjectType = Tube\n".to_vec(), ":1: ObjectType is 'Tube'"),
        (b"NDims = 3\nNDims = 4\n".to_vec(), ":2: 'NDims' stands here and in line 1"),
        (with("4 3", ""), ":2: NDims is 2: a volume has three dimensions"),
        (with("2 3 2 1 1", ""), ":2: NDims is 5; cut all but space and time"),
        (with("2 0 2", ""), ":3: a grid of 2 x 0 x 2 has no samples"),
        (with("2 3 -2", ""), ":3: DimSize '-2' is not a whole number"),
        (with("2 3 3", ""), ": 6 bytes of voxels missing: 2 x 3 x 3 voxels of type u8 take 18 bytes"),
        (
            with("2 3 2", "ElementNumberOfChannels = 3\n"),
            ":4: ElementNumberOfChannels is '3': a voxel must be one number",
        ),
        (with("2 3 2", "ElementSpacing = 1 0 1\n"), ":4: the spacing of the grid is zero"),
        (with("2 3 2", "ElementSpacing = 1 1\n"), ":4: ElementSpacing has 2 values, not 3"),
        (with("2 3 2", "ElementSpacing = 1 nan 1\n"), ":4: the spacing or a direction of the grid is not finite"),
        (with("2 3 2", "TransformMatrix = 1 0 0 1 0 0 0 0 1\n"), ":4: the directions of the grid are all in a plane"),
        (with("2 3 2", "TransformMatrix = 1 0 0\n"), ":4: TransformMatrix has 3 values, not 9"),
        (with("2 3 2", "Offset = inf 0 0\n"), ":4: the origin of the grid is not finite"),
        (with("2 3 2", "BinaryData = maybe\n"), ":4: BinaryData is 'maybe'; it is True or False"),
        (with("2 3 2", "CompressedData = True\n"), ": the gzip data is damaged"),
        (with("2 3 2", "HeaderSize = -3\n"), ":4: HeaderSize is negative"),
        (with("2 3 2", "ElementToIntensityFunctionSlope = nan\n"), ":4: ElementToIntensityFunctionSlope is not finite"),
        (local("LONG_LONG", "2 3 2", "", &BYTES), ":4: ElementType MET_LONG_LONG is not supported"),
        (local("UCHAR_ARRAY", "2 3 2", "", &BYTES), ":4: ElementType 'MET_UCHAR_ARRAY' is not supported"),
        (local("BANANA", "2 3 2", "", &BYTES), ":4: ElementType 'MET_BANANA' is not known"),
    ] {
        let complaint = folder.complaint("a.mha", &file);
        assert!(complaint.starts_with(&format!("a.mha{expected}")), "{expected}\n{complaint}");
    }
    let long = local("UCHAR", "2 3 2", "", &[1; 14]);
    assert_eq!(folder.warning("a.mha", long), "a.mha: 2 bytes behind the voxels left out");
}
