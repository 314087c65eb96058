//! Mobula beside Embree, and beside other libraries with the feature `peers`: the same rays, one process, one core, turn by
//! turn.
//!
//!     cargo bench -p mobula-benches --features embree --bench peers -- [--scene bunny,terr1m] [--rays primary,ao]
//!         [--level avx512,avx2,sse2] [--repeat 7] [--json FILE] [--record FILE --date YYYY-MM-DD]
//!         [--mesh FILE --eye X,Y,Z --at X,Y,Z --fov D --resolution N] [--list FILE]

mod builds;
mod rows;
mod views;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use mobula_benches::embree::{Device, Quality, Scene};
use mobula_benches::rays::{Found, Kind, RaySet};
use mobula_benches::report::{Report, Row};
use mobula_benches::scenes::{self, Far, Primitives, VIEWS, View};
use mobula_benches::{clock, others, secondary};
use mobula_core::bvh::{Bvh, Serial};
use mobula_core::leaf::Block;
use mobula_core::simd::{AnyToken, Level};

use rows::{ONE, Peers};
use views::ViewOptions;

/// Measures Mobula beside Embree.
#[derive(Debug, Parser)]
struct Arguments {
    /// Scenes by name; all unless named.
    #[arg(long, value_delimiter = ',')]
    scene: Vec<String>,
    #[command(flatten)]
    view: ViewOptions,
    /// A file of further scenes, a line each: --mesh and what goes with it.
    #[arg(long)]
    list: Option<PathBuf>,
    /// Kinds of rays; all unless named, "none" for builds only.
    #[arg(long, value_delimiter = ',')]
    rays: Vec<String>,
    /// Levels; the best unless named.
    #[arg(long, value_delimiter = ',')]
    level: Vec<Level>,
    /// What Embree is limited to; what the level has unless named.
    #[arg(long, value_parser = ["sse2", "sse4.2", "avx", "avx2", "avx512"])]
    isa: Option<String>,
    /// Turns.
    #[arg(long, default_value_t = 7, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=1000))]
    repeat: usize,
    /// Measure building as well.
    #[arg(long)]
    builds: bool,
    /// Folder of the meshes.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data/meshes"))]
    data: PathBuf,
    /// Write everything there as JSON.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Write the tables there as Markdown.
    #[arg(long)]
    record: Option<PathBuf>,
    /// The day that the record names.
    #[arg(long, default_value = "undated")]
    date: String,
    /// What `cargo bench` adds.
    #[arg(long, hide = true)]
    bench: bool,
}

/// Rays in the band, at most one of so many: more are not rounding.
const BAND: usize = 2_000;

