//! A structure and the geometries in it: what its ids stand for, and whether light gets through.

use std::collections::BTreeSet;

use mobula_core::NO_HIT;
use mobula_core::simd::AnyToken;
use mobula_core::sink::Opacity;
use mobula_core::traverse::Paths;

use super::{Geometry, Structure};
use crate::packet::{AnyHitPacket, Column, Found, Packet};
use crate::scratch::lend;

/// A structure and the geometries in it.
#[derive(Debug)]
pub(super) struct Group {
    pub(super) structure: Box<dyn Structure>,
    /// By rising number, which is by rising id.
    pub(super) members: Vec<Member>,
    /// The indices of the materials of all primitives, by rising index.
    pub(super) materials: Vec<u32>,
    /// May primitives let light through whatever their materials are?
    pub(super) translucent: bool,
    /// For each geometry of the scene: how many ids stand for lower pairs than any hit of it that is in another structure.
    pub(super) below: Vec<u32>,
}

/// A geometry in a structure: the ids `first..first + count`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    pub(super) geometry: u32,
    pub(super) first: u32,
    pub(super) count: u32,
}

/// The [optical depth](crate::packet::optical_depth) of a primitive where a ray meets it.
pub type Depths<'a> = dyn Fn(Meeting) -> u32 + Sync + 'a;

/// Where a ray meets a primitive.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Which ray of the packet.
    pub ray: usize,
    /// The number of the geometry.
    pub geometry: u32,
    /// Which primitive of it.
    pub primitive: u32,
    /// How far, in lengths of the direction.
    pub t: f32,
}

/// What lets light through.
#[derive(Clone, Copy)]
pub struct Translucent<'a> {
    /// The indices of the materials that do.
    pub materials: &'a [u32],
    /// The index of the last material: all above it mean it, too.
    pub last: u32,
    /// How deep primitives are.
    pub depths: &'a Depths<'a>,
}

/// The optical depths of primitives, by their ids in a structure.
struct Through<'a> {
    group: &'a Group,
    depths: &'a Depths<'a>,
}

impl Opacity for Through<'_> {
    fn depth(&self, ray: usize, primitive: u32, t: f32) -> u32 {
        let (geometry, primitive) = self.group.pair(primitive, &mut 0);
        (self.depths)(Meeting { ray, geometry, primitive, t })
    }
}

impl Group {
    /// May any of its primitives let light through?
    pub(super) fn lets_through(&self, light: &Translucent<'_>) -> bool {
        let highest = self.materials.last().copied().unwrap_or(0);
        let used =
            |index: &u32| self.materials.binary_search(index).is_ok() || (*index == light.last && highest > light.last);
        self.translucent || light.materials.iter().any(used)
    }

    /// The geometry and the primitive of an id. `near` is where to look first: the place of the last one.
    #[inline(always)]
    fn pair(&self, id: u32, near: &mut usize) -> (u32, u32) {
        let holds = |member: &Member| id.wrapping_sub(member.first) < member.count;
        if !self.members.get(*near).is_some_and(holds) {
            *near = self.members.partition_point(|member| member.first <= id) - 1;
        }
        let member = self.members[*near];
        (member.geometry, id - member.first)
    }

    /// Finds which rays are stopped by this structure, and how much light gets through.
    pub(super) fn occlude(&self, token: AnyToken, packet: &mut AnyHitPacket, light: &Translucent<'_>) -> Paths {
        let through = Through { group: self, depths: light.depths };
        let opacity = self.lets_through(light).then_some(&through as &dyn Opacity);
        packet.occlude(token, &*self.structure, opacity)
    }

    /// Notes what the ids that this structure found stand for.
    pub(super) fn resolve(&self, found: &mut Found<'_>) {
        if let [only] = self.members[..] {
            found.primitives.copy_from_slice(found.ids);
            for (geometry, &id) in found.geometries.iter_mut().zip(found.ids) {
                *geometry = if id == NO_HIT { NO_HIT } else { only.geometry };
            }
            return;
        }
        let mut near = 0;
        let rows = found.geometries.iter_mut().zip(found.primitives.iter_mut()).zip(found.ids);
        for ((geometry, primitive), &id) in rows {
            *geometry = NO_HIT;
            if id != NO_HIT {
                (*geometry, *primitive) = self.pair(id, &mut near);
            }
        }
    }

    /// Lets rays that may have hits in other structures meet this one.
    pub(super) fn intersect_further(&self, token: AnyToken, packet: &mut Packet) -> Paths {
        let mut ids = lend::<Column<u32>>(packet.width());
        let mut distances = lend::<Column<f32>>(packet.width());
        let found = packet.found();
        let count = found.t.len();
        distances[..count].copy_from_slice(found.t);
        for (id, &geometry) in ids.iter_mut().zip(found.geometries.iter()) {
            *id = self.below.get(geometry as usize).copied().unwrap_or(NO_HIT);
        }
        let paths = packet.intersect_further(token, &*self.structure, &ids);
        let found = packet.found();
        let mut near = 0;
        for i in 0..count {
            // A new hit is nearer, or has a lower id than was set.
            if found.ids[i] != ids[i] || found.t[i] < distances[i] {
                (found.geometries[i], found.primitives[i]) = self.pair(found.ids[i], &mut near);
            }
        }
        paths
    }
}

/// The indices of the materials of all primitives of some geometries, by rising index.
pub(super) fn materials_of<'a>(geometries: impl Iterator<Item = &'a dyn Geometry>) -> Vec<u32> {
    /// Primitives that are asked for at once.
    const AT_ONCE: usize = 1024;
    let mut all = BTreeSet::new();
    let (mut primitives, mut materials) = ([0; AT_ONCE], [0; AT_ONCE]);
    for geometry in geometries {
        let count = geometry.primitives();
        for first in (0..count).step_by(AT_ONCE) {
            let some = AT_ONCE.min(count - first);
            primitives.iter_mut().zip(first as u32..).for_each(|(primitive, number)| *primitive = number);
            if let Some(one) = geometry.materials(&primitives[..some], &mut materials[..some]) {
                all.insert(one);
                break;
            }
            // Neighbours are often alike.
            all.extend(materials[..some].chunk_by(|a, b| a == b).map(|alike| alike[0]));
        }
    }
    all.into_iter().collect()
}
