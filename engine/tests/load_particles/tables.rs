//! Tables of text: CSV, XYZ, dumps of LAMMPS.

use super::{Folder, gzip, kinds, only_particles, steps, values};

#[test]
fn csv_with_any_separator() {
    let folder = Folder::new("csv");
    for text in [
        "id,X (mm),Y (mm),Z (mm),speed,kind\n1,0,0.5,1,2.5,1\n2,3,4,5,,200\n",
        "id;x;y;z;speed;kind;\r\n1;0;0,5;1;2,5;1;\r\n2;3;4;5;NA;200;\r\n",
        "# made by hand\n\nid\tx\ty\tz\tspeed\tkind\n1\t0\t.5\t1\t2.5\t1\n2\t3\t4\t5\tnan\t200",
        "# id x y z speed kind\n1 0 0.5 1 2.5 1\n  2   3 4 5 nan 200\n",
        "\u{feff}\"id\",\"Points:0\",\"Points:1\",\"Points:2\",\"speed\",\"kind\"\n1,0,0.5,1,2.5,1\n\n2,3,4,5,nan,200\n",
        "# id,x,y,z,speed,kind\n1,0,0.5,1,2.5,1\n2,3,4,5,nan,200\n",
    ] {
        for (name, file) in
            [("a.csv", text.into()), ("a.tsv.gz", gzip(text.as_bytes())), ("unnamed", text.as_bytes().to_vec())]
        {
            let step = folder.step(name, file);
            assert_eq!(step.centers, [[0.0, 0.5, 1.0], [3.0, 4.0, 5.0]], "{text}");
            assert_eq!(kinds(&step), [("id", "f32"), ("speed", "f32"), ("kind", "u8")]);
            assert_eq!(values(&step, "kind"), [1.0, 200.0]);
            assert_eq!(values(&step, "speed")[0], 2.5);
            assert!(values(&step, "speed")[1].is_nan());
        }
    }
}

#[test]
fn csv_with_less() {
    let folder = Folder::new("csv-less");
    let text = "x,y,z,name\n1,2,3,water\n4,5,6,oil\n";
    assert_eq!(folder.warning("a.csv", text), "a.csv: column 'name' is text, which is left out");
    assert!(folder.warning("a.csv", "1,2,3,4\n5,6,7,8\n").ends_with("the first three are taken for x, y and z"));
    let loaded = folder.load("a.xyz", "1 2 3 4\n5 6 7 8\n").unwrap();
    assert_eq!(kinds(&steps::<1>(only_particles(&loaded))[0]), [("column 4", "f32")]);
    let element = folder.step("a.csv", "x,y,z,element\n1,2,3,O\n4,5,6,Na\n");
    assert_eq!((kinds(&element), values(&element, "element")), (vec![("element", "u8")], vec![8.0, 11.0]));
    for (text, expected) in [
        ("", ":1: the file is empty"),
        ("x,y,z\n", ": there is no particle in it; leave it out"),
        ("x,y,radius\n1,2,3\n", ":1: there are no columns x, y and z, only 'x y radius'; name"),
        ("x,y,z,x\n", ":1: there are two columns 'x'"),
        ("x,y,z\n1,2,3\n4,5\n", ":3: a particle has 2 values, not 3"),
        ("x,y,z\n1,2,three\n", ":2: 'three' is not a number"),
        ("x,y,z\n1,2,3\n\n1;2;3\n", ":4: '1;2;3' is not a number"),
        ("x,y,z\n1,2\0,3\n", ":2: binary data"),
    ] {
        let complaint = folder.complaint("a.csv", text);
        assert!(complaint.starts_with(&format!("a.csv{expected}")), "{text}: {complaint}");
    }
    let many: Vec<String> = (0..400).map(|i| format!("c{i}")).collect();
    assert!(folder.complaint("a.csv", many.join(",") + "\n").contains(":1: each particle has 400 numbers"));
}

#[test]
fn xyz_with_several_frames() {
    let folder = Folder::new("xyz");
    let text = "3\nwater\nO 0 0 0.1\nH 1 0 0\nHW2 0 1 0\n\n3\nt = 1\n8 0 0 0.2\n1 1 0 0\nX 0 1 0\n";
    for (name, file) in
        [("a.xyz", text.as_bytes().to_vec()), ("a.xyz.gz", gzip(text.as_bytes())), ("unnamed", text.into())]
    {
        let particles = folder.particles(name, file);
        let [first, second] = &steps(&particles);
        assert_eq!((first.centers[0], second.centers[0]), ([0.0, 0.0, 0.1], [0.0, 0.0, 0.2]));
        assert_eq!((values(first, "element"), values(second, "element")), (vec![8.0, 1.0, 1.0], vec![8.0, 1.0, 0.0]));
        assert_eq!((&*first.radii, &*second.radii), (&[1.52, 1.1, 1.1][..], &[1.52, 1.1, 2.0][..]));
        assert_eq!(kinds(first), [("radius", "f32"), ("element", "u8")]);
    }
    let extended = "2\nLattice=\"4 0 0 0 5 0 0 0 6\" Properties=id:I:1:species:S:1:pos:R:3:velo:R:3 Time=0\n\
                    1 C 1 2 3 0 3 4\n2 Fe 4 5 6 0 0 1\n0\n\n";
    let particles = folder.particles("a.extxyz", extended);
    let [step, empty] = &steps(&particles);
    assert_eq!(
        kinds(step).iter().map(|kind| kind.0).collect::<Vec<_>>(),
        ["radius", "id", "element", "vx", "vy", "vz", "speed"]
    );
    assert_eq!((values(step, "speed"), step.cell.unwrap()[2]), (vec![5.0, 1.0], [0.0, 0.0, 6.0]));
    assert!(empty.centers.is_empty() && particles.count() == 2);
    for (text, expected) in [
        ("", ": there is no particle in it"),
        ("hello\n", ":1: 'hello' where the number of atoms should be"),
        ("3\nwater\nO 0 0 0\n", ":3: the file ends after 1 of 3 particles"),
        ("99999999999\nwater\nO 0 0 0\n", ":3: the file ends after 1 of 99999999999 particles"),
        ("1", ":1: the file ends after 0 of 1 particle"),
        ("1\nwater\nO 0 0\n", ":3: 'O 0 0' is no element with three coordinates"),
        ("1\nwater\nO 0 0 0\nO 1 1 1\n", ":4: 'O 1 1 1' where the number"),
        ("1\nwater\nO 0 zero 0\n", ":3: 'zero' is not a number"),
        ("2\nwater\nO 0 0 0 1\nO 0 0 0\n", ":4: a particle has 4 values, not 5"),
        ("1\nProperties=species:S:1\nO\n", ":3: there are no columns x, y and z"),
        ("1\nProperties=species:S:1:pos:R:9\nO 0 0 0\n", ":3: there are no columns x, y and z"),
        ("1\n\nO 0 0 0\n1\n\nO 0 0 0 5\n", ":6: the particles of this step have other columns"),
    ] {
        let complaint = folder.complaint("a.xyz", text);
        assert!(complaint.starts_with(&format!("a.xyz{expected}")), "{text}: {complaint}");
    }
}

