//! Ambient occlusion and nothing else: a model in light that comes from everywhere.

use glam::Vec3;

use crate::lighting::Points;
use crate::packet::{Column, Packet, part_mut};
use crate::scratch::lend;
use crate::shading::openness;
use crate::stack::{Context, Renderer};

/// Shows how open the sky is above each point, from black to white; white where nothing is.
#[derive(Clone, Copy, Debug, Default)]
pub struct AmbientOcclusion;

impl Renderer for AmbientOcclusion {
    fn trace(&self, context: &Context<'_>, packet: &mut Packet) {
        let scene = context.scene;
        context.statistics.count_rays(packet);
        scene.intersect(context, packet);
        let points: &mut Points = &mut lend(context.width);
        points.clear();
        for run in 0..packet.runs().len() {
            match packet.runs()[run].hit {
                Some((geometry, _)) => points.append(&mut packet.sub_packet(run, Some(scene.geometry.get(geometry)))),
                None => packet.sub_packet(run, None).fill_color(Vec3::ONE),
            }
        }
        let open: &mut Column<f32> = &mut lend(context.width);
        openness(context, scene.occlusion.unwrap_or_default(), points, packet.depth, open);
        let mut first = 0;
        let (runs, colors) = packet.runs_and_colors();
        for run in runs.iter().filter(|run| run.hit.is_some()) {
            let rows = first..first + run.rays.len();
            first = rows.end;
            part_mut(colors, run.rays.clone())
                .into_iter()
                .for_each(|column| column.copy_from_slice(&open[rows.clone()]));
        }
    }
}
