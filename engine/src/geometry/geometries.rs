//! All geometry of a scene: which structures find the hits, and what the ids that they find stand for.
//!
//! Geometries of one kind share a structure where they may. A hit is a pair, (geometry, primitive); of hits at equal distance the lower
//! pair counts, whatever structures they are in. In a structure ids are ordered as the pairs that they stand for, so that the
//! structure's own rule, the lower id, is that rule. Before a further structure is walked, the id of each ray that has a hit is set to
//! the number of ids of that structure whose pairs are lower than the pair of the hit: again the lower id is the lower pair.

use std::any::Any;
use std::sync::Arc;

use glam::Vec3;
use mobula_core::simd::AnyToken;
use mobula_core::traverse::Paths;

use super::group::{Group, Member, Translucent, materials_of};
use super::runs::split;
use super::{Census, Geometry, Structure};
use crate::accel::{AccelerationKind, Build};
use crate::packet::{AnyHitPacket, Packet};

/// A scene cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// More primitives in a geometry than there are numbers.
    #[error("a geometry of the scene has 2^32 - 1 primitives or more: more than there are numbers")]
    TooManyPrimitives,
    /// The system has no memory for the acceleration structures.
    #[error("there is no memory to build over {primitives} primitives: it takes about {mib} MiB")]
    NoMemory {
        /// How many there are in the structure that there is no memory for.
        primitives: usize,
        /// What it takes.
        mib: usize,
    },
}

/// An acceleration structure cannot follow: primitives have come or gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the scene has other primitives than its acceleration structure was built over: build it anew")]
pub struct NeedsRebuild;

/// All geometry of a scene.
#[derive(Debug)]
pub struct Geometries {
    list: Vec<Arc<dyn Geometry>>,
    /// So many of them are the scene; those behind are what it stands on.
    own: usize,
    groups: Vec<Group>,
    census: Census,
    /// Of each geometry.
    censuses: Vec<Census>,
    /// The place of each geometry's first primitive among all, in the order of the structures.
    places: Vec<u64>,
    /// Which structures are built.
    kind: AccelerationKind,
}

/// The most ids in a structure: the last number is "no hit".
const MOST_IDS: usize = u32::MAX as usize;

/// Bytes for each primitive that a build takes at its peak: 120 were measured on large meshes, the result with them, and lists
/// that grow want room.
const BUILD_BYTES: usize = 192;

impl Geometries {
    /// Looks at all primitives, and builds structures over those that are not left out.
    ///
    /// # Errors
    /// If a geometry has more primitives than there are numbers, or there is no memory.
    pub fn build(list: Vec<Arc<dyn Geometry>>, build: &Build) -> Result<Self, SceneError> {
        let mut groups = Vec::new();
        let parts = share(&list)?;
        build.progress.expect(list.iter().map(|geometry| 2 * geometry.primitives() as u64).sum());
        for numbers in parts {
            let geometries: Vec<_> = numbers.iter().map(|&number| list[number].clone()).collect();
            has_memory(geometries.iter().map(|geometry| geometry.primitives()).sum())?;
            let structure = geometries[0].structure(&geometries, build);
            let materials = materials_of(numbers.iter().map(|&number| &*list[number]));
            let translucent = numbers.iter().any(|&number| list[number].is_translucent());
            let members =
                numbers.iter().map(|&number| Member { geometry: number as u32, first: 0, count: 0 }).collect();
            groups.push(Group { structure, members, materials, translucent, below: Vec::new() });
        }
        let places = number(&list, &mut groups);
        let censuses = vec![Census::default(); list.len()];
        let own = list.len();
        let mut all = Self { list, own, groups, census: Census::default(), censuses, places, kind: build.kind };
        all.count(|_| true);
        Ok(all)
    }

