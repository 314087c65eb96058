//! Sub-packets, and values derived once when first asked for (paper 5.1.4, Figure 6).

use std::ops::Range;

use glam::{Vec3, Vec4};
use mobula_core::simd::AnyToken;

use super::closest::{Derived, Packet};
use super::column::{Columns3, part, part_mut, rows, set_vec3, vec3};
use super::footprint::Footprints;
use super::forward::turn_forward;
use super::surface::{Hits, Surface};
use crate::texture::Map;

bitflags::bitflags! {
    /// Which values are derived.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    struct Known: u8 {
        const POSITIONS = 1 << 0;
        const GEOMETRIC_NORMALS = 1 << 1;
        const NORMALS = 1 << 2;
        const FORWARD_NORMALS = 1 << 3;
        const TEXTURE_COORDINATES = 1 << 4;
        const DERIVATIVES = 1 << 5;
        const COLORS = 1 << 6;
        const TEXTURE_AREAS = 1 << 7;
    }
}

/// A range of a packet's rays, without a copy: what a material is handed. All slices have one row a ray of the range. Derived values
/// are computed for these rays only, once.
pub struct SubPacket<'a> {
    packet: &'a mut Packet,
    range: Range<usize>,
    surface: Option<&'a dyn Surface>,
    known: Known,
    has_colors: bool,
}

impl Packet {
    /// The rays of one of the [`runs`](Packet::runs), without a copy; `surface` is the geometry that they hit, if any.
    ///
    /// # Panics
    /// If there are not so many runs.
    pub fn sub_packet<'a>(&'a mut self, run: usize, surface: Option<&'a dyn Surface>) -> SubPacket<'a> {
        let range = self.runs()[run].rays.clone();
        SubPacket::new(self, range, surface)
    }
}

impl<'a> SubPacket<'a> {
    fn new(packet: &'a mut Packet, range: Range<usize>, surface: Option<&'a dyn Surface>) -> Self {
        Self { packet, range, surface, known: Known::empty(), has_colors: false }
    }