fn dump(time: u32, bounds: &str, columns: &str, atoms: &str) -> String {
    let count = atoms.lines().count();
    format!(
        "ITEM: TIMESTEP\n{time}\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS {bounds}\nITEM: ATOMS {columns}\n{atoms}"
    )
}

#[test]
fn dumps_of_lammps() {
    let folder = Folder::new("lammps");
    let straight = "pp pp pp\n-1 3\n0 2\n5 6";
    let atoms = "1 1 0.5 0.5 0\n2 300 0 0 1\n";
    let text = dump(0, straight, "id type x y z", atoms) + &dump(100, straight, "id type xs ys zs", atoms);
    for (name, file) in [
        ("a.lammpstrj", text.as_bytes().to_vec()),
        ("dump.gz", gzip(text.as_bytes())),
        ("unnamed", text.clone().into()),
    ] {
        let particles = folder.particles(name, file);
        let [first, second] = &steps(&particles);
        assert_eq!(first.centers, [[0.5, 0.5, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!(second.centers, [[1.0, 1.0, 5.0], [-1.0, 0.0, 6.0]]);
        assert_eq!(kinds(first), [("id", "f32"), ("type", "f32")]);
        assert_eq!(first.cell.unwrap(), [[4.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]]);
    }
    let leaning =
        dump(0, "xy xz yz pp pp pp\n0 6 2\n0 2 0\n0 4 0", "element xsu ysu zsu vx vy vz", "O 0.5 1 0 1 2 2\n");
    let step = folder.step("a.dump", &leaning);
    assert_eq!(
        (step.centers[0], values(&step, "speed"), values(&step, "element")),
        ([4.0, 2.0, 0.0], vec![3.0], vec![8.0])
    );
    let mol = dump(0, straight, "mol x y z", "a 1 2 3\n");
    assert_eq!(folder.warning("a.dump", mol), "a.dump: column 'mol' is text, which is left out");
    let units = format!("ITEM: UNITS\nlj\nITEM: TIME\n0.5\n{}", dump(0, straight, "type xu yu zu", "7 1 2 3\n"));
    assert_eq!(kinds(&folder.step("a.dump", units)), [("type", "u8")]);
    for (text, expected) in [
        ("".to_owned(), ":1: there are no atoms in the dump"),
        ("hello\n".to_owned(), ":1: 'hello' where a line with ITEM: should be"),
        ("ITEM: NUMBER OF ATOMS\nmany\n".to_owned(), ":2: 'many' is no number of atoms"),
        ("ITEM: NUMBER OF ATOMS\n".to_owned(), ":1: the dump ends too early"),
        ("ITEM: ATOMS x y z\n1 2 3\n".to_owned(), ":1: nothing says how many atoms there are"),
        (
            "ITEM: NUMBER OF ATOMS\n99999999999\nITEM: ATOMS x y z\n1 2 3\n".to_owned(),
            ":4: the file ends after 1 of 99999999999",
        ),
        (
            "ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS xs ys zs\n1 2 3\n".to_owned(),
            ":4: coordinates are in units of the box",
        ),
        ("ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS id\n1\n".to_owned(), ":4: there are no columns x, y and z, only 'id'"),
        ("ITEM: BOX BOUNDS pp\n0 1\n0 x\n".to_owned(), ":3: 'x' is not a number"),
        ("ITEM: BOX BOUNDS pp\n0 1\n0 1\n0 inf\n".to_owned(), ":4: the bounds of the box are no box"),
        (dump(0, straight, "id x y z", "1 2 3\n"), ":10: a particle has 3 values, not 4"),
        (dump(0, straight, "x y z", "1 2 3\n") + "4 5 6\n", ":11: '4 5 6' where a line with ITEM:"),
        (
            dump(0, straight, "x y z", "1 2 3\n") + &dump(1, straight, "id x y z", "1 2 3 4\n"),
            ":20: the particles of this step have other",
        ),
    ] {
        let complaint = folder.complaint("a.dump", &text);
        assert!(complaint.starts_with(&format!("a.dump{expected}")), "{text}: {complaint}");
    }
}