    /// Puts a geometry under the scene that is no part of it: rays hit it, but bounds, counts and [`list`](Self::list) are without it, and it
    /// stays as it is. Where there is no memory for it, there is none.
    pub fn stand_on(&mut self, ground: Arc<dyn Geometry>, build: &Build) {
        let number = self.list.len() as u32;
        if ground.primitives() == 0 || has_memory(ground.primitives()).is_err() {
            return;
        }
        let structure = ground.structure(std::slice::from_ref(&ground), build);
        let members = vec![Member { geometry: number, first: 0, count: 0 }];
        let (materials, translucent) = (materials_of([&*ground].into_iter()), ground.is_translucent());
        self.groups.push(Group { structure, members, materials, translucent, below: Vec::new() });
        self.list.push(ground);
        self.censuses.push(Census::default());
        self.places = self::number(&self.list, &mut self.groups);
    }

    /// Counts what is in geometries that are new. Where a structure knows that nothing is left out, and the bounds of it all, primitives
    /// need not be looked at.
    fn count(&mut self, is_new: impl Fn(usize) -> bool) {
        let mut bounds = vec![None; self.list.len()];
        for group in &self.groups {
            let whole = group.structure.whole_bounds();
            group.members.iter().for_each(|member| bounds[member.geometry as usize] = whole);
        }
        self.census = Census::default();
        for (number, (census, geometry)) in self.censuses.iter_mut().zip(&self.list[..self.own]).enumerate() {
            if is_new(number) {
                *census = match (bounds[number], geometry.counts()) {
                    (Some(bounds), Some(counts)) => counts.within(bounds),
                    _ => geometry.census(),
                };
            }
            self.census.merge(census);
        }
    }

    /// The geometries, by number.
    pub fn list(&self) -> &[Arc<dyn Geometry>] {
        &self.list[..self.own]
    }

    /// The geometry that a ray hit.
    pub fn get(&self, number: u32) -> &dyn Geometry {
        &*self.list[number as usize]
    }

