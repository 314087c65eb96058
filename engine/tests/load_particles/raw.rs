//! Files of nothing but the numbers of particles.

use mobula::load::{Options, RawParticles, VoxelType, load_with};

use super::{Folder, gzip, kinds, only_particles, steps, values};

fn options(layout: &str, kind: VoxelType, big_endian: bool) -> Options {
    let columns = layout.split(',').map(|name| (name != "_").then(|| name.to_owned())).collect();
    Options { raw_particles: Some(RawParticles { columns, kind, big_endian }), ..Options::default() }
}

#[test]
fn numbers_of_either_order() {
    let folder = Folder::new("raw");
    let numbers = [1.0_f32, 2.0, 3.0, 0.5, 99.0, 7.0, 4.0, 5.0, 6.0, 0.25, 99.0, 8.0];
    let little: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    let big: Vec<u8> = numbers.iter().flat_map(|x| x.to_be_bytes()).collect();
    let wide: Vec<u8> = numbers.iter().flat_map(|&x| f64::from(x).to_le_bytes()).collect();
    for (kind, big_endian, bytes) in
        [(VoxelType::F32, false, little.clone()), (VoxelType::F32, true, big), (VoxelType::F64, false, wide)]
    {
        let options = options("x,y,z,radius,_,speed", kind, big_endian);
        for (name, file) in [("a.raw", bytes.clone()), ("a.bin.gz", gzip(&bytes)), ("a", bytes)] {
            let loaded = load_with(&folder.write(name, file), &options).unwrap();
            let [step] = &steps(only_particles(&loaded));
            assert_eq!(step.centers, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
            assert_eq!((&*step.radii, values(step, "speed")), (&[0.5, 0.25][..], vec![7.0, 8.0]));
            assert_eq!(kinds(step), [("radius", "f32"), ("speed", "f32")]);
        }
    }
    let said = |layout: &str, bytes: &[u8], name: &str| {
        let options = options(layout, VoxelType::F32, false);
        load_with(&folder.write(name, bytes), &options).map(|loaded| loaded.report).unwrap_err().to_string()
    };
    for (layout, bytes, name, expected) in [
        (
            "x,y,z",
            &little[..47],
            "a.raw",
            "47 bytes are no whole number of particles; each particle takes 12 bytes: 3 numbers of type f32; check --raw-layout",
        ),
        ("x,y,z", &gzip(&little[..47]), "a.raw.gz", "the last particle is cut"),
        ("x,y,_", &little, "a.raw", "there are no columns x, y and z, only 'x y'"),
        ("x,y,z,x", &little, "a.raw", "there are two columns 'x'"),
        ("x,y,z", &[], "a.raw", "there is no particle in it"),
    ] {
        let said = said(layout, bytes, name);
        assert!(said.contains(&format!("/{name}: {expected}")), "{said}");
    }
    // What has the name of a format is of it.
    assert!(said("x,y,z", &little, "a.ply").contains("a.ply:1: "));
}
