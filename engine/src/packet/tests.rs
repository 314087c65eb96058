//! What packets promise: any number of rays, derived values once, sub-packets that leave their neighbours alone.

use std::cell::Cell;

use glam::Vec3;
use mobula_core::{NO_HIT, Properties};
use proptest::prelude::*;

use super::*;

/// A packet of 64 rays, of which the first `count` are active and go from one origin to the upper back.
fn filled(count: usize) -> Packet {
    let mut packet = Packet::new(64);
    packet.reset(count);
    packet.rays_mut().set_common_origin(Vec3::new(1.0, 2.0, 3.0));
    for (column, value) in packet.rays_mut().directions_mut().into_iter().zip([0.0, 0.6, 0.8]) {
        column.fill(value);
    }
    packet
}

/// Lets the rays be split into runs of these lengths, all of which hit geometry 0 and material 0.
fn split(packet: &mut Packet, lengths: &[usize]) {
    let found = packet.found();
    found.runs.clear();
    let mut start = 0;
    for length in lengths {
        found.runs.push(Run { rays: start..start + length, hit: Some((0, 0)) });
        start += length;
    }
}

/// A plane across z that counts what it is asked.
#[derive(Default)]
struct Counting {
    geometric: Cell<u32>,
    normals: Cell<u32>,
    texture: Cell<u32>,
    derivatives: Cell<u32>,
    colors: Cell<u32>,
}

fn count(cell: &Cell<u32>) {
    cell.set(cell.get() + 1);
}

fn fill(out: [&mut [f32]; 3], value: [f32; 3]) {
    out.into_iter().zip(value).for_each(|(column, value)| column.fill(value));
}

impl Surface for Counting {
    fn geometric_normals(&self, _: &Hits<'_>, out: [&mut [f32]; 3], error_scales: &mut [f32]) {
        count(&self.geometric);
        fill(out, [0.0, 0.0, -1.0]);
        error_scales.fill(4.0);
    }
    fn normals(&self, _: &Hits<'_>, out: [&mut [f32]; 3]) -> bool {
        count(&self.normals);
        fill(out, [0.0, 0.0, -1.0]);
        true
    }
    fn texture_coordinates(&self, _: &Hits<'_>, out: [&mut [f32]; 3]) {
        count(&self.texture);
        fill(out, [0.5, 0.0, 0.0]);
    }
    fn derivatives(&self, _: &Hits<'_>, [u, v]: [[&mut [f32]; 3]; 2]) {
        count(&self.derivatives);
        fill(u, [2.0, 0.0, 0.0]);
        fill(v, [0.0, 2.0, 0.0]);
    }
    fn colors(&self, hits: &Hits<'_>, out: [&mut [f32]; 3]) -> bool {
        count(&self.colors);
        fill(out, [hits.len() as f32; 3]);
        true
    }
}

#[test]
fn derived_values_are_computed_once() {
    let mut packet = filled(60);
    packet.rays_mut().t_max_mut().fill(2.0);
    split(&mut packet, &[10, 50]);
    let surface = Counting::default();
    let mut whole = packet.sub_packet(1, Some(&surface));
    for _ in 0..3 {
        assert_eq!(whole.positions()[2][0], 3.0 + 2.0 * 0.8);
        assert_eq!(whole.forward_normals()[2][49], -1.0, "the ray comes from below");
        assert_eq!(whole.texture_coordinates()[0][10], 0.5);
        assert_eq!(whole.derivatives()[1][1][10], 2.0);
        assert_eq!(whole.own_colors().expect("it has colours")[0], [50.0; 50]);
        whole.normals();
        whole.geometric_normals();
        assert_eq!(whole.error_scales(), [4.0; 50]);
    }
    let mut part = whole.sub_packet(10..20);
    assert_eq!((part.len(), part.forward_normals()[2].len()), (10, 10));
    part.texture_coordinates();
    assert_eq!(part.own_colors().expect("it still has colours")[0], [50.0; 10]);
    let counts = [&surface.geometric, &surface.normals, &surface.texture, &surface.derivatives, &surface.colors];
    assert_eq!(counts.map(Cell::get), [1; 5]);
}

#[test]
fn normals_are_turned_to_the_ray() {
    let mut packet = filled(3);
    packet.rays_mut().directions_mut()[2][1] = -0.8;
    split(&mut packet, &[3]);
    let surface = Counting::default();
    let mut all = packet.sub_packet(0, Some(&surface));
    assert_eq!(all.forward_normals()[2], [-1.0, 1.0, -1.0]);
}

proptest! {
    #[test]
    fn sub_packets_derive_their_own_rays_and_leave_their_neighbours_alone(at in 1usize..63) {
        let mut packet = filled(64);
        split(&mut packet, &[at, 64 - at]);
        let surface = Counting::default();
        let mut left = packet.sub_packet(0, Some(&surface));
        left.normals();
        left.fill_color(Vec3::ONE);
        prop_assert_eq!(packet.color[0].iter().sum::<f32>(), at as f32);
        let mut right = packet.sub_packet(1, Some(&surface));
        prop_assert_eq!(right.len(), 64 - at);
        prop_assert_eq!(right.normals()[2], vec![-1.0; 64 - at]);
        prop_assert_eq!(surface.normals.get(), 2);
        right.fill_color(Vec3::splat(2.0));
        prop_assert_eq!(packet.color[0].iter().sum::<f32>(), (at + 2 * (64 - at)) as f32);
    }

    #[test]
    fn a_packet_of_any_width_has_any_number_of_rays(width in 1usize..=PacketWidth::WIDEST, some in 0.0..=1.0) {
        let count = (width as f64 * some) as usize;
        let mut packet = Packet::new(width);
        packet.reset(count);
        prop_assert_eq!((packet.len(), packet.rays().t_max()), (count, &vec![f32::INFINITY; count][..]));
        prop_assert_eq!(packet.geometries(), vec![NO_HIT; count]);
        prop_assert_eq!(packet.runs(), [Run { rays: 0..count, hit: None }]);
        let mut any_hit = AnyHitPacket::new(width);
        any_hit.reset(count);
        prop_assert_eq!(any_hit.rays().len(), count);
        prop_assert_eq!(any_hit.rays().origins().map(<[f32]>::len), [count; 3]);
    }
}

#[test]
fn setters_clear_what_they_could_make_false() {
    let mut packet = filled(64);
    let rays = packet.rays_mut();
    rays.promise(Properties::NORMALIZED_DIRECTIONS);
    rays.origins_mut()[0][3] = 9.0;
    assert_eq!(rays.properties() & (Properties::COMMON_ORIGIN | Properties::NORMALIZED_DIRECTIONS), {
        Properties::NORMALIZED_DIRECTIONS
    });
    rays.directions_mut()[0][3] = 9.0;
    assert!(!rays.properties().contains(Properties::NORMALIZED_DIRECTIONS));
}

#[test]
#[should_panic(expected = "rays 4..11 of a sub-packet of 10")]
fn a_sub_packet_of_a_sub_packet_stays_within_it() {
    let mut packet = filled(10);
    packet.sub_packet(0, None).sub_packet(4..11);
}

#[test]
#[should_panic(expected = "5 rays in a packet of 4")]
fn more_rays_than_fit_are_refused() {
    Packet::new(4).reset(5);
}

#[test]
#[should_panic(expected = "no packets hold 257 rays")]
fn packets_wider_than_the_widest_are_refused() {
    Packet::new(257);
}