    /// Least and greatest corner of all primitives that were not left out; `(inf, -inf)` if there are none.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.census.bounds
    }

    /// What was counted and left out.
    pub fn census(&self) -> &Census {
        &self.census
    }

    /// Bytes that the structures occupy.
    pub fn bytes(&self) -> usize {
        self.groups.iter().map(|group| group.structure.bytes()).sum()
    }

    /// The place of a primitive among all primitives of the scene, geometries of one structure together.
    pub fn place(&self, geometry: u32, primitive: u32) -> u64 {
        self.places[geometry as usize] + u64::from(primitive)
    }

    /// Calls `visit` with points that show how far the geometry reaches.
    pub fn extremes(&self, visit: &mut dyn FnMut(Vec3)) {
        self.list().iter().for_each(|geometry| geometry.extremes(visit));
    }

    /// As [`extremes`](Self::extremes), for some `count` of the primitives, where they are many more.
    pub fn some_extremes(&self, count: usize, visit: &mut dyn FnMut(Vec3)) {
        let step = self.list().iter().map(|geometry| geometry.primitives()).sum::<usize>().div_ceil(count).max(1);
        self.list().iter().for_each(|geometry| geometry.some_extremes(step, visit));
    }

    /// Replaces the geometries by others whose primitives are the same, at other places, and
    /// [refits](super::Structure::refit) the structures: what animation calls before a frame. Where all geometries of a structure are
    /// the same as before, nothing is done for it.
    ///
    /// # Errors
    /// [`NeedsRebuild`] if the primitives are not the same; then nothing has changed.
    pub fn refit(&mut self, list: Vec<Arc<dyn Geometry>>) -> Result<(), NeedsRebuild> {
        self.change(
            list,
            |group, members| group.structure.can_refit(members),
            |structure, members| {
                structure.refit(members);
            },
        )
    }

    /// As [`refit`](Self::refit), but a structure that cannot follow, since primitives that were left out have come back, is built anew.
    ///
    /// # Errors
    /// [`NeedsRebuild`] if there are more or fewer geometries, or one is of another kind or has another number of primitives; then nothing
    /// has changed.
    pub fn follow(&mut self, list: Vec<Arc<dyn Geometry>>) -> Result<(), NeedsRebuild> {
        let build = Build::from(self.kind);
        let counts: Vec<usize> = self.list.iter().map(|geometry| geometry.primitives()).collect();
        let kinds: Vec<_> = self.list.iter().map(|geometry| (&**geometry as &dyn Any).type_id()).collect();
        let fits = |group: &Group, members: &[Arc<dyn Geometry>]| {
            let alike = |(member, geometry): (&Member, &Arc<dyn Geometry>)| {
                let number = member.geometry as usize;
                kinds[number] == (&**geometry as &dyn Any).type_id() && counts[number] == geometry.primitives()
            };
            group.structure.can_refit(members) || group.members.iter().zip(members).all(alike)
        };
        self.change(list, fits, |structure, members| {
            if structure.can_refit(members) {
                structure.refit(members);
            } else {
                *structure = members[0].structure(members, &build);
            }
        })
    }

    /// Replaces the geometries, if the structures of all `fit`; each whose geometries are others `follows` them.
    fn change(
        &mut self,
        mut list: Vec<Arc<dyn Geometry>>,
        fit: impl Fn(&Group, &[Arc<dyn Geometry>]) -> bool,
        follows: impl Fn(&mut Box<dyn Structure>, &[Arc<dyn Geometry>]),
    ) -> Result<(), NeedsRebuild> {
        if list.len() != self.own {
            return Err(NeedsRebuild);
        }
        list.extend_from_slice(&self.list[self.own..]);
        let members = |group: &Group| -> Vec<Arc<dyn Geometry>> {
            group.members.iter().map(|member| list[member.geometry as usize].clone()).collect()
        };
        let fits = self.groups.iter().all(|group| fit(group, &members(group)));
        // What is in no structure has no primitives, and must not get any.
        let placed = |number: usize| {
            self.groups.iter().any(|group| group.members.iter().any(|member| member.geometry as usize == number))
        };
        if !fits || (0..list.len()).any(|number| !placed(number) && list[number].primitives() > 0) {
            return Err(NeedsRebuild);
        }
        let same = |number: usize| Arc::ptr_eq(&list[number], &self.list[number]);
        // What shares a structure with what is new has the bounds of both.
        let mut is_new: Vec<bool> = (0..list.len()).map(|number| !same(number)).collect();
        for group in &mut self.groups {
            if group.members.iter().all(|member| same(member.geometry as usize)) {
                continue;
            }
            group.members.iter().for_each(|member| is_new[member.geometry as usize] = true);
            let members: Vec<_> = group.members.iter().map(|member| list[member.geometry as usize].clone()).collect();
            follows(&mut group.structure, &members);
            group.materials = materials_of(members.iter().map(|member| &**member));
            group.translucent = members.iter().any(|member| member.is_translucent());
        }
        self.places = number(&list, &mut self.groups);
        self.list = list;
        self.count(|number| is_new[number]);
        Ok(())
    }

    /// Finds the nearest hit of each ray, and what the hits stand for. Indices of materials above `last` count as that.
    pub fn intersect(&self, token: AnyToken, packet: &mut Packet, last: u32) -> Paths {
        let mut paths = Paths::default();
        let mut groups = self.groups.iter().filter(|group| group.structure.primitives() > 0);
        let Some(first) = groups.next() else { return paths };
        paths += packet.intersect(token, &*first.structure);
        first.resolve(&mut packet.found());
        for group in groups {
            paths += group.intersect_further(token, packet);
        }
        split(&self.list, &mut packet.found(), last);
        paths
    }

    /// Finds which rays hit anything, and how much light gets through primitives that are not opaque.
    pub fn occlude(&self, token: AnyToken, packet: &mut AnyHitPacket, light: &Translucent<'_>) -> Paths {
        let mut paths = Paths::default();
        // What is opaque as a whole comes first: the rays that it stops need not be looked at any further.
        for transparent in [false, true] {
            let all = self.groups.iter().filter(|group| group.structure.primitives() > 0);
            for group in all.filter(|group| group.lets_through(light) == transparent) {
                paths += group.occlude(token, packet, light);
            }
        }
        paths
    }
}

