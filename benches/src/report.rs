//! Tables and JSON of what was measured.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::rays::Kind;
use crate::verdict::Verdict;

/// Least, middle and greatest of some measurements.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spread {
    /// Least.
    pub min: f64,
    /// Median.
    pub median: f64,
    /// Greatest.
    pub max: f64,
}

impl Spread {
    /// Of these; zeros if there are none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let at = |i: usize| values.get(i).copied().unwrap_or_default();
        Self { min: at(0), median: at(values.len() / 2), max: at(values.len().saturating_sub(1)) }
    }

    fn json(self) -> Value {
        json!({"min": self.min, "median": self.median, "max": self.max})
    }
}

/// What one way of tracing took.
#[derive(Clone, Debug)]
pub struct Way {
    /// Packet width or interface.
    pub name: String,
    /// Cycles per ray.
    pub cycles: Spread,
    /// Cycles of Embree's best interface over these, turn by turn.
    pub ratio: Spread,
}

/// One scene, one kind of ray, one level.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the scene.
    pub scene: String,
    /// Triangles or spheres.
    pub shape: &'static str,
    /// How many of them.
    pub primitives: usize,
    /// Mobula's level.
    pub level: String,
    /// What Embree was limited to.
    pub isa: String,
    /// Kind of rays.
    pub kind: Kind,
    /// Number of rays.
    pub rays: usize,
    /// Mobula by packet width; the same widths in all rows.
    pub mobula: Vec<Way>,
    /// Embree's interfaces that were repeated, the best first.
    pub embree: Vec<Way>,
    /// Cycles per ray of all of Embree's interfaces, each tried once.
    pub tried: Vec<(String, f64)>,
    /// Further peers.
    pub others: Vec<Way>,
    /// Whether both found the same: the first is Embree.
    pub verdict: Verdict,
}

/// How long building took.
#[derive(Clone, Debug)]
pub struct Build {
    /// Name of the scene.
    pub scene: String,
    /// Number of its primitives.
    pub primitives: usize,
    /// What they are called.
    pub shape: &'static str,
    /// Who, and how: or the loop that shows what the machine gains from a second thread.
    pub builder: String,
    /// Seconds of processor time with one thread, least: Embree's may run elsewhere than the caller's.
    pub one: f64,
    /// Seconds on the wall with one thread, least.
    pub one_wall: f64,
    /// Seconds on the wall with two threads, least.
    pub two_wall: f64,
    /// Bytes of the result.
    pub bytes: usize,
}

/// Everything of a run.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Day, as the caller says.
    pub date: String,
    /// What was run.
    pub command: String,
    /// On what.
    pub machine: String,
    /// Ticks of the time stamp counter in a second.
    pub frequency: f64,
    /// Traced rays.
    pub rows: Vec<Row>,
    /// Built trees.
    pub builds: Vec<Build>,
    /// What could not be measured, and what is wrong.
    pub notes: Vec<String>,
}

impl Report {
    /// The whole report as one object.
    pub fn json(&self) -> Value {
        let ways = |ways: &[Way]| -> Value {
            let way =
                |way: &Way| json!({"name": way.name, "cycles_per_ray": way.cycles.json(), "ratio": way.ratio.json()});
            ways.iter().map(way).collect()
        };
        let rows: Value = self.rows.iter().map(|row| {
            json!({
                "scene": row.scene, "shape": row.shape, "primitives": row.primitives, "level": row.level, "embree_isa": row.isa,
                "rays": row.kind.name(), "count": row.rays,
                "mobula": ways(&row.mobula), "embree": ways(&row.embree), "others": ways(&row.others),
                "embree_tried": row.tried.iter().map(|(name, cycles)| json!({"name": name, "cycles_per_ray": cycles})).collect::<Value>(),
                "hits": {"embree": row.verdict.hits[0], "mobula": row.verdict.hits[1]},
                "ties": row.verdict.ties, "band": row.verdict.band,
                "lost": {"embree": row.verdict.lost_by_first, "mobula": row.verdict.lost_by_second},
            })
        }).collect();
        let builds: Value = self
            .builds
            .iter()
            .map(|build| {
                json!({
                    "scene": build.scene, "primitives": build.primitives, "shape": build.shape, "builder": build.builder,
                    "seconds_1_thread": build.one, "wall_seconds_1_thread": build.one_wall,
                    "wall_seconds_2_threads": build.two_wall, "bytes": build.bytes,
                })
            })
            .collect();
        let means: Value = self
            .groups()
            .iter()
            .flat_map(|group| group.widths.iter().map(move |width| (group, width)))
            .map(|(group, width)| {
                json!({
                    "level": group.level, "rays": group.kind.name(), "shape": group.shape, "packet": width.name,
                    "geometric_mean": width.mean, "scenes": width.ratios.len(), "is_best_width": width.name == group.best().name,
                })
            })
            .collect();
        json!({
            "date": self.date, "command": self.command, "machine": self.machine, "tsc_hertz": self.frequency,
            "means": means, "rows": rows, "builds": builds, "notes": self.notes,
        })
    }

