//! Ray queries without packets find what packets find, with weights and normals, whatever the number and the order of rays.

use crate::common::{Random, Shape};
use mobula_core::glam::Vec3;
use mobula_core::query::{BuildError, Hit, Mesh, Ray, Scene};

/// Positions, and corners of triangles.
type Indexed = (Vec<[f32; 3]>, Vec<[u32; 3]>);
/// Geometry, primitive, and corners.
type Known = (u32, u32, [[f32; 3]; 3]);

/// Meshes of some triangles each, and the same in the order of their ids.
fn meshes(random: &mut Random) -> (Vec<Indexed>, Vec<Known>) {
    let (mut meshes, mut all) = (Vec::new(), Vec::new());
    for geometry in 0..4 {
        let triangles = Shape::Scattered.triangles([0, 40, 1, 25][geometry], 1.0, Vec3::ZERO, random);
        let positions: Vec<_> = triangles.iter().flatten().copied().collect();
        let indices = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        all.extend(triangles.iter().enumerate().map(|(i, &t)| (geometry as u32, i as u32, t)));
        meshes.push((positions, indices));
    }
    (meshes, all)
}

fn build(meshes: &[Indexed]) -> Scene {
    let meshes: Vec<_> = meshes.iter().map(|(positions, indices)| Mesh::new(positions, indices)).collect();
    Scene::build(&meshes).unwrap()
}

/// Rays from one eye, rays all over the place, and rays that end early.
fn rays(random: &mut Random) -> Vec<Ray> {
    let eye = Vec3::new(0.3, 0.2, 4.0);
    let coherent = (0..300).map(|i| {
        let at = Vec3::new((i % 20) as f32 / 10.0 - 1.0, (i / 20) as f32 / 8.0 - 1.0, 0.0);
        Ray::new(eye.to_array(), (at - eye).to_array())
    });
    let mut rays: Vec<_> = coherent.collect();
    for _ in 0..300 {
        let mut ray = Ray::new(random.point(3.0).to_array(), random.point(2.0).to_array());
        if random.below(4) == 0 {
            (ray.t_min, ray.t_max) = (random.unit() * 0.5, random.unit() * 2.0);
        }
        rays.push(ray);
    }
    rays
}

#[test]
fn batches_single_rays_and_any_hits_agree_whatever_the_order() {
    let mut random = Random(11);
    let (meshes, all) = meshes(&mut random);
    let scene = build(&meshes);
    let rays = rays(&mut random);
    let mut hits = vec![Hit::NONE; rays.len()];
    scene.intersect(&rays, &mut hits);
    assert!(hits.iter().filter(|hit| hit.is_hit()).count() > 60);
    let mut occluded = vec![false; rays.len()];
    scene.occluded(&rays, &mut occluded);
    for (i, ray) in rays.iter().enumerate() {
        assert_eq!(scene.intersect_one(ray).unwrap_or(Hit::NONE), hits[i], "ray {i}");
        assert_eq!(scene.occluded_one(ray), hits[i].is_hit(), "ray {i}");
        assert_eq!(occluded[i], hits[i].is_hit(), "ray {i}");
        let alone: Vec<_> = all.iter().map(|(_, _, t)| build(&[(t.to_vec(), vec![[0, 1, 2]])])).collect();
        if i % 20 == 0 {
            let nearest = alone.iter().zip(&all).filter_map(|(one, of)| Some((one.intersect_one(ray)?.t, of)));
            let nearest = nearest.min_by(|(a, _), (b, _)| a.total_cmp(b));
            assert_eq!(
                nearest.map(|(_, of)| (of.0, of.1)),
                hits[i].is_hit().then_some((hits[i].geometry, hits[i].primitive))
            );
        }
    }
    let backwards: Vec<_> = rays.iter().rev().copied().collect();
    for size in [1, 3, 4, 5, 64, 257] {
        for (rays, want) in backwards.chunks(size).zip(hits.iter().rev().copied().collect::<Vec<_>>().chunks(size)) {
            let mut again = vec![Hit::NONE; rays.len()];
            scene.intersect(rays, &mut again);
            assert_eq!(again, want);
        }
    }
}

