//! `mobula scale`: what more threads buy here, and what more processors would buy.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use mobula::output;
use mobula::pipeline::{DisplayStage, NullDisplay};
use mobula::progress::Progress;
use mobula::sampler::SamplerKind;
use mobula::scale::plot::{Curves, svg};
use mobula::scale::{Costs, Dealt, Measurement, PAPER, PROCESSORS, Plan, Projection, measure, project};
use mobula::traverse::TileSize;
use serde_json::{Value, json};

use super::args::SceneOptions;
use super::failure::Failure;
use super::progress::watch;
use super::{Prepared, prepare, print, print_object, signals, tell};

/// What passing a cache line costs between processors that are far from each other, in seconds.
const FAR: f64 = 100e-9;

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
    pub(crate) tile_size: u32,

    /// How far the eye turns from one frame of the projection to the next, in degrees (0.05: 60 degrees a second at 1200
    /// frames a second): frames are planned by what those before them cost
    #[arg(long, value_name = "DEGREES", default_value_t = 0.05, allow_hyphen_values = true)]
    pub(crate) turn: f32,

    /// Draw speed-up against processors, beside the paper's Figure 8
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) plot: Option<PathBuf>,

    /// Print one JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn scale(options: &ScaleOptions) -> Result<(), Failure> {
    let Prepared { mut pipeline, settings, name, .. } = prepare(&options.scene, false, false, SamplerKind::Single)?;
    pipeline.add_stage(DisplayStage::new().with(0, NullDisplay));
    let tile = TileSize { width: options.tile_size as usize, height: options.tile_size as usize };
    let (rounds, frames) = (options.rounds as usize, options.frames);
    let plan = Plan {
        threads: settings.threads,
        rounds,
        frames,
        size: settings.size,
        tile,
        balancer: settings.balancer,
        turn: options.turn.to_radians(),
    };
    let progress = Progress::default();
    progress.expect(rounds as u64 + 1);
    let mut rounds_done = 0;
    let measured = watch("measuring", &progress, || {
        measure(&mut pipeline, &plan, |round| {
            progress.advance((round - rounds_done) as u64);
            rounds_done = round;
        })
    })?;
    // What is projected from what a busy machine measures is no better than a guess.
    let projected = if measured.is_disturbed() { Vec::new() } else { projections(&measured, &plan) };
    let title = format!(
        "{name}, {}, {}, tiles of {}x{}",
        settings.size, settings.balancer, options.tile_size, options.tile_size
    );
    if let Some(path) = &options.plot {
        let curves = Curves {
            measured: measured.runs.iter().map(|run| (run.threads as f64, run.speedup)).collect(),
            projected: projected.first().into_iter().flat_map(Projected::points).collect(),
            title: title.clone(),
        };
        let problem = |error: &dyn std::fmt::Display| Failure::Output(format!("{}: {error}", path.display()));
        let text = svg(&curves).map_err(|error| problem(&error))?;
        signals::listen();
        output::write(path, |mut file| file.write_all(text.as_bytes())).map_err(|error| problem(&error))?;
        tell!("mobula: wrote {}", path.display());
    }
    if options.json {
        print_object(&to_json(&measured, &projected, &plan))?;
    } else {
        print(&table(&measured, &projected, &plan, &title))?;
    }
    if measured.is_disturbed() {
        return Err(Failure::Output(format!(
            "the machine is busy: arithmetic alone was given {} of the processors, so nothing is projected; stop what else \
             runs, or measure fewer --threads",
            percent(measured.given)
        )));
    }
    Ok(())
}

/// The projection for one cost of passing a cache line, in seconds.
struct Projected {
    handover: f64,
    at: Vec<Projection>,
}

impl Projected {
    fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        self.at.iter().map(|at| (at.processors as f64, at.speedup))
    }
}

/// For each cost of passing a cache line that was seen, and for one between far processors if that is more.
fn projections(measured: &Measurement, plan: &Plan) -> Vec<Projected> {
    let balancer = plan.balancer.build();
    let dealt = Dealt { size: plan.size, tile: plan.tile, balancer: &*balancer };
    let seen = &measured.handovers;
    let far = seen.iter().all(|&handover| handover < FAR).then_some(FAR);
    let with = |handover: f64| {
        let costs = measured.costs.with_handover(handover);
        Projected { handover, at: PROCESSORS.iter().map(|&processors| project(&costs, &dealt, processors)).collect() }
    };
    seen.iter().copied().chain(far).map(with).collect()
}

