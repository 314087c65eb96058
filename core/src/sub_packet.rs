//! Sub-packets, and values derived once when first asked for (paper 5.1.4, Figure 6).

use core::ops::{Deref, Range};

use glam::Vec3;

use crate::rays::{set_vec3, vec3};
use crate::{Columns3, Hits, Properties, RayPacket, Rays};

/// Who can tell about the surface at a hit. Implemented by geometry; asked through a [`SubPacket`], at most once a value.
/// Every method fills the rows `range` of `out`, all of which were hit.
pub trait Surface<const N: usize> {
    /// Unit normals of the true geometry. Which side they face is the geometry's.
    fn geometric_normals(&self, rays: &Rays<N>, hits: &Hits<N>, range: Range<usize>, out: &mut Columns3<N>);

    /// Unit shading normals (interpolated where there are vertex normals).
    fn normals(&self, rays: &Rays<N>, hits: &Hits<N>, range: Range<usize>, out: &mut Columns3<N>) {
        self.geometric_normals(rays, hits, range, out);
    }

    /// Texture coordinates (two, and a third that is zero where unused); zero where the geometry has none.
    fn texture_coordinates(&self, _rays: &Rays<N>, _hits: &Hits<N>, range: Range<usize>, out: &mut Columns3<N>) {
        out.iter_mut().for_each(|column| column[range.clone()].fill(0.0));
    }

    /// Derivatives of the position along two surface directions; zero where the geometry has none.
    fn derivatives(&self, _rays: &Rays<N>, _hits: &Hits<N>, range: Range<usize>, out: [&mut Columns3<N>; 2]) {
        out.into_iter().flatten().for_each(|column| column[range.clone()].fill(0.0));
    }
}

/// A range of a packet's rays, without a copy: what a material is handed. It dereferences to the packet. Derived values
/// are computed for this range only, once, and flagged here; the parent's flags stay as they were.
#[derive(Debug)]
pub struct SubPacket<'a, const N: usize> {
    packet: &'a mut RayPacket<N>,
    range: Range<usize>,
    properties: Properties,
}

impl<const N: usize> Deref for SubPacket<'_, N> {
    type Target = RayPacket<N>;
    #[inline(always)]
    fn deref(&self) -> &RayPacket<N> {
        self.packet
    }
}

impl<'a, const N: usize> SubPacket<'a, N> {
    pub(crate) fn new(packet: &'a mut RayPacket<N>, range: Range<usize>, properties: Properties) -> Self {
        Self { packet, range, properties }
    }

    /// The rays of this sub-packet.
    #[inline(always)]
    pub fn range(&self) -> Range<usize> {
        self.range.clone()
    }

    /// What is known of these rays.
    #[inline(always)]
    pub fn properties(&self) -> Properties {
        self.properties
    }

    /// A smaller sub-packet of the same parent, inheriting what was derived.
    ///
    /// # Panics
    /// If the range is not within this sub-packet's.
    pub fn sub_packet(&mut self, range: Range<usize>) -> SubPacket<'_, N> {
        let within = self.range.start <= range.start && range.start <= range.end && range.end <= self.range.end;
        assert!(within, "rays {range:?} of the sub-packet {:?}", self.range);
        SubPacket { packet: self.packet, range, properties: self.properties }
    }

    /// Where the rays hit: `origin + t_max * direction`.
    pub fn positions(&mut self) -> &Columns3<N> {
        if self.lacks(Properties::HAVE_HIT_POSITIONS) {
            let (rays, _, derived) = self.packet.parts();
            for axis in 0..3 {
                let (o, d) = (&rays.origins()[axis], &rays.directions()[axis]);
                for i in self.range.clone() {
                    derived.position[axis][i] = o[i] + rays.t_max[i] * d[i];
                }
            }
        }
        &self.packet.derived.position
    }

    /// Unit geometric normals at the hits.
    pub fn geometric_normals(&mut self, surface: &dyn Surface<N>) -> &Columns3<N> {
        if self.lacks(Properties::HAVE_GEOMETRIC_NORMALS) {
            let (rays, hits, derived) = self.packet.parts();
            surface.geometric_normals(rays, hits, self.range.clone(), &mut derived.geometric_normal);
        }
        &self.packet.derived.geometric_normal
    }

    /// Unit shading normals at the hits.
    pub fn normals(&mut self, surface: &dyn Surface<N>) -> &Columns3<N> {
        if self.lacks(Properties::HAVE_NORMALS) {
            let (rays, hits, derived) = self.packet.parts();
            surface.normals(rays, hits, self.range.clone(), &mut derived.normal);
            self.properties |= Properties::HAVE_UNIT_NORMALS;
        }
        &self.packet.derived.normal
    }

    /// Unit shading normals turned to the side of the surface that the ray comes from, as the geometric normal says;
    /// where shading and geometric normal disagree about the side, the geometric normal.
    pub fn forward_normals(&mut self, surface: &dyn Surface<N>) -> &Columns3<N> {
        self.geometric_normals(surface);
        self.normals(surface);
        if self.lacks(Properties::HAVE_FORWARD_NORMALS) {
            let (rays, _, derived) = self.packet.parts();
            for i in self.range.clone() {
                let direction = vec3(rays.directions(), i);
                let geometric = vec3(&derived.geometric_normal, i);
                let geometric = if geometric.dot(direction) > 0.0 { -geometric } else { geometric };
                let normal = vec3(&derived.normal, i);
                let normal = if normal.dot(geometric) < 0.0 { -normal } else { normal };
                let visible = normal.dot(direction) < 0.0;
                set_vec3(&mut derived.normal, i, if visible { normal } else { geometric });
                set_vec3(&mut derived.geometric_normal, i, geometric);
            }
        }
        &self.packet.derived.normal
    }

    /// Texture coordinates at the hits.
    pub fn texture_coordinates(&mut self, surface: &dyn Surface<N>) -> &Columns3<N> {
        if self.lacks(Properties::HAVE_TEXTURE_COORDINATES_2 | Properties::HAVE_TEXTURE_COORDINATES_3) {
            let (rays, hits, derived) = self.packet.parts();
            surface.texture_coordinates(rays, hits, self.range.clone(), &mut derived.texture);
        }
        &self.packet.derived.texture
    }

    /// Derivatives of the hit positions along two surface directions.
    pub fn derivatives(&mut self, surface: &dyn Surface<N>) -> [&Columns3<N>; 2] {
        if self.lacks(Properties::HAVE_SURFACE_DERIVATIVES) {
            let (rays, hits, derived) = self.packet.parts();
            let out = [&mut derived.derivative_u, &mut derived.derivative_v];
            surface.derivatives(rays, hits, self.range.clone(), out);
        }
        [&self.packet.derived.derivative_u, &self.packet.derived.derivative_v]
    }

    /// What was derived before, by row: hit position, shading normal.
    #[inline(always)]
    pub fn derived(&self, i: usize) -> (Vec3, Vec3) {
        (vec3(&self.packet.derived.position, i), vec3(&self.packet.derived.normal, i))
    }

    /// Sets the colour of ray `i`, linear RGB.
    #[inline(always)]
    pub fn set_color(&mut self, i: usize, color: Vec3) {
        set_vec3(&mut self.packet.color, i, color);
    }

    /// The colours of the packet, to write in this range.
    #[inline(always)]
    pub fn colors_mut(&mut self) -> &mut Columns3<N> {
        &mut self.packet.color
    }

    /// Is `property` still to be derived? Flags it.
    fn lacks(&mut self, property: Properties) -> bool {
        let lacks = !self.properties.contains(property);
        self.properties |= property;
        lacks
    }
}