#[test]
fn weights_and_normals_lead_to_the_point() {
    let mut random = Random(5);
    let (meshes, all) = meshes(&mut random);
    let scene = build(&meshes);
    for ray in rays(&mut random) {
        let Some(hit) = scene.intersect_one(&ray) else { continue };
        let (_, _, corners) = all.iter().find(|(g, p, _)| (*g, *p) == (hit.geometry, hit.primitive)).unwrap();
        let [a, b, c] = corners.map(Vec3::from);
        let weighed = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
        let point = Vec3::from(ray.origin) + Vec3::from(ray.direction) * hit.t;
        assert!((weighed - point).length() < 1e-4, "{hit:?}: {weighed} {point}");
        let normal = Vec3::from(hit.normal);
        assert!((normal.length() - 1.0).abs() < 1e-6 && normal.dot((b - a).cross(c - a)) > 0.0, "{hit:?}");
    }
}

#[test]
fn on_equal_distance_the_lower_pair_is_hit() {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let (twice, once) = ([[0, 1, 2], [0, 1, 2]], [[0, 1, 2]]);
    let scene =
        Scene::build(&[Mesh::new(&positions, &[]), Mesh::new(&positions, &twice), Mesh::new(&positions, &once)]);
    let hit = scene.unwrap().intersect_one(&Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0])).unwrap();
    assert_eq!((hit.geometry, hit.primitive), (1, 0));
}

#[test]
fn what_cannot_be_hit_is_left_out_and_what_is_wrong_is_an_error() {
    let nan = f32::NAN;
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [nan, 0.0, 0.0]];
    let scene = Mesh::new(&positions, &[[0, 1, 2], [0, 1, 3], [1, 1, 2]]).build().unwrap();
    assert_eq!((scene.left_out(), scene.bounds()), (2, Some([[0.0; 3], [1.0, 1.0, 0.0]])));
    let error = Mesh::new(&positions, &[[0, 1, 2], [0, 9, 1]]).build().unwrap_err();
    assert_eq!(error, BuildError::IndexOutOfRange { geometry: 0, primitive: 1, index: 9 });
    assert_eq!(error.to_string(), "triangle 1 of mesh 0 has corner 9, which the mesh does not have");
    let empty = Scene::build(&[]).unwrap();
    assert_eq!(empty.bounds(), None);
    let mut hits = [Hit::NONE; 9];
    empty.intersect(&[Ray::new([0.0; 3], [0.0, nan, 1.0]); 9], &mut hits);
    assert!(hits.iter().all(|hit| !hit.is_hit()));
    empty.intersect(&[], &mut []);
    // Neither NaN, nor a zero direction, nor an empty interval hits anything.
    let odd = [
        Ray::new([nan; 3], [0.0, 0.0, -1.0]),
        Ray::new([0.2, 0.2, 1.0], [0.0; 3]),
        Ray { t_max: f32::NEG_INFINITY, ..Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0]) },
        Ray { t_max: nan, ..Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0]) },
    ];
    let (mut hits, mut occluded) = ([Hit::NONE; 4], [true; 4]);
    scene.intersect(&odd, &mut hits);
    scene.occluded(&odd, &mut occluded);
    assert!(hits.iter().all(|hit| !hit.is_hit()) && occluded == [false; 4], "{hits:?} {occluded:?}");
    assert!(odd.iter().all(|ray| scene.intersect_one(ray).is_none() && !scene.occluded_one(ray)));
}

/// Products of three coordinates leave the range of f32 long before the coordinates do.
#[test]
fn weights_are_right_at_every_size() {
    for exponent in [-30, -20, -10, 0, 10, 18, 20, 30, 37] {
        let e = 10.0f32.powi(exponent);
        let scene = Mesh::new(&[[-e, -e, 0.0], [e, -e, 0.0], [0.0, e, 0.0]], &[[0, 1, 2]]).build().unwrap();
        for length in [1.0, e] {
            let ray = Ray::new([0.0, 0.0, e], [0.0, 0.0, -length]);
            if length < 1e-29 {
                continue;
            }
            let hit = scene.intersect_one(&ray).unwrap_or_else(|| panic!("size {e:e}, direction {length:e}"));
            assert!((hit.u - 0.25).abs() < 1e-6 && (hit.v - 0.5).abs() < 1e-6, "size {e:e}: {hit:?}");
        }
    }
}