fn table(measured: &Measurement, projected: &[Projected], plan: &Plan, title: &str) -> String {
    let costs = &measured.costs;
    let mut lines = vec![
        title.to_owned(),
        String::new(),
        "measured; the limits are what so many threads do that have nothing to do with each other".to_owned(),
        format!(
            "{:>10}{:>12}{:>10}{:>12}{:>18}{:>20}{:>12}",
            "threads", "ms/frame", "speed-up", "efficiency", "limit, rendering", "limit, arithmetic", "of limit"
        ),
    ];
    for run in &measured.runs {
        lines.push(format!(
            "{:>10}{:>12.2}{:>10.3}{:>12}{:>18.3}{:>20.3}{:>12}",
            run.threads,
            run.seconds * 1e3,
            run.speedup,
            percent(run.speedup / run.threads as f64),
            run.limit,
            run.arithmetic,
            percent(run.speedup / run.limit),
        ));
    }
    lines.extend([
        String::new(),
        format!("costs of a frame: {}", pieces(costs, plan)),
        format!(
            "barrier of two {:.2} us, serial part {:.2} us, display {:.2} us, hand-over of a cache line {}",
            costs.crossing * 1e6,
            costs.serial * 1e6,
            costs.display * 1e6,
            measured.handovers.iter().map(|&seen| nanoseconds(seen)).collect::<Vec<_>>().join(" or ")
        ),
    ]);
    let Some((first, others)) = projected.split_first() else { return lines.join("\n") };
    let by = |others: &mut dyn Iterator<Item = String>| others.map(|text| format!("{text:>9}")).collect::<String>();
    lines.extend([
        String::new(),
        format!(
            "projected with {} a hand-over; in the last columns the efficiency with others",
            nanoseconds(first.handover)
        ),
        format!(
            "{:>10}{:>10}{:>12}{:>11}{:>9}{:>9}{:>9}{:>10}{:>9}{:>8}{}",
            "processors",
            "speed-up",
            "efficiency",
            "imbalance",
            "cutting",
            "barrier",
            "serial",
            "balancer",
            "single",
            "paper",
            by(&mut others.iter().map(|other| nanoseconds(other.handover)))
        ),
    ]);
    for (row, at) in first.at.iter().enumerate() {
        let lost = at.lost;
        let paper = PAPER.iter().find(|paper| paper.0 == at.processors);
        lines.push(format!(
            "{:>10}{:>10.1}{:>12}{:>11}{:>9}{:>9}{:>9}{:>10}{:>9}{:>8}{}",
            at.processors,
            at.speedup,
            percent(at.efficiency),
            percent(lost.imbalance),
            percent(lost.cutting),
            percent(lost.barrier),
            percent(lost.serial),
            percent(lost.balancer),
            percent(lost.single),
            paper.map_or(String::new(), |paper| format!("{:.0} %", 100.0 * paper.1)),
            by(&mut others.iter().map(|other| percent(other.at[row].efficiency))),
        ));
    }
    lines.join("\n")
}

/// Number, sum and greatest of the tiles of the first frame and of their parts.
fn pieces(costs: &Costs, plan: &Plan) -> String {
    let names = ["tiles", "quarters", "sixteenths"];
    let all = names.iter().zip([1, 2, 4]).map(|(name, cut)| {
        let costs: Vec<f64> = costs.frames[0].of_width((plan.tile.width / cut).max(1)).collect();
        let dearest = costs.iter().copied().fold(0.0, f64::max);
        let sum = costs.iter().sum::<f64>();
        format!("{} {name} {:.1} ms, the dearest {:.0} us", costs.len(), sum * 1e3, dearest * 1e6)
    });
    all.collect::<Vec<_>>().join("; ")
}

fn nanoseconds(seconds: f64) -> String {
    format!("{:.0} ns", seconds * 1e9)
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn to_json(measured: &Measurement, projected: &[Projected], plan: &Plan) -> Value {
    let runs = measured.runs.iter().map(|run| {
        json!({
            "threads": run.threads,
            "seconds": run.seconds,
            "speedup": run.speedup,
            "efficiency": run.speedup / run.threads as f64,
            "machine_limit": run.limit,
            "arithmetic_limit": run.arithmetic,
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
                "cutting": at.lost.cutting,
                "barrier": at.lost.barrier,
                "serial": at.lost.serial,
                "balancer": at.lost.balancer,
                "single": at.lost.single,
            },
        })
    };
    let costs = &measured.costs;
    json!({
        "measured": runs.collect::<Vec<_>>(),
        "given": measured.given,
        "disturbed": measured.is_disturbed(),
        "projected": projected.iter().map(|projected| json!({
            "handover": projected.handover,
            "at": projected.at.iter().map(projection).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "paper": PAPER.map(|(processors, efficiency)| json!({ "processors": processors, "efficiency": efficiency })),
        "costs": {
            "tile_seconds": costs.frames[0].of_width(plan.tile.width).collect::<Vec<_>>(),
            "crossing_of_two": costs.crossing,
            "serial": costs.serial,
            "display": costs.display,
            "handovers": measured.handovers,
        },
        "tile": [plan.tile.width, plan.tile.height],
        "balancer": plan.balancer.to_string(),
        "size": [plan.size.width(), plan.size.height()],
    })
}