/// Asks for the memory of a build, and gives it back: what is asked for piece by piece is not refused then.
fn has_memory(primitives: usize) -> Result<(), SceneError> {
    let bytes = primitives.saturating_mul(BUILD_BYTES);
    let asked = Vec::<u8>::new().try_reserve_exact(bytes);
    asked.map_err(|_| SceneError::NoMemory { primitives, mib: bytes.div_ceil(1 << 20) })
}

/// Gives the primitives of geometries their ids in the structures, and returns the place of each geometry's first primitive among all.
fn number(list: &[Arc<dyn Geometry>], groups: &mut [Group]) -> Vec<u64> {
    let mut places = vec![0; list.len()];
    let mut place = 0;
    for group in groups {
        let mut first = 0;
        for member in &mut group.members {
            let count = list[member.geometry as usize].primitives() as u32;
            (member.first, member.count) = (first, count);
            places[member.geometry as usize] = place;
            first += count;
            place += u64::from(count);
        }
        let (mut members, mut below) = (group.members.iter().peekable(), 0);
        let before = |number: u32| {
            let first = below;
            below += members.next_if(|member| member.geometry == number).map_or(0, |member| member.count);
            first
        };
        group.below = (0..list.len() as u32).map(before).collect();
    }
    places
}

/// Which geometries are in a structure together, by number. Those without primitives are in none.
fn share(list: &[Arc<dyn Geometry>]) -> Result<Vec<Vec<usize>>, SceneError> {
    let mut groups: Vec<(usize, Vec<usize>)> = Vec::new();
    for (number, geometry) in list.iter().enumerate() {
        let count = geometry.primitives();
        if count >= MOST_IDS {
            return Err(SceneError::TooManyPrimitives);
        }
        let kind = |number: usize| (&*list[number] as &dyn Any).type_id();
        let open = |(ids, members): &(usize, Vec<usize>)| {
            geometry.shares_structure()
                && list[members[0]].shares_structure()
                && kind(members[0]) == kind(number)
                && ids + count < MOST_IDS
        };
        match groups.iter_mut().find(|group| open(group)) {
            _ if count == 0 => {}
            Some((ids, members)) => {
                *ids += count;
                members.push(number);
            }
            None => groups.push((count, vec![number])),
        }
    }
    Ok(groups.into_iter().map(|(_, members)| members).collect())
}

#[cfg(test)]
mod tests {
    use super::super::{Mesh, MeshSequence, Spheres};
    use super::*;
    use crate::accel::AccelerationKind;
    use crate::packet::{Run, set_vec3};