fn main() -> ExitCode {
    let mut arguments = Arguments::parse();
    if arguments.level.is_empty() {
        arguments.level.push(AnyToken::detect().level());
    }
    match run(&arguments) {
        Ok(failures) if failures.is_empty() => ExitCode::SUCCESS,
        Ok(failures) => {
            failures.iter().for_each(|failure| eprintln!("wrong: {failure}"));
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<Vec<String>, String> {
    let unknown = |name: &String| format!("{name}: unknown name");
    if let Some(name) = arguments.scene.iter().find(|name| !VIEWS.iter().any(|view| view.name == **name)) {
        return Err(unknown(name));
    }
    let is_kind = |name: &str| name == "none" || Kind::ALL.iter().any(|kind| kind.name() == name);
    if let Some(name) = arguments.rays.iter().find(|name| !is_kind(name)) {
        return Err(unknown(name));
    }
    let frequency = clock::tick_frequency();
    // Without the folders of files: they say nothing to others.
    let short = |argument: String| argument.rsplit_once('/').map_or(argument.clone(), |(_, name)| name.to_owned());
    let given: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").map(short).collect();
    let features = if cfg!(feature = "peers") { "peers" } else { "embree" };
    let mut bench = Bench {
        arguments,
        failures: Vec::new(),
        built: Vec::new(),
        report: Report {
            date: arguments.date.clone(),
            command: format!(
                "cargo bench -p mobula-benches --features {features} --bench peers -- {}",
                given.join(" ")
            ),
            machine: clock::machine(frequency),
            frequency,
            ..Report::default()
        },
    };
    eprintln!("{}", bench.report.machine);
    let mut others = arguments.list.as_deref().map_or(Ok(Vec::new()), views::of_list)?;
    others.extend(arguments.view.mesh.is_some().then(|| arguments.view.clone()));
    arguments.view.check()?;
    let mut names: Vec<String> = VIEWS.iter().map(|view| view.name.to_owned()).collect();
    for options in &others {
        // Rows must be told apart.
        let usual = options.name();
        let numbered = (2..).map(|number| format!("{usual}_{number}"));
        let name = std::iter::once(usual.clone()).chain(numbered).find(|name| !names.contains(name));
        names.extend(name);
        let name = &names[names.len() - 1];
        if let Some((view, primitives)) = options.view(name)? {
            bench.report.notes.push(format!("{name}: {}", options.words()));
            bench.view(&view, &primitives)?;
        }
        bench.write()?;
    }
    let named = !arguments.scene.is_empty() || others.is_empty();
    for view in VIEWS.iter().filter(|view| named && chosen(&arguments.scene, view.name)) {
        match scenes::primitives(view, &arguments.data) {
            Ok(primitives) => bench.view(view, &primitives)?,
            Err(reason) => {
                eprintln!("{}: skipped: {reason}", view.name);
                bench.report.notes.push(format!("{} skipped: {reason}", view.name));
            }
        }
        bench.write()?;
    }
    println!("{}", bench.report.markdown());
    Ok(bench.failures)
}

/// Nothing chosen means everything.
fn chosen(names: &[String], name: &str) -> bool {
    names.is_empty() || names.iter().any(|chosen| chosen == name)
}

struct Bench<'a> {
    arguments: &'a Arguments,
    report: Report,
    failures: Vec<String>,
    /// Of which scenes building was measured: where they come from, and their primitives.
    built: Vec<(&'static str, usize)>,
}

impl Bench<'_> {
    /// Writes what there is so far, so that a run that is stopped is not lost.
    fn write(&self) -> Result<(), String> {
        let write = |file: &Option<PathBuf>, text: String| match file {
            Some(file) => std::fs::write(file, text).map_err(|error| format!("{}: {error}", file.display())),
            None => Ok(()),
        };
        write(&self.arguments.json, format!("{:#}\n", self.report.json()))?;
        write(&self.arguments.record, self.report.markdown())
    }

    /// Notes that something is not as it must be.
    fn wrong(&mut self, failure: String) {
        self.report.notes.push(format!("WRONG: {failure}"));
        self.failures.push(failure);
    }

    fn view(&mut self, view: &View, primitives: &Primitives) -> Result<(), String> {
        // Views of one scene have its primitives.
        let built = (view.source, primitives.len());
        if self.arguments.builds && !self.built.contains(&built) {
            self.built.push(built);
            let level = *self.arguments.level.iter().max().ok_or("no level")?;
            self.report.builds.append(&mut builds::builds(view.name, primitives, level, self.arguments.repeat)?);
        }
        let kinds: Vec<Kind> = Kind::ALL.into_iter().filter(|kind| chosen(&self.arguments.rays, kind.name())).collect();
        if kinds.is_empty() {
            return Ok(());
        }
        let count = primitives.len();
        match primitives {
            Primitives::Triangles(triangles) => {
                self.rows(view, primitives, &kinds, &Bvh::triangles(count, 0, &Serial, |i| triangles.corners(i)))
            }
            Primitives::Spheres(spheres) => {
                self.rows(view, primitives, &kinds, &Bvh::spheres(count, 0, &Serial, |i| spheres[i]))
            }
        }
    }

    fn rows<B: Block>(
        &mut self,
        view: &View,
        primitives: &Primitives,
        kinds: &[Kind],
        bvh: &Bvh<B>,
    ) -> Result<(), String> {
        let primary = RaySet::primary(view);
        let mut hits = Found::new(primary.len());
        let others = others::all(primitives);
        for &level in &self.arguments.level {
            let token = AnyToken::for_level(level).map_err(|error| error.to_string())?;
            let isa = self.arguments.isa.as_deref().unwrap_or(isa(level));
            let device = Device::new(isa, 1)?;
            let embree = Scene::new(&device, primitives, Quality::Medium)?;
            // The rays are the same for all levels.
            if hits.hits(false) == 0 {
                embree.intersect(ONE, &primary, &mut hits);
                self.check_known(view, &hits);
                if hits.hits(false) == 0 {
                    return Err(format!("{}: nothing is seen from there", view.name));
                }
            }
            for &kind in kinds {
                let rays = secondary::rays(kind, view, primitives, &primary, &hits);
                let asked = matches!(kind, Kind::Primary | Kind::ShadowPoint | Kind::Diffuse);
                let others = if asked { &others[..] } else { &[] };
                let (device, embree) = (&device, &embree);
                let peers = Peers { view, primitives, bvh, token, device, isa, embree, others, kind, rays };
                let row = peers.row(self.arguments.repeat, self.report.frequency);
                self.check(view, &row);
                for other in others {
                    let verdict = peers.verdict_of(&**other);
                    if verdict.lost_by_first + verdict.lost_by_second > 0 {
                        self.report.notes.push(format!(
                            "{} {}: {} lost {} hits, Embree {}",
                            view.name,
                            kind.name(),
                            other.name(),
                            verdict.lost_by_second,
                            verdict.lost_by_first
                        ));
                    }
                }
                self.report.rows.push(row);
            }
        }
        Ok(())
    }

    /// Says what was measured, and notes what is wrong with it.
    fn check(&mut self, view: &View, row: &Row) {
        let name = format!("{} {} {}", row.scene, row.level, row.kind.name());
        let cycles: Vec<String> = row
            .mobula
            .iter()
            .map(|way| format!("{} {:6.1} ({:.2})", way.name, way.cycles.median, way.ratio.median))
            .collect();
        let embree = row.embree.first().map_or(0.0, |way| way.cycles.median);
        let verdict = &row.verdict;
        eprintln!("{name:<34} Embree {embree:6.1}  Mobula {}  {:?}", cycles.join("  "), verdict.hits);
        for other in &row.others {
            eprintln!("{:<34} {} {:.1}", "", other.name, other.cycles.median);
        }
        if verdict.lost_by_second > 0 {
            self.wrong(format!("{name}: Mobula lost {} hits: {:?}", verdict.lost_by_second, verdict.examples));
        }
        // Of what is far away, or in views that nobody looked at before, more may be.
        let known = matches!(view.far, Far::Nothing) && VIEWS.iter().any(|fixed| fixed.name == view.name);
        let in_band = || format!("{name}: {} of {} rays in the band", verdict.band, row.rays);
        match verdict.band > (row.rays / BAND).max(16) {
            true if known => self.wrong(in_band()),
            true => self.report.notes.push(in_band()),
            false => {}
        }
        if let (Some(known), Kind::ShadowPoint) = (view.known, row.kind)
            && verdict.hits[0].abs_diff(known.shadowed) > (known.shadowed / 10_000).max(16)
        {
            self.wrong(format!("{name}: {} rays in shadow, not {}", verdict.hits[0], known.shadowed));
        }
    }

    fn check_known(&mut self, view: &View, hits: &Found) {
        let (count, distances) = (hits.hits(false), hits.distances());
        let Some(known) = view.known else { return };
        if count.abs_diff(known.hits) > 8 || (distances / known.distances - 1.0).abs() > 1e-5 {
            let name = view.name;
            self.wrong(format!(
                "{name}: {count} hits, distances {distances:e}, not {known:?}: another scene or camera"
            ));
        }
    }
}

/// What Embree calls the instructions of a level.
fn isa(level: Level) -> &'static str {
    match level {
        Level::Scalar | Level::Sse2 => "sse2",
        Level::Avx2 => "avx2",
        Level::Avx512 => "avx512",
    }
}