    /// The whole report for people.
    pub fn markdown(&self) -> String {
        let mut text = format!("# Peers, {}\n\n", self.date);
        let _ = writeln!(text, "- Command: `{}`\n- Machine: {}\n", self.command, self.machine);
        text += EXPLANATION;
        let groups = self.groups();
        if let Some(first) = groups.first() {
            text += RATIOS;
            let widths: Vec<&str> = first.widths.iter().map(|width| width.name.as_str()).collect();
            let _ = writeln!(
                text,
                "| level | rays | target | {} | best width | mean with it | worst scene | best scene | scenes |\n|{}",
                widths.join(" | "),
                "---|".repeat(widths.len() + 8)
            );
        }
        for group in &groups {
            let best = group.best();
            let of = |scene: Option<&(String, f64)>| {
                scene.map_or(String::new(), |(name, ratio)| format!("{name} {ratio:.2}"))
            };
            let means: Vec<String> = group.widths.iter().map(|width| format!("{:.2}", width.mean)).collect();
            let target = group.kind.target().map_or("-".into(), |target| format!("{target:.1}"));
            let _ = writeln!(
                text,
                "| {} | {} | {target} | {} | {} | **{:.2}** | {} | {} | {} |",
                group.level,
                group.title(),
                means.join(" | "),
                best.name,
                best.mean,
                of(best.ratios.first()),
                of(best.ratios.last()),
                best.ratios.len()
            );
        }
        for group in &groups {
            self.table(&mut text, group);
        }
        self.build_table(&mut text);
        if !self.notes.is_empty() {
            text += "\n## Notes\n\n";
            for note in &self.notes {
                let _ = writeln!(text, "- {note}");
            }
        }
        text
    }

    fn table(&self, text: &mut String, group: &Group) {
        let rows = || self.rows.iter().filter(|row| group.has(row));
        let Some(first) = rows().next() else { return };
        let best = group.best();
        let _ = writeln!(text, "\n## {}, {} (Embree isa={})\n", group.title(), group.level, first.isa);
        *text += "| scene | rays | Embree's best | cycles (Mrays/s) |";
        for way in &first.mobula {
            let _ = write!(text, " Mobula {} |", way.name);
        }
        for way in &first.others {
            let _ = write!(text, " {} |", way.name);
        }
        let _ =
            write!(text, " ratio of {}, min / median / max | ties, band, lost by Embree, by Mobula |\n|", best.name);
        *text += &"---|".repeat(first.mobula.len() + first.others.len() + 6);
        *text += "\n";
        for row in rows() {
            let Some(embree) = row.embree.first() else { continue };
            let cell = |way: &Way| format!("{:.1} ({:.1})", way.cycles.median, self.mrays(way.cycles.median));
            let _ = write!(text, "| {} | {} | {} | {} |", row.scene, row.rays, embree.name, cell(embree));
            for way in &row.mobula {
                let _ = write!(text, " {} |", cell(way));
            }
            for Way { name, .. } in &first.others {
                let other = row.others.iter().find(|other| other.name == *name);
                let _ = write!(text, " {} |", other.map_or("-".into(), cell));
            }
            let ratio = row.mobula.iter().find(|way| way.name == best.name).map_or(Spread::default(), |way| way.ratio);
            let v = &row.verdict;
            let _ = writeln!(
                text,
                " {:.2} / **{:.2}** / {:.2} | {}, {}, {}, {} |",
                ratio.min, ratio.median, ratio.max, v.ties, v.band, v.lost_by_first, v.lost_by_second
            );
        }
    }

    fn build_table(&self, text: &mut String) {
        if self.builds.is_empty() {
            return;
        }
        *text += "\n## Building\n\nMilliseconds on the wall with one thread and with two (the least of the repeats), and megabytes \
                  without the primitives that Embree shares. The compute loop is the same work for one thread or two: what \
                  the machine itself gains.\n\n";
        *text += "| scene | primitives | builder | 1 thread | 2 threads | gain | MB |\n";
        *text += "|---|---|---|---|---|---|---|\n";
        for build in &self.builds {
            let _ = writeln!(
                text,
                "| {} | {} | {} | {:.2} | {:.2} | {:.2} | {:.1} |",
                build.scene,
                build.primitives,
                build.builder,
                build.one_wall * 1e3,
                build.two_wall * 1e3,
                build.one_wall / build.two_wall,
                build.bytes as f64 * 1e-6
            );
        }
        *text += "\nMobula's time over Embree's, geometric mean over scenes (the target is 1.00 at most; for spheres, 0.50 of `low`):\n\n";
        *text += "| shape | Mobula | Embree | 1 thread | 2 threads | memory |\n|---|---|---|---|---|---|\n";
        for (shape, ours, theirs) in [
            ("triangles", "Mobula fast", "Embree low"),
            ("triangles", "Mobula", "Embree medium"),
            ("triangles", "Mobula refit", "Embree refit"),
            ("triangles", "engine fast", "Embree low"),
            ("triangles", "engine", "Embree medium"),
            ("triangles", "engine refit", "Embree refit"),
            ("spheres", "Mobula fast", "Embree low"),
            ("spheres", "Mobula", "Embree low"),
            ("spheres", "Mobula", "Embree medium"),
        ] {
            let ours_here = self.builds.iter().filter(|build| build.shape == shape && build.builder == ours);
            let pairs = ours_here.filter_map(|build| {
                let same = |other: &&Build| other.scene == build.scene && other.builder == theirs;
                Some((build, self.builds.iter().find(same)?))
            });
            let pairs: Vec<_> = pairs.collect();
            if pairs.is_empty() {
                continue;
            }
            let of = |value: fn(&Build) -> f64| {
                let ratio = |(a, b): &(&Build, &Build)| (a.scene.clone(), value(a) / value(b));
                mean(&pairs.iter().map(ratio).collect::<Vec<_>>())
            };
            let (one, two, bytes) = (of(|b| b.one_wall), of(|b| b.two_wall), of(|b| b.bytes as f64));
            let _ = writeln!(text, "| {shape} | {ours} | {theirs} | **{one:.2}** | **{two:.2}** | {bytes:.2} |");
        }
    }