    /// A square across z.
    fn square(z: f32, materials: Vec<u32>) -> Arc<dyn Geometry> {
        let positions = vec![[-9.0, -9.0, z], [9.0, -9.0, z], [9.0, 9.0, z], [-9.0, 9.0, z]];
        Arc::new(Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], materials, material: 3, ..Mesh::default() })
    }

    /// A sphere whose nearest point is at z.
    fn sphere(z: f32) -> Arc<dyn Geometry> {
        Arc::new(Spheres { centers: vec![[0.5, 0.25, z - 0.5]], radii: vec![0.5], material: 7, ..Spheres::default() })
    }

    fn build(list: Vec<Arc<dyn Geometry>>) -> Geometries {
        Geometries::build(list, &AccelerationKind::Bvh.into()).unwrap()
    }

    /// What 20 rays down the z axis from z = 4 hit: all the same place.
    fn hit(geometries: &Geometries) -> (Vec<Run>, u32, f32) {
        let mut packet = Packet::new(64);
        packet.reset(20);
        for i in 0..20 {
            set_vec3(&mut packet.rays_mut().origins_mut(), i, Vec3::new(0.5, 0.25, 4.0));
            set_vec3(&mut packet.rays_mut().directions_mut(), i, Vec3::NEG_Z);
        }
        geometries.intersect(AnyToken::detect(), &mut packet, 5);
        (packet.runs().to_vec(), packet.primitives()[0], packet.rays().t_max()[0])
    }

    #[test]
    fn what_structures_know_is_what_a_look_at_all_primitives_finds() {
        let flat: Arc<dyn Geometry> =
            Arc::new(Mesh { positions: vec![[7.0; 3]; 4], triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() });
        let look = |list: &[Arc<dyn Geometry>]| {
            let mut all = Census::default();
            list.iter().for_each(|geometry| all.merge(&geometry.census()));
            all
        };
        let whole = [square(0.0, vec![]), square(2.0, vec![]), sphere(5.0)];
        let mut geometries = build(whole.to_vec());
        assert_eq!(geometries.census(), &look(&whole));
        // Moved, without area, and as before: the bounds follow.
        for second in [square(-3.0, vec![]), flat.clone(), whole[1].clone()] {
            let list = [whole[0].clone(), second, whole[2].clone()];
            geometries.refit(list.to_vec()).unwrap();
            assert_eq!(geometries.census(), &look(&list));
        }
        let list = [whole[0].clone(), flat];
        assert_eq!(build(list.to_vec()).census(), &look(&list));
    }

    #[test]
    fn of_hits_at_one_distance_the_lower_pair_counts_across_structures() {
        let run = |geometry, material| vec![Run { rays: 0..20, hit: Some((geometry, material)) }];
        // In all orders of two kinds of structures; 7 is above the last material, 5.
        assert_eq!(hit(&build(vec![square(0.0, vec![]), sphere(0.0)])), (run(0, 3), 0, 4.0));
        assert_eq!(hit(&build(vec![sphere(0.0), square(0.0, vec![])])), (run(0, 5), 0, 4.0));
        assert_eq!(hit(&build(vec![square(-1.0, vec![]), sphere(0.0), square(0.0, vec![])])), (run(1, 5), 0, 4.0));
        assert_eq!(hit(&build(vec![sphere(-1.0), square(0.0, vec![]), sphere(0.0)])), (run(1, 3), 0, 4.0));
        // The nearer one in any case.
        assert_eq!(hit(&build(vec![square(0.0, vec![]), sphere(0.5)])), (run(1, 5), 0, 3.5));
        assert_eq!(hit(&build(vec![sphere(0.5), square(1.0, vec![])])), (run(1, 3), 0, 3.0));
        assert_eq!(hit(&build(vec![square(0.0, vec![]), square(0.0, vec![1; 2]), sphere(-0.5)])), (run(0, 3), 0, 4.0));
    }

    #[test]
    fn runs_have_one_geometry_and_material() {
        let list = vec![square(0.0, vec![2, 9]), sphere(1.0)];
        let geometries = build(list);
        let mut packet = Packet::new(64);
        packet.reset(64);
        let from = |i: usize| match i {
            0..10 => Vec3::new(20.0, 0.0, 4.0),
            10..30 => Vec3::new(3.0, -3.0, 4.0),
            30..40 => Vec3::new(-3.0, 3.0, 4.0),
            _ => Vec3::new(0.5, 0.25, 4.0),
        };
        for i in 0..64 {
            set_vec3(&mut packet.rays_mut().origins_mut(), i, from(i));
            set_vec3(&mut packet.rays_mut().directions_mut(), i, Vec3::NEG_Z);
        }
        geometries.intersect(AnyToken::detect(), &mut packet, 5);
        let expected = [(0..10, None), (10..30, Some((0, 2))), (30..40, Some((0, 5))), (40..64, Some((1, 5)))];
        assert_eq!(packet.runs(), expected.map(|(rays, hit)| Run { rays, hit }));
        assert_eq!(packet.primitives()[10..40], [[0; 20].as_slice(), &[1; 10]].concat());
        assert_eq!([geometries.place(0, 1), geometries.place(1, 0)], [1, 2]);
    }

    #[test]
    fn structures_know_their_materials() {
        let geometries = build(vec![square(0.0, vec![2, 9]), sphere(1.0), square(1.0, vec![])]);
        let materials: Vec<_> = geometries.groups.iter().map(|group| &group.materials[..]).collect();
        assert_eq!(materials, [&[2, 3, 9][..], &[7]]);
        let lets_through = |materials: &[u32], last| {
            let light = Translucent { materials, last, depths: &|_| 0 };
            geometries.groups.iter().map(|group| group.lets_through(&light)).collect::<Vec<_>>()
        };
        assert_eq!(lets_through(&[], 20), [false, false]);
        assert_eq!(lets_through(&[0, 7], 20), [false, true]);
        assert_eq!(lets_through(&[3], 20), [true, false]);
        assert_eq!(lets_through(&[8], 8), [true, false], "9 is above the last one, and so means it");
        assert_eq!(lets_through(&[5], 5), [true, true], "all above the last one mean it");
    }

    #[test]
    fn geometry_without_primitives_is_in_no_structure() {
        let empty: Arc<dyn Geometry> = Arc::new(Mesh::default());
        let mut geometries = build(vec![empty.clone(), sphere(0.0), empty.clone()]);
        assert_eq!(hit(&geometries).2, 4.0);
        assert_eq!(geometries.refit(vec![empty.clone(), sphere(1.0), empty.clone()]), Ok(()));
        assert_eq!(hit(&geometries).2, 3.0);
        assert_eq!(geometries.refit(vec![square(0.0, vec![]), sphere(1.0), empty]), Err(NeedsRebuild));
        assert_eq!(hit(&build(vec![])), (vec![Run { rays: 0..20, hit: None }], 0, f32::INFINITY));
    }

    #[test]
    fn meshes_follow_time_even_where_triangles_come_back() {
        let mesh = |z: f32, wide: f32| Mesh {
            positions: vec![[-wide, -9.0, z], [wide, -9.0, z], [wide, 9.0, z], [-9.0, 9.0, z], [-9.0, -9.0, z]],
            triangles: vec![[0, 1, 2], [4, 2, 3]],
            ..Mesh::default()
        };
        // In the second step the triangle that the rays hit has no area, in the third it is there again.
        let steps = vec![mesh(0.0, 9.0), mesh(1.0, 0.0), mesh(2.0, 9.0)];
        let sequence = MeshSequence::new(steps.clone()).unwrap();
        let all = |step: usize| vec![sphere(-1.0), Arc::new(sequence.at(step)) as Arc<dyn Geometry>];
        for first in 0..3 {
            let mut geometries = build(all(first));
            for step in [first, 1, 2, 1, 0, 4, 5] {
                geometries.follow(all(step)).unwrap();
                let same = build(vec![sphere(-1.0), Arc::new(steps[step % 3].clone())]);
                assert_eq!(hit(&geometries), hit(&same), "from step {first} to {step}");
                assert_eq!(geometries.bounds(), same.bounds());
            }
            assert_eq!(geometries.follow(vec![sphere(0.0)]), Err(NeedsRebuild));
            assert_eq!(geometries.follow(vec![sphere(-1.0), Arc::new(mesh(0.0, 9.0))]), Err(NeedsRebuild));
        }
        assert!(
            MeshSequence::new(vec![mesh(0.0, 1.0), Mesh::default()]).is_none() && MeshSequence::new(vec![]).is_none()
        );
    }
}
