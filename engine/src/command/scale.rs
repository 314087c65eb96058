//! `mobula scale`: what more threads buy here, and what more processors would buy.

use std::path::PathBuf;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use mobula::balance::LoadBalancer;
use mobula::pipeline::{DisplayStage, NullDisplay};
use mobula::scale::measure::take_cost;
use mobula::scale::plot::{Curves, svg};
use mobula::scale::{Growth, Measurement, PAPER, PROCESSORS, Plan, Projection, measure, project};
use mobula::traverse::TileSize;
use serde_json::{Value, json};

use super::args::SceneOptions;
use super::failure::Failure;
use super::{Prepared, prepare, print};

#[derive(Args, Clone, Debug)]
pub(crate) struct ScaleOptions {
    #[command(flatten)]
    pub(crate) scene: SceneOptions,

    /// How often each thread count has its turn
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) rounds: u32,

    /// Frames of a turn
    #[arg(short = 'n', long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub(crate) frames: u64,

    /// Side of a tile in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = TileSize::default().width as u32, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) tile: u32,

    /// Draw speed-up against processors, beside the paper's Figure 8
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) plot: Option<PathBuf>,

    /// Print one JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn scale(options: &ScaleOptions) -> Result<(), Failure> {
    let Prepared { mut pipeline, settings, name } = prepare(&options.scene, false)?;
    pipeline.add_stage(DisplayStage::new().with(0, NullDisplay));
    let tile = TileSize { width: options.tile as usize, height: options.tile as usize };
    let (rounds, frames) = (options.rounds as usize, options.frames);
    let plan =
        Plan { threads: settings.threads, rounds, frames, size: settings.size, tile, balancer: settings.balancer };
    let style = ProgressStyle::with_template("measuring {bar:40} {pos}/{len} rounds, {eta} left");
    let bar = ProgressBar::new(rounds as u64).with_style(style.expect("a valid template"));
    let measured = measure(&mut pipeline, &plan, |round| bar.set_position(round as u64));
    bar.finish_and_clear();
    let measured = measured?;

    let balancer = settings.balancer.build();
    let (linear, tree) = [Growth::Linear, Growth::Logarithmic].map(|growth| all(&measured, &*balancer, growth)).into();
    let title = format!("{name}, {}, {}, tiles of {}x{}", settings.size, settings.balancer, options.tile, options.tile);
    if let Some(path) = &options.plot {
        let curves = Curves {
            measured: measured.runs.iter().map(|run| (run.threads as f64, run.speedup)).collect(),
            projected: linear.iter().map(|at| (at.processors as f64, at.speedup)).collect(),
            title: title.clone(),
        };
        let problem = |error: &dyn std::fmt::Display| Failure::Output(format!("{}: {error}", path.display()));
        std::fs::write(path, svg(&curves).map_err(|error| problem(&error))?).map_err(|error| problem(&error))?;
        eprintln!("mobula: wrote {}", path.display());
    }
    if options.json {
        print(&to_json(&measured, &linear, &tree, &plan));
    } else {
        print(&table(&measured, &linear, &tree, &title));
    }
    Ok(())
}

fn all(measured: &Measurement, balancer: &dyn LoadBalancer, growth: Growth) -> Vec<Projection> {
    let costs = &measured.costs;
    let at = |&processors: &usize| {
        let take = take_cost(balancer, costs.tiles.len(), processors);
        project(costs, balancer, take, growth, processors)
    };
    PROCESSORS.iter().map(at).collect()
}