    fn mrays(&self, cycles: f64) -> f64 {
        self.frequency / cycles * 1e-6
    }

    /// Rows that are compared, in the order in which they came, a level after the other.
    fn groups(&self) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        for row in &self.rows {
            if !groups.iter().any(|group| group.has(row)) {
                let mut group =
                    Group { level: row.level.clone(), kind: row.kind, shape: row.shape, widths: Vec::new() };
                group.widths = row.mobula.iter().map(|way| self.width(&group, &way.name)).collect();
                groups.push(group);
            }
        }
        groups.sort_by_key(|group| {
            (self.rows.iter().position(|row| row.level == group.level), group.shape != "triangles")
        });
        groups
    }

    fn width(&self, group: &Group, name: &str) -> Width {
        let of = |row: &Row| Some((row.scene.clone(), row.mobula.iter().find(|way| way.name == name)?.ratio.median));
        let mut ratios: Vec<_> = self.rows.iter().filter(|row| group.has(row)).filter_map(of).collect();
        ratios.sort_by(|a, b| a.1.total_cmp(&b.1));
        Width { name: name.into(), mean: mean(&ratios), ratios }
    }
}

/// Rows that are compared: of one level, one kind of ray, one kind of primitive.
struct Group {
    level: String,
    kind: Kind,
    shape: &'static str,
    widths: Vec<Width>,
}

/// A packet width in all scenes of a group.
struct Width {
    name: String,
    mean: f64,
    /// The slowest first.
    ratios: Vec<(String, f64)>,
}

impl Group {
    fn has(&self, row: &Row) -> bool {
        row.level == self.level && row.kind == self.kind && row.shape == self.shape
    }

    fn title(&self) -> String {
        let (kind, shape) = (self.kind.name(), self.shape);
        if shape == "triangles" { kind.into() } else { format!("{kind}, {shape}") }
    }

    /// The width with the best mean.
    fn best(&self) -> &Width {
        self.widths.iter().fold(&self.widths[0], |best, width| if width.mean > best.mean { width } else { best })
    }
}

/// Geometric mean.
fn mean(ratios: &[(String, f64)]) -> f64 {
    (ratios.iter().map(|(_, ratio)| ratio.ln()).sum::<f64>() / ratios.len().max(1) as f64).exp()
}

const EXPLANATION: &str = "\
One process, one thread; every repeat runs Embree's best interfaces (chosen by one trial of each) and Mobula's packet
widths in turn over the same rays, stored as arrays in tile order: load them into the library's structure, query, store the
distance and the triangle. Rays are in the cache, as if they had just been made: 4096 at a time are read before the clock is. Cycles are thread time multiplied by the frequency of the time stamp counter. Embree 3.13.5,
quality medium, flush-to-zero on for it and not for Mobula, which does not ask for it. 1024x1024 pixels if the scene's
name says nothing else, secondary rays from every pixel that hits. `shadow-from-light` are the rays of `shadow-point` turned round, so that they share an origin.
Ties are rays for which both found the same distance (up to 1e-4 of it) at different primitives. The band are rays that pass an
edge or a sphere's rim, end at a surface or lie in a triangle's plane within rounding (an edge: 1e-5 of the triangle; otherwise
4e-6 of the greatest coordinate over the cosine at the hit): either answer stands. Lost are those of which a computation in
f64 says that they hit well inside a primitive.
";

const RATIOS: &str = "
## Ratios

Cycles per ray of Embree's best interface over Mobula's, by packet width: geometric mean over scenes of the medians; above 1 Mobula
is faster. Embree's interface is the best of each scene and kind of ray. Mobula's width is one for a kind of ray at a level, the
best of all scenes together, for a renderer chooses it by what its rays are.

";
