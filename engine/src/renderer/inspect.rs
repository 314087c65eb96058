//! Renderers that show one quantity of each hit as a colour, to look at geometry.

use glam::Vec3;

use crate::material::NormalColor;
use crate::math::{hash, normalize, unit};
use crate::packet::{Column, Columns3, Packet, SubPacket, set_vec3, vec3};
use crate::scratch::lend;
use crate::stack::{Context, Renderer};

/// What [`Inspect`] shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The unit shading normal n: `(n + 1) / 2`.
    Normal,
    /// Distance: `s / (s + t)`, where s is the size of the scene. Near is white.
    Depth,
    /// Texture coordinates: red and green, their fractional parts.
    TextureCoordinates,
    /// The colours of surfaces, unlit.
    Albedo,
    /// A colour for each primitive.
    Primitive,
    /// The edges of triangles, over a grey that is brighter the more a surface faces the eye.
    Edges,
}

/// Shows one quantity of what primary rays hit; black where nothing is.
#[derive(Clone, Copy, Debug)]
pub struct Inspect(pub Quantity);

impl Renderer for Inspect {
    fn trace(&self, context: &Context<'_>, packet: &mut Packet) {
        let scene = context.scene;
        context.statistics.count_rays(packet);
        scene.intersect(context, packet);
        for run in 0..packet.runs().len() {
            match packet.runs()[run].hit {
                Some((geometry, material)) => {
                    let hits = &mut packet.sub_packet(run, Some(scene.geometry.get(geometry)));
                    self.show(context, [geometry, material], hits);
                }
                None => packet.sub_packet(run, None).fill_color(Vec3::ZERO),
            }
        }
    }
}

/// Lines are so many pixels wide, and at most such a part of the radius of a triangle's inscribed circle, so that fine meshes are not black.
const LINE: f32 = 1.4;
const MOST_LINE: f32 = 0.3;

fn show_edges(context: &Context<'_>, hits: &mut SubPacket<'_>, colors: &mut Columns3) {
    let [distance, inscribed]: [&mut Column<f32>; 2] = [&mut lend(context.width), &mut lend(context.width)];
    let count = hits.len();
    let edges = hits.edges([&mut distance[..count], &mut inscribed[..count]]);
    hits.forward_normals();
    for i in 0..count {
        let facing = -normalize(vec3(&hits.directions(), i)).dot(vec3(&hits.forward_normals(), i));
        let on_line = edges && distance[i] < (0.5 * LINE * hits.pixel_width(i)).min(MOST_LINE * inscribed[i]);
        set_vec3(colors, i, Vec3::splat(if on_line { 0.02 } else { 0.1 + 0.6 * facing }));
    }
}

impl Inspect {
    fn show(&self, context: &Context<'_>, [geometry, material]: [u32; 2], hits: &mut SubPacket<'_>) {
        let scene = context.scene;
        let colors: &mut Columns3 = &mut lend(context.width);
        match self.0 {
            Quantity::Normal => return NormalColor::show(hits),
            Quantity::Depth => {
                let (low, high) = scene.geometry.bounds();
                let size = (high - low).length();
                for (i, t) in hits.distances().iter().enumerate() {
                    set_vec3(colors, i, Vec3::splat(size / (size + t)));
                }
            }
            Quantity::TextureCoordinates => {
                for (to, from) in colors.iter_mut().zip(hits.texture_coordinates()) {
                    to.iter_mut().zip(from).for_each(|(to, from)| *to = from - from.floor());
                }
            }
            Quantity::Edges => show_edges(context, hits, colors),
            Quantity::Albedo => scene.materials.get(material).albedo(hits, colors),
            Quantity::Primitive => {
                for (i, &primitive) in hits.primitives().iter().enumerate() {
                    let h = hash((scene.geometry.place(geometry, primitive) as u32).wrapping_add(1));
                    set_vec3(colors, i, Vec3::from([h, h << 8, h << 16].map(|c| 0.1 + 0.8 * unit(c))));
                }
            }
        }
        hits.set_colors(colors);
    }
}