fn table(measured: &Measurement, linear: &[Projection], tree: &[Projection], title: &str) -> String {
    let costs = &measured.costs;
    let work: f64 = costs.tiles.iter().sum();
    let dearest = costs.tiles.iter().copied().fold(0.0, f64::max);
    let mut lines = vec![
        title.to_owned(),
        String::new(),
        "measured".to_owned(),
        format!("{:>10}{:>12}{:>10}{:>12}{:>16}", "threads", "ms/frame", "speed-up", "efficiency", "machine's limit"),
    ];
    for run in &measured.runs {
        let efficiency = 100.0 * run.speedup / run.threads as f64;
        let (ms, limit) = (run.seconds * 1e3, run.limit);
        lines.push(format!("{:>10}{ms:>12.2}{:>10.2}{efficiency:>10.1} %{limit:>16.2}", run.threads, run.speedup));
    }
    lines.extend([
        String::new(),
        format!(
            "costs: {} tiles, {:.2} ms in all, the dearest {:.1} us;",
            costs.tiles.len(),
            work * 1e3,
            dearest * 1e6
        ),
        format!(
            "barrier of two {:.2} us, serial part {:.2} us, display {:.2} us, hand-over of a cache line {:.0} ns",
            costs.crossing * 1e6,
            costs.serial * 1e6,
            costs.display * 1e6,
            costs.handover * 1e9
        ),
        String::new(),
        "projected; the barrier's cost grows linearly (in the last column with the logarithm)".to_owned(),
        format!(
            "{:>10}{:>10}{:>12}{:>11}{:>9}{:>8}{:>10}{:>9}{:>10}{:>8}",
            "processors",
            "speed-up",
            "efficiency",
            "imbalance",
            "barrier",
            "serial",
            "balancer",
            "display",
            "paper",
            "log"
        ),
    ]);
    for (at, tree) in linear.iter().zip(tree) {
        let lost = at.lost;
        let percent = |share: f64| format!("{:.2} %", 100.0 * share);
        let paper = PAPER.iter().find(|paper| paper.0 == at.processors);
        lines.push(format!(
            "{:>10}{:>10.1}{:>12}{:>11}{:>9}{:>8}{:>10}{:>9}{:>10}{:>8}",
            at.processors,
            at.speedup,
            format!("{:.1} %", 100.0 * at.efficiency),
            percent(lost.imbalance),
            percent(lost.barrier),
            percent(lost.serial),
            percent(lost.balancer),
            percent(lost.display),
            paper.map_or(String::new(), |paper| format!("{:.0} %", 100.0 * paper.1)),
            format!("{:.1} %", 100.0 * tree.efficiency),
        ));
    }
    lines.join("\n")
}

fn to_json(measured: &Measurement, linear: &[Projection], tree: &[Projection], plan: &Plan) -> Value {
    let runs = measured.runs.iter().map(|run| {
        json!({
            "threads": run.threads,
            "seconds": run.seconds,
            "speedup": run.speedup,
            "efficiency": run.speedup / run.threads as f64,
            "machine_limit": run.limit,
        })
    });
    let projection = |at: &Projection| {
        json!({
            "processors": at.processors,
            "seconds": at.seconds,
            "speedup": at.speedup,
            "efficiency": at.efficiency,
            "lost": {
                "imbalance": at.lost.imbalance,
                "barrier": at.lost.barrier,
                "serial": at.lost.serial,
                "balancer": at.lost.balancer,
                "display": at.lost.display,
            },
        })
    };
    let costs = &measured.costs;
    json!({
        "measured": runs.collect::<Vec<_>>(),
        "projected": linear.iter().map(projection).collect::<Vec<_>>(),
        "projected_logarithmic_barrier": tree.iter().map(projection).collect::<Vec<_>>(),
        "paper": PAPER.map(|(processors, efficiency)| json!({ "processors": processors, "efficiency": efficiency })),
        "costs": {
            "tiles": costs.tiles.len(),
            "tile_seconds": costs.tiles,
            "crossing_of_two": costs.crossing,
            "serial": costs.serial,
            "display": costs.display,
            "handover": costs.handover,
        },
        "tile": [plan.tile.width, plan.tile.height],
        "balancer": plan.balancer.to_string(),
        "size": [plan.size.width(), plan.size.height()],
    })
}
