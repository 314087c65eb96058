//! Mobula beside Embree: the same rays, one process, one core, turn by turn.
//!
//!     cargo bench -p mobula-benches --features embree --bench peers -- [--scene bunny,terr1m] [--rays primary,ao]
//!         [--level avx512,avx2,sse2] [--repeat 7] [--json FILE] [--record FILE --date YYYY-MM-DD]

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use mobula_benches::clock::{self, Elapsed};
use mobula_benches::embree::{Device, Entry, Interface, Quality, Scene, Source};
use mobula_benches::packets::{self, Threads};
use mobula_benches::rays::{Found, Kind, RaySet};
use mobula_benches::report::{Build, Report, Row, Spread, Way};
use mobula_benches::scenes::{self, Triangles, VIEWS, View};
use mobula_benches::{secondary, verdict};
use mobula_core::bvh::{self, Bvh, Serial, TriangleBlock};
use mobula_core::simd::{AnyToken, Level};

/// Measures Mobula beside Embree.
#[derive(Debug, Parser)]
struct Arguments {
    /// Scenes by name; all unless named.
    #[arg(long, value_delimiter = ',')]
    scene: Vec<String>,
    /// Kinds of rays; all unless named, "none" for builds only.
    #[arg(long, value_delimiter = ',')]
    rays: Vec<String>,
    /// Levels; the best unless named.
    #[arg(long, value_delimiter = ',')]
    level: Vec<Level>,
    /// Turns.
    #[arg(long, default_value_t = 7)]
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

const ONE: Interface = Interface { entry: Entry::One, coherent: false };
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
    let mut bench = Bench {
        arguments,
        failures: Vec::new(),
        report: Report {
            date: arguments.date.clone(),
            command: format!("cargo bench -p mobula-benches --features embree --bench peers -- {}", given.join(" ")),
            machine: clock::machine(frequency),
            frequency,
            ..Report::default()
        },
    };
    eprintln!("{}", bench.report.machine);
    for view in VIEWS.iter().filter(|view| chosen(&arguments.scene, view.name)) {
        match scenes::triangles(view, &arguments.data) {
            Ok(triangles) => bench.view(view, &triangles)?,
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

    fn view(&mut self, view: &View, triangles: &Triangles) -> Result<(), String> {
        if self.arguments.builds && !self.report.builds.iter().any(|build| build.triangles == triangles.indices.len()) {
            self.builds(view, triangles)?;
        }
        let kinds: Vec<Kind> = Kind::ALL.into_iter().filter(|kind| chosen(&self.arguments.rays, kind.name())).collect();
        if kinds.is_empty() {
            return Ok(());
        }
        let bvh = build(triangles, &Serial);
        let primary = RaySet::primary(view);
        let mut hits = Found::new(primary.len());
        for &level in &self.arguments.level {
            let token = AnyToken::for_level(level).map_err(|error| error.to_string())?;
            let (device, isa) = device(level, 1)?;
            let embree = Scene::new(&device, Source::Triangles(triangles), Quality::Medium)?;
            // The rays are the same for all levels.
            if hits.hits(false) == 0 {
                embree.intersect(ONE, &primary, &mut hits);
                self.check_known(view, &hits);
            }
            for &kind in &kinds {
                let rays = secondary::rays(kind, view, triangles, &primary, &hits);
                let peers = Peers { view, triangles, bvh: &bvh, token, device: &device, embree: &embree, kind, rays };
                let mut row = peers.measure(self.arguments.repeat, self.report.frequency);
                row.isa = isa.into();
                let (ratio, verdict) = (row.ratio, &row.verdict);
                let best = |ways: &[Way], at: usize| ways.get(at).map_or(0.0, |way| way.cycles.median);
                eprintln!(
                    "{:<11} {level:<6} {:<18} Embree {:6.1} Mobula {:6.1}  ratio {:.2} / {:.2} / {:.2}  {:?}",
                    view.name,
                    kind.name(),
                    best(&row.embree, 0),
                    best(&row.mobula, 1),
                    ratio.min,
                    ratio.median,
                    ratio.max,
                    verdict.hits
                );
                let name = format!("{} {level} {}", view.name, kind.name());
                let mut failures = Vec::new();
                if verdict.lost_by_second > 0 {
                    failures
                        .push(format!("{name}: Mobula lost {} hits: {:?}", verdict.lost_by_second, verdict.examples));
                }
                if verdict.band > (row.rays / BAND).max(16) {
                    failures.push(format!("{name}: {} of {} rays in the band", verdict.band, row.rays));
                }
                if let (Some(known), Kind::ShadowPoint) = (view.known, kind)
                    && verdict.hits[0].abs_diff(known.shadowed) > 16
                {
                    failures.push(format!("{name}: {} rays in shadow, not {}", verdict.hits[0], known.shadowed));
                }
                failures.into_iter().for_each(|failure| self.wrong(failure));
                self.report.rows.push(row);
            }
        }
        Ok(())
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

    /// Builds and refits with one and two threads, turn by turn.
    fn builds(&mut self, view: &View, triangles: &Triangles) -> Result<(), String> {
        let level = *self.arguments.level.iter().max().ok_or("no level")?;
        let count = triangles.indices.len();
        let turns = if count > 5_000_000 { 1 } else { self.arguments.repeat.clamp(1, 5) };
        let mut table = Builders { scene: view.name, triangles: count, rows: Vec::new() };
        let corners = |i: usize| triangles.corners(i);
        for _ in 0..turns {
            for threads in [1, 2] {
                table.least("compute loop", threads, || spin(threads));
                let join = Threads::new(threads);
                for (name, quality) in [("Mobula fast", bvh::Quality::Fast), ("Mobula", bvh::Quality::Good)] {
                    let mut tree = None;
                    let build = || tree = Some(Bvh::<TriangleBlock>::build(count, 0, quality, &join, corners));
                    table.least(name, threads, build);
                    let mut tree = tree.ok_or("no tree")?;
                    table.bytes(name, tree.bytes());
                    if quality == bvh::Quality::Good {
                        let bounds = tree.bounds();
                        table.least("Mobula refit", threads, || tree.refit(&join, corners));
                        table.bytes("Mobula refit", tree.bytes());
                        if tree.bounds().low[..3] != bounds.low[..3] || tree.bounds().high[..3] != bounds.high[..3] {
                            self.failures.push(format!("{}: a refit changes bounds", view.name));
                        }
                    }
                }
                // One device at a time: they share their threads, and the later one decides how many.
                let device = device(level, threads)?.0;
                for quality in [Quality::Low, Quality::Medium, Quality::High, Quality::Refit] {
                    if quality == Quality::High && count > 2_000_000 {
                        continue;
                    }
                    let name = format!("Embree {}", quality.name());
                    let mut scene = None;
                    let mut build = || scene = Some(Scene::new(&device, Source::Triangles(triangles), quality));
                    if quality == Quality::Refit {
                        build();
                        let mut scene = scene.ok_or("no scene")??;
                        scene.refit();
                        table.least(&name, threads, || scene.refit());
                        table.bytes(&name, scene.bytes());
                    } else {
                        table.least(&name, threads, build);
                        table.bytes(&name, scene.ok_or("no scene")??.bytes());
                    }
                }
            }
        }
        for row in &table.rows {
            eprintln!(
                "{:<11} build {:<14} {:.4} s, two threads {:.4} s",
                view.name, row.builder, row.one_wall, row.two_wall
            );
        }
        self.report.builds.append(&mut table.rows);
        Ok(())
    }
}

/// Rows of the table of builds: the least of all turns.
struct Builders {
    scene: &'static str,
    triangles: usize,
    rows: Vec<Build>,
}

impl Builders {
    fn row(&mut self, builder: &str) -> &mut Build {
        let at = self.rows.iter().position(|row| row.builder == builder).unwrap_or_else(|| {
            self.rows.push(Build {
                scene: self.scene.into(),
                triangles: self.triangles,
                builder: builder.into(),
                one: f64::INFINITY,
                one_wall: f64::INFINITY,
                two_wall: f64::INFINITY,
                bytes: 0,
            });
            self.rows.len() - 1
        });
        &mut self.rows[at]
    }

    fn least(&mut self, builder: &str, threads: usize, work: impl FnOnce()) {
        let ((), time) = clock::time(work);
        let row = self.row(builder);
        if threads == 1 {
            row.one = row.one.min(time.process);
            row.one_wall = row.one_wall.min(time.wall);
        } else {
            row.two_wall = row.two_wall.min(time.wall);
        }
    }

    fn bytes(&mut self, builder: &str, bytes: usize) {
        self.row(builder).bytes = bytes;
    }
}

/// The same work for one thread or two: what the machine itself gains from the second.
fn spin(threads: usize) {
    let run = |share: u64| {
        let mut x = [1.0f64, 2.0, 3.0, 4.0];
        for i in 0..share {
            x.iter_mut().for_each(|x| *x = *x * 0.999 + i as f64 * 1e-9);
        }
        std::hint::black_box(x);
    };
    let share = 8_000_000 / threads as u64;
    std::thread::scope(|scope| {
        (1..threads).for_each(|_| drop(scope.spawn(move || run(share))));
        run(share);
    });
}

fn build(triangles: &Triangles, join: &impl mobula_core::bvh::Join) -> Bvh<TriangleBlock> {
    Bvh::triangles(triangles.indices.len(), 0, join, |i| triangles.corners(i))
}

/// Embree with the instructions that a level has, and their name.
fn device(level: Level, threads: usize) -> Result<(Device, &'static str), String> {
    let isa = match level {
        Level::Scalar | Level::Sse2 => "sse2",
        Level::Avx2 => "avx2",
        Level::Avx512 => "avx512",
    };
    Ok((Device::new(isa, threads)?, isa))
}

/// What one row compares.
struct Peers<'a> {
    view: &'a View,
    triangles: &'a Triangles,
    bvh: &'a Bvh<TriangleBlock>,
    token: AnyToken,
    device: &'a Device,
    embree: &'a Scene<'a>,
    kind: Kind,
    rays: RaySet,
}

impl Peers<'_> {
    fn by_embree(&self, interface: Interface, rays: &RaySet, found: &mut Found) {
        if self.kind.any_hit() {
            self.embree.occluded(interface, rays, found);
        } else {
            self.embree.intersect(interface, rays, found);
        }
    }

    fn by_mobula<const N: usize>(&self, found: &mut Found) {
        packets::trace::<N, _>(self.bvh, self.token, self.kind, &self.rays, found);
    }

    fn measure(&self, repeat: usize, frequency: f64) -> Row {
        let count = self.rays.len();
        let cycles = |time: Elapsed| time.thread * frequency / count.max(1) as f64;
        let mut found = Found::new(count);
        let mut tried: Vec<(Interface, f64)> = Interface::all()
            .filter(|&interface| self.device.is_native(interface))
            .map(|interface| (interface, cycles(clock::time(|| self.by_embree(interface, &self.rays, &mut found)).1)))
            .collect();
        tried.sort_by(|a, b| a.1.total_cmp(&b.1));
        // Those that one trial cannot tell from the best.
        let close = tried.iter().filter(|(_, cycles)| *cycles < 1.25 * tried[0].1).take(3);
        let candidates: Vec<Interface> = close.map(|&(interface, _)| interface).collect();
        let mut by_embree: Vec<Vec<f64>> = vec![Vec::new(); candidates.len()];
        let mut by_mobula: [Vec<f64>; 3] = Default::default();
        for _ in 0..repeat {
            by_mobula[1].push(cycles(clock::time(|| self.by_mobula::<64>(&mut found)).1));
            for (times, &interface) in by_embree.iter_mut().zip(&candidates) {
                times.push(cycles(clock::time(|| self.by_embree(interface, &self.rays, &mut found)).1));
            }
            by_mobula[0].push(cycles(clock::time(|| self.by_mobula::<16>(&mut found)).1));
            by_mobula[2].push(cycles(clock::time(|| self.by_mobula::<256>(&mut found)).1));
        }
        let mut embree: Vec<(Way, &Vec<f64>)> = candidates
            .iter()
            .zip(&by_embree)
            .map(|(name, times)| (Way { name: name.to_string(), cycles: Spread::of(times.iter().copied()) }, times))
            .collect();
        embree.sort_by(|a, b| a.0.cycles.median.total_cmp(&b.0.cycles.median));
        let ratio = match embree.first() {
            Some((_, times)) => Spread::of(times.iter().zip(&by_mobula[1]).map(|(embree, mobula)| embree / mobula)),
            None => Spread::default(),
        };
        let mobula = [16, 64, 256].iter().zip(&by_mobula);
        Row {
            scene: self.view.name.into(),
            triangles: self.triangles.indices.len(),
            level: self.token.level().to_string(),
            isa: String::new(),
            kind: self.kind.name(),
            rays: count,
            mobula: mobula
                .map(|(width, times)| Way { name: width.to_string(), cycles: Spread::of(times.iter().copied()) })
                .collect(),
            embree: embree.into_iter().map(|(way, _)| way).collect(),
            tried: tried.iter().map(|(interface, cycles)| (interface.to_string(), *cycles)).collect(),
            others: Vec::new(),
            ratio,
            verdict: self.verdict(),
        }
    }

    /// Compares Embree's single rays with Mobula's packets of 64, and these with its other widths, which must agree.
    fn verdict(&self) -> verdict::Verdict {
        let mut found = [(); 4].map(|()| Found::new(self.rays.len()));
        let [embree, ours, narrow, wide] = &mut found;
        self.by_embree(ONE, &self.rays, embree);
        self.by_mobula::<64>(ours);
        self.by_mobula::<16>(narrow);
        self.by_mobula::<256>(wide);
        for other in [&*narrow, &*wide] {
            let same =
                |i: usize| ours.t[i].to_bits() == other.t[i].to_bits() && ours.primitive[i] == other.primitive[i];
            let different = (0..self.rays.len()).filter(|&i| !same(i)).count();
            assert!(different == 0, "{} {}: widths differ in {different} rays", self.view.name, self.kind.name());
        }
        let one = |i: usize| {
            let ((origin, direction), mut ray) = (self.rays.ray(i), RaySet::default());
            ray.push(origin, direction, self.rays.t_max[i]);
            (ray, Found::new(1))
        };
        let embree_blocker = |i: usize| {
            let (ray, mut found) = one(i);
            self.embree.intersect(ONE, &ray, &mut found);
            (found.primitive[0], found.t[0])
        };
        let our_blocker = |i: usize| {
            let (ray, mut found) = one(i);
            packets::trace::<1, _>(self.bvh, self.token, Kind::Diffuse, &ray, &mut found);
            (found.primitive[0], found.t[0])
        };
        let blockers: [verdict::Blocker<'_>; 2] = [&embree_blocker, &our_blocker];
        verdict::compare(self.triangles, &self.rays, [embree, ours], self.kind.any_hit(), blockers)
    }
}
