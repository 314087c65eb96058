//! Files of meshes whose names differ in a number: steps of time, or parts.

use mobula::geometry::{Mesh, MeshSequence};
use mobula::load::series::{Gathering, Joined};
use mobula::load::{Options, load_with};

use super::Folder;

/// A square that begins at `x`, of two triangles, or of one.
fn square(x: f32, triangles: bool) -> String {
    let corners = [(x, 0), (x + 1.0, 0), (x + 1.0, 1), (x, 1)].map(|(x, y)| format!("v {x} {y} 0\n"));
    format!("{}f 1 2 3\n{}", corners.concat(), if triangles { "f 1 3 4\n" } else { "" })
}

fn gather(folder: &Folder, files: &[(&str, String)]) -> Vec<Joined> {
    let options = Options::default();
    let mut all = Gathering::new(&options, load_with);
    for (name, text) in files {
        let loaded = folder.load(name, text).unwrap();
        all.add(folder.0.join(name), loaded);
    }
    all.join()
}

#[test]
fn meshes_of_the_same_triangles_are_steps_of_time() {
    let folder = Folder::new("mesh-steps");
    // In the order of their numbers, whatever that of the command line is.
    let files = [("a_10.obj", square(0.8, true)), ("a_2.obj", square(0.4, true)), ("a_1.obj", square(0.0, true))];
    let all = gather(&folder, &files);
    assert_eq!(all.len(), 1);
    let [geometry] = &all[0].loaded.scene.geometry[..] else { panic!("one geometry") };
    let sequence: &MeshSequence = geometry.downcast_ref().unwrap();
    let starts: Vec<f32> = sequence.steps().iter().map(|mesh| mesh.positions[0][0]).collect();
    assert_eq!((starts, sequence.step()), (vec![0.0, 0.4, 0.8], 0));
    assert_eq!((all[0].loaded.scene.steps(), &*all[0].loaded.scene.name), (3, "a_*"));
    // What is elsewhere, or of other triangles, is another part.
    for other in [square(5.0, true), square(0.4, false)] {
        let all = gather(&folder, &[("b1.obj", square(0.0, true)), ("b2.obj", other)]);
        assert_eq!(all.len(), 2);
        assert!(all.iter().all(|one| one.loaded.scene.geometry[0].downcast_ref::<Mesh>().is_some()));
    }
}
