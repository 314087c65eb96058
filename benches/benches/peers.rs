//! Mobula beside Embree: the same rays, one process, one core, turn by turn.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use mobula_benches::embree::{Device, Interface, Quality, Scene};
use mobula_benches::rays::{Found, Kind, RaySet};
use mobula_benches::scenes::{self, Triangles, VIEWS, View};
use mobula_benches::verdict::{self, Verdict};
use mobula_benches::{clock, packets, secondary};
use mobula_core::bvh::{Bvh, Serial, TriangleBlock};
use mobula_core::simd::{AnyToken, Level};

#[derive(Debug, Parser)]
struct Arguments {
    /// Scenes, by name.
    #[arg(long, value_delimiter = ',')]
    scene: Vec<String>,
    /// Kinds of rays.
    #[arg(long, value_delimiter = ',')]
    rays: Vec<String>,
    /// Instruction sets.
    #[arg(long, value_delimiter = ',', default_value = "avx512")]
    level: Vec<Level>,
    #[arg(long, default_value_t = 7)]
    repeat: usize,
    #[arg(long, default_value = "../shared/data/meshes")]
    data: PathBuf,
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let tsc = clock::tick_frequency();
    println!("{}", clock::machine(tsc));
    for view in VIEWS.iter().filter(|v| arguments.scene.is_empty() || arguments.scene.iter().any(|s| s == v.name)) {
        let triangles = match scenes::triangles(view, &arguments.data) {
            Ok(triangles) => triangles,
            Err(reason) => {
                println!("{}: skipped: {reason}", view.name);
                continue;
            }
        };
        for &level in &arguments.level {
            scene(view, &triangles, level, &arguments, tsc);
        }
    }
    ExitCode::SUCCESS
}

fn scene(view: &View, triangles: &Triangles, level: Level, arguments: &Arguments, tsc: f64) {
    let token = AnyToken::for_level(level).expect("level");
    let isa = if level == Level::Sse2 { "sse4.2" } else { level.name() };
    let device = Device::new(isa, 1).expect("embree");
    let (embree, embree_build) = clock::time(|| Scene::new(&device, triangles, Quality::Medium).expect("embree"));
    let (bvh, build) = clock::time(|| {
        Bvh::<TriangleBlock>::triangles(triangles.indices.len(), 0, &Serial, |i| triangles.corners(i))
    });
    println!(
        "{} {} triangles, {level}: build Mobula {:.3} s {:.1} MB, Embree medium {:.3} s {:.1} MB",
        view.name,
        triangles.indices.len(),
        build.thread,
        bvh.bytes() as f64 * 1e-6,
        embree_build.thread,
        embree.bytes() as f64 * 1e-6
    );
    let primary = RaySet::primary(view);
    let mut hits = Found::new(primary.len());
    let one = Interface { entry: mobula_benches::embree::Entry::One, coherent: false };
    embree.intersect(one, &primary, &mut hits);
    println!("  {} hits, distances {:.5e}, known {:?}", hits.hits(false), hits.distances(), view.known);
    for kind in Kind::ALL {
        if !arguments.rays.is_empty() && !arguments.rays.iter().any(|r| r == kind.name()) {
            continue;
        }
        let rays = secondary::rays(kind, view, triangles, &primary, &hits);
        let mut by_embree = Found::new(rays.len());
        let mut by_us = Found::new(rays.len());
        let run = |interface: Interface, found: &mut Found| {
            if kind.any_hit() { embree.occluded(interface, &rays, found) } else { embree.intersect(interface, &rays, found) }
        };
        let cycles = |e: clock::Elapsed| e.thread * tsc / rays.len() as f64;
        let mut all: Vec<(f64, Interface)> = Interface::all()
            .filter(|&i| device.is_native(i))
            .map(|i| (cycles(clock::time(|| run(i, &mut by_embree)).1), i))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let text: Vec<String> = all.iter().map(|(c, i)| format!("{i} {c:.0}")).collect();
        run(one, &mut by_embree);
        let mut table: Vec<[f64; 5]> = Vec::new();
        let mut scratch = Found::new(rays.len());
        for _ in 0..arguments.repeat {
            table.push([
                cycles(clock::time(|| run(all[0].1, &mut scratch)).1),
                cycles(clock::time(|| packets::trace::<64, _>(&bvh, token, kind, &rays, &mut by_us)).1),
                cycles(clock::time(|| run(all[1].1, &mut scratch)).1),
                cycles(clock::time(|| packets::trace::<16, _>(&bvh, token, kind, &rays, &mut scratch)).1),
                cycles(clock::time(|| packets::trace::<256, _>(&bvh, token, kind, &rays, &mut scratch)).1),
            ]);
        }
        let verdict: Verdict = verdict::compare(
            triangles, &rays, [&by_embree, &by_us], kind.any_hit(),
            [&|_| (u32::MAX, 0.0), &|_| (u32::MAX, 0.0)],
        );
        let median = |k: usize| {
            let mut v: Vec<f64> = table.iter().map(|r| r[k]).collect();
            v.sort_by(f64::total_cmp);
            v[v.len() / 2]
        };
        let mut ratios: Vec<f64> = table.iter().map(|r| r[0].min(r[2]) / r[1]).collect();
        ratios.sort_by(f64::total_cmp);
        println!(
            "  {:<19} embree {:>6} {:6.1} | mobula 64: {:6.1}  16: {:6.1}  256: {:6.1} | ratio {:.2} / {:.2} / {:.2} | hits {:?} ties {} band {} lost {} {}",
            kind.name(), all[0].1.to_string(), median(0).min(median(2)), median(1), median(3), median(4),
            ratios[0], ratios[ratios.len() / 2], ratios[ratios.len() - 1],
            verdict.hits, verdict.ties, verdict.band, verdict.lost_by_first, verdict.lost_by_second
        );
        println!("      {}", text.join(", "));
        for example in verdict.examples.iter().take(2) {
            println!("      {example}");
        }
    }
}
