//! What is behind the middle of each pixel: the layers of pictures beside their colour.

use glam::Vec3;

use super::morton::for_each_piece;
use super::pixel_seed;
use crate::layers::{Layers, NOTHING, Plane};
use crate::packet::{Columns3, Packet, set_vec3, vec3};
use crate::pipeline::fault::scope;
use crate::scratch::lend;
use crate::stack::{Camera, Context, Fragment};

/// Fills the layers of the pixels of `fragment`, of a picture of `size`, with what the rays through their middles hit first: all but the
/// light.
pub fn look(context: &Context<'_>, camera: &dyn Camera, fragment: Fragment, size: [u32; 2], layers: &Layers) {
    let packet: &mut Packet = &mut lend(context.width);
    for_each_piece(fragment, context.width, |pixels| {
        packet.reset(pixels.len());
        packet.channel = fragment.channel as u32;
        for (i, &pixel) in pixels.iter().enumerate() {
            packet.image[0][i] = pixel[0] as f32 + 0.5;
            packet.image[1][i] = pixel[1] as f32 + 0.5;
            (packet.samples[0][i], packet.samples[1][i]) = (pixel_seed(pixel), context.frame);
        }
        camera.make_rays(context, size, packet);
        context.scene.intersect(context, packet);
        for run in 0..packet.runs().len() {
            keep(context, packet, run, pixels, layers);
        }
    });
}

/// Keeps what a run of rays hit.
fn keep(context: &Context<'_>, packet: &mut Packet, run: usize, pixels: &[[u32; 2]], layers: &Layers) {
    const GEOMETRY: [Plane; 7] = [
        Plane::Depth,
        Plane::NormalX,
        Plane::NormalY,
        Plane::NormalZ,
        Plane::AlbedoRed,
        Plane::AlbedoGreen,
        Plane::AlbedoBlue,
    ];
    const NUMBERS: [Plane; 3] = [Plane::Geometry, Plane::Primitive, Plane::Material];
    let scene = context.scene;
    let pixels = pixels[packet.runs()[run].rays.clone()].iter().map(|&[x, y]| (x as usize, y as usize));
    let Some((geometry, material)) = packet.runs()[run].hit else {
        for (x, y) in pixels {
            layers.set(GEOMETRY, x, y, [f32::INFINITY, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            layers.set_whole(NUMBERS, x, y, [NOTHING; 3]);
        }
        return;
    };
    let hits = &mut packet.sub_packet(run, Some(scene.geometry.get(geometry)));
    let [albedo, normals]: [&mut Columns3; 2] = [&mut lend(context.width), &mut lend(context.width)];
    scope(scene.materials.scope(material), || scene.materials.get(material).albedo(hits, albedo));
    hits.normals();
    (0..hits.len()).for_each(|i| set_vec3(normals, i, vec3(&hits.normals(), i)));
    for (i, (x, y)) in pixels.enumerate() {
        let (Vec3 { x: nx, y: ny, z: nz }, color) = (vec3(normals, i), vec3(albedo, i));
        layers.set(GEOMETRY, x, y, [hits.distances()[i], nx, ny, nz, color.x, color.y, color.z]);
        layers.set_whole(NUMBERS, x, y, [geometry, hits.primitives()[i], material]);
    }
}