    /// Number of rays.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.range.len()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.range.is_empty()
    }

    /// How many rays its packet can hold.
    pub fn width(&self) -> usize {
        self.packet.width()
    }

    /// How many reflections or refractions the rays have behind them.
    pub fn depth(&self) -> u32 {
        self.packet.depth
    }

    /// The level that the rays met a structure at.
    pub fn token(&self) -> AnyToken {
        self.packet.token
    }

    /// Index of the channel that the rays belong to.
    pub fn channel(&self) -> u32 {
        self.packet.channel
    }

    /// A smaller sub-packet of the same parent: the rays `range` of these, with what was derived.
    ///
    /// # Panics
    /// If the range is not within this sub-packet.
    pub fn sub_packet(&mut self, range: Range<usize>) -> SubPacket<'_> {
        assert!(
            range.start <= range.end && range.end <= self.len(),
            "rays {range:?} of a sub-packet of {}",
            self.len()
        );
        let range = self.range.start + range.start..self.range.start + range.end;
        let (surface, known, has_colors) = (self.surface, self.known, self.has_colors);
        SubPacket { packet: self.packet, range, surface, known, has_colors }
    }

    /// Where the rays start.
    #[inline(always)]
    pub fn origins(&self) -> [&[f32]; 3] {
        rows(self.packet.rays().origins(), self.range.clone())
    }

    /// Where they go.
    #[inline(always)]
    pub fn directions(&self) -> [&[f32]; 3] {
        rows(self.packet.rays().directions(), self.range.clone())
    }

    /// How far to the hits, in lengths of the directions.
    #[inline(always)]
    pub fn distances(&self) -> &[f32] {
        &self.packet.rays().t_max()[self.range.clone()]
    }

    /// Which primitives of the geometry were hit.
    pub fn primitives(&self) -> &[u32] {
        &self.packet.primitive[self.range.clone()]
    }

    /// Image coordinates of the samples that the rays belong to, x and y.
    pub fn image(&self) -> [&[f32]; 2] {
        let [x, y] = &self.packet.image;
        [&x[self.range.clone()], &y[self.range.clone()]]
    }

    /// The [samples](Packet::samples) that the rays belong to.
    pub fn samples(&self) -> [&[u32]; 2] {
        let [seeds, numbers] = &self.packet.samples;
        [&seeds[self.range.clone()], &numbers[self.range.clone()]]
    }

    /// The hits, as geometry sees them.
    pub fn hits(&self) -> Hits<'_> {
        self.packet.hits(&self.range)
    }

    /// Where the rays hit: `origin + t_max * direction`.
    pub fn positions(&mut self) -> [&[f32]; 3] {
        if self.lacks(Known::POSITIONS) {
            let (hits, derived) = self.packet.parts(&self.range);
            let out = part_mut(&mut derived.position, self.range.clone());
            for ((out, o), d) in out.into_iter().zip(hits.origins).zip(hits.directions) {
                for (((out, o), t), d) in out.iter_mut().zip(o).zip(hits.t).zip(d) {
                    *out = o + t * d;
                }
            }
        }
        part(&self.packet.derived.position, self.range.clone())
    }

    /// Unit geometric normals at the hits.
    pub fn geometric_normals(&mut self) -> [&[f32]; 3] {
        self.derive_geometric_normals();
        part(&self.packet.derived.geometric_normal, self.range.clone())
    }

    /// How large the numbers are that the hits' positions follow from: see [`Surface::geometric_normals`].
    pub fn error_scales(&mut self) -> &[f32] {
        self.derive_geometric_normals();
        &self.packet.derived.error_scale[self.range.clone()]
    }

    fn derive_geometric_normals(&mut self) {
        if self.lacks(Known::GEOMETRIC_NORMALS) {
            let (hits, derived) = self.packet.parts(&self.range);
            let out = part_mut(&mut derived.geometric_normal, self.range.clone());
            let error_scales = &mut derived.error_scale[self.range.clone()];
            match self.surface {
                Some(surface) => surface.geometric_normals(&hits, out, error_scales),
                None => out.into_iter().chain([error_scales]).for_each(|column| column.fill(0.0)),
            }
        }
    }

    /// Unit shading normals at the hits.
    pub fn normals(&mut self) -> [&[f32]; 3] {
        if self.lacks(Known::NORMALS) {
            let (hits, derived) = self.packet.parts(&self.range);
            let out = part_mut(&mut derived.normal, self.range.clone());
            if !self.surface.is_some_and(|surface| surface.normals(&hits, out)) {
                self.derive_geometric_normals();
                let Derived { normal, geometric_normal, .. } = &mut self.packet.derived;
                let geometric = part(geometric_normal, self.range.clone());
                part_mut(normal, self.range.clone()).into_iter().zip(geometric).for_each(|(n, g)| n.copy_from_slice(g));
            }
        }
        part(&self.packet.derived.normal, self.range.clone())
    }

    /// Unit shading normals turned to the side of the surface that the ray comes from, as the geometric normal says;
    /// where shading and geometric normal disagree about the side, the geometric normal, which is turned too.
    pub fn forward_normals(&mut self) -> [&[f32]; 3] {
        self.geometric_normals();
        self.normals();
        if self.lacks(Known::FORWARD_NORMALS) {
            let (hits, derived) = self.packet.parts(&self.range);
            let geometric = part_mut(&mut derived.geometric_normal, self.range.clone());
            let normals = part_mut(&mut derived.normal, self.range.clone());
            turn_forward(hits.token, hits.directions, geometric, normals);
        }
        part(&self.packet.derived.normal, self.range.clone())
    }

    /// Texture coordinates at the hits.
    pub fn texture_coordinates(&mut self) -> [&[f32]; 3] {
        if self.lacks(Known::TEXTURE_COORDINATES) {
            let (hits, derived) = self.packet.parts(&self.range);
            let out = part_mut(&mut derived.texture, self.range.clone());
            match self.surface {
                Some(surface) => surface.texture_coordinates(&hits, out),
                None => out.into_iter().for_each(|column| column.fill(0.0)),
            }
        }
        part(&self.packet.derived.texture, self.range.clone())
    }

    /// Derivatives of the hit positions along two surface directions.
    pub fn derivatives(&mut self) -> [[&[f32]; 3]; 2] {
        if self.lacks(Known::DERIVATIVES) {
            let (hits, derived) = self.packet.parts(&self.range);
            let out = derived.derivatives.each_mut().map(|columns| part_mut(columns, self.range.clone()));
            match self.surface {
                Some(surface) => surface.derivatives(&hits, out),
                None => out.into_iter().flatten().for_each(|column| column.fill(0.0)),
            }
        }
        self.packet.derived.derivatives.each_ref().map(|columns| part(columns, self.range.clone()))
    }

    /// How wide the cones around the rays are at the hits, for directions of unit length, by row.
    #[inline(always)]
    pub fn cone_width(&self, i: usize) -> f32 {
        let packet = &*self.packet;
        let i = self.range.start + i;
        packet.cone_widths[i] + packet.cone_spread * packet.rays().t_max()[i]
    }

    /// By how much the cones around the rays become wider, for each unit of length.
    pub fn cone_spread(&self) -> f32 {
        self.packet.cone_spread
    }

    /// How wide they are as a part of the pixel's.
    pub fn cone_part(&self) -> f32 {
        self.packet.cone_part
    }

    /// How wide a pixel is at the hits, for directions of unit length, by row.
    #[inline(always)]
    pub fn pixel_width(&self, i: usize) -> f32 {
        self.cone_width(i) / self.packet.cone_part
    }

    /// Texture coordinates at the hits, and the areas, in texture coordinates, that the cones around the rays cover of the surface.
    pub fn texture_footprints(&mut self) -> ([&[f32]; 3], &[f32]) {
        self.texture_coordinates();
        if self.lacks(Known::TEXTURE_AREAS) {
            self.derivatives();
            self.geometric_normals();
            let Packet { derived, stored, cone_widths, cone_spread, .. } = &mut *self.packet;
            let Derived { derivatives, geometric_normal, texture_area, .. } = derived;
            let rays = stored.rays();
            let footprints = Footprints {
                cone_widths: &cone_widths[self.range.clone()],
                spread: *cone_spread,
                distances: &rays.t_max()[self.range.clone()],
                directions: rows(rays.directions(), self.range.clone()),
                geometric_normals: part(geometric_normal, self.range.clone()),
                derivatives: derivatives.each_ref().map(|columns| part(columns, self.range.clone())),
            };
            footprints.areas(&mut texture_area[self.range.clone()]);
        }
        let Derived { texture, texture_area, .. } = &self.packet.derived;
        (part(texture, self.range.clone()), &texture_area[self.range.clone()])
    }

    /// Hands on what is seen of a texture at each hit: linear RGB and alpha.
    pub fn sample(&mut self, map: &Map, mut take: impl FnMut(usize, Vec4)) {
        let ([u, v, _], areas) = self.texture_footprints();
        for (i, &area) in areas.iter().enumerate() {
            take(i, map.sample([u[i], v[i]], area));
        }
    }

    /// Changes the unit shading normals before anything follows from them: `change` gets a row, its normal, and the derivatives of the
    /// position there.
    pub fn change_normals(&mut self, mut change: impl FnMut(usize, Vec3, [Vec3; 2]) -> Vec3) {
        debug_assert!(!self.known.contains(Known::FORWARD_NORMALS), "normals that face the rays are derived already");
        self.normals();
        self.derivatives();
        let Derived { normal, derivatives, .. } = &mut self.packet.derived;
        for i in self.range.clone() {
            let along = derivatives.each_ref().map(|columns| vec3(columns, i));
            let changed = change(i - self.range.start, vec3(normal, i), along);
            set_vec3(normal, i, changed);
        }
    }

    /// The colours of the geometry's own at the hits; `None` if it has none.
    pub fn own_colors(&mut self) -> Option<[&[f32]; 3]> {
        if self.lacks(Known::COLORS) {
            let (hits, derived) = self.packet.parts(&self.range);
            let out = part_mut(&mut derived.color, self.range.clone());
            self.has_colors = self.surface.is_some_and(|surface| surface.colors(&hits, out));
        }
        self.has_colors.then(|| part(&self.packet.derived.color, self.range.clone()))
    }

    /// The opacities of the geometry's own at the hits; `false` if it is opaque: see [`Surface::opacities`].
    pub fn own_opacities(&self, out: &mut [f32]) -> bool {
        self.surface.is_some_and(|surface| surface.opacities(&self.hits(), out))
    }

    /// How far hits are from edges; `false` if there are none: see [`Surface::edges`].
    pub fn edges(&self, out: [&mut [f32]; 2]) -> bool {
        self.surface.is_some_and(|surface| surface.edges(&self.hits(), out))
    }

    /// Keeps as much of the rays' colours as their opacities say, and lets the rest come from behind; of what an earlier call kept, if
    /// there was one.
    pub fn fade(&mut self, opacities: &[f32]) {
        for column in self.colors_mut() {
            column.iter_mut().zip(opacities).for_each(|(channel, opacity)| *channel *= opacity);
        }
        let through = self.packet.through_mut()[self.range.clone()].iter_mut();
        through.zip(opacities).for_each(|(through, opacity)| *through = 1.0 - opacity * (1.0 - *through));
    }

    /// The colours of the rays, linear RGB: the result, to write.
    #[inline(always)]
    pub fn colors_mut(&mut self) -> [&mut [f32]; 3] {
        part_mut(&mut self.packet.color, self.range.clone())
    }

    /// Gives all rays one colour.
    pub fn fill_color(&mut self, color: Vec3) {
        for (column, value) in self.colors_mut().into_iter().zip(color.to_array()) {
            column.fill(value);
        }
    }

    /// Gives the rays the colours in the first rows of some columns.
    pub fn set_colors(&mut self, colors: &Columns3) {
        for (out, colors) in self.colors_mut().into_iter().zip(colors) {
            out.copy_from_slice(&colors[..out.len()]);
        }
    }

    /// The shading normals, and the colours to write.
    pub fn normals_and_colors(&mut self) -> ([&[f32]; 3], [&mut [f32]; 3]) {
        self.normals();
        let Packet { derived, color, .. } = &mut *self.packet;
        (part(&derived.normal, self.range.clone()), part_mut(color, self.range.clone()))
    }

    /// The rays' directions, and the colours to write.
    pub fn directions_and_colors(&mut self) -> ([&[f32]; 3], [&mut [f32]; 3]) {
        let (rays, color) = self.packet.rays_and_color();
        (rows(rays.directions(), self.range.clone()), part_mut(color, self.range.clone()))
    }

    /// Is a value still to be derived? Notes that it is.
    fn lacks(&mut self, value: Known) -> bool {
        let lacks = !self.known.contains(value);
        self.known |= value;
        lacks
    }
}

impl std::fmt::Debug for SubPacket<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SubPacket").field("range", &self.range).field("known", &self.known).finish_non_exhaustive()
    }
}
