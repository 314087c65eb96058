//! Tables and JSON of what was measured.

use std::fmt::Write;

use serde_json::{Value, json};

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
}

/// One scene, one kind of ray, one level.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the scene.
    pub scene: String,
    /// Number of its triangles.
    pub triangles: usize,
    /// Mobula's level.
    pub level: String,
    /// What Embree was limited to.
    pub isa: String,
    /// Kind of rays.
    pub kind: &'static str,
    /// Number of rays.
    pub rays: usize,
    /// Mobula by packet width; the second is what the ratio is about.
    pub mobula: Vec<Way>,
    /// Embree's interfaces that were repeated, the best first.
    pub embree: Vec<Way>,
    /// Cycles per ray of all of Embree's interfaces, each tried once.
    pub tried: Vec<(String, f64)>,
    /// Further peers.
    pub others: Vec<Way>,
    /// Embree's cycles over Mobula's, turn by turn.
    pub ratio: Spread,
    /// Whether both found the same: the first is Embree.
    pub verdict: Verdict,
}

/// How long building took.
#[derive(Clone, Debug)]
pub struct Build {
    /// Name of the scene.
    pub scene: String,
    /// Number of its triangles.
    pub triangles: usize,
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
            ways.iter().map(|way| json!({"name": way.name, "cycles_per_ray": way.cycles.json()})).collect()
        };
        let rows: Value = self.rows.iter().map(|row| {
            let mrays = |way: Option<&Way>| way.map(|way| self.mrays(way.cycles.median));
            json!({
                "scene": row.scene, "triangles": row.triangles, "level": row.level, "embree_isa": row.isa,
                "rays": row.kind, "count": row.rays, "ratio": row.ratio.json(),
                "mobula": ways(&row.mobula), "embree": ways(&row.embree), "others": ways(&row.others),
                "mobula_mrays_per_second": mrays(row.mobula.get(1)),
                "embree_mrays_per_second": mrays(row.embree.first()),
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
                    "scene": build.scene, "triangles": build.triangles, "builder": build.builder,
                    "seconds_1_thread": build.one, "wall_seconds_1_thread": build.one_wall,
                    "wall_seconds_2_threads": build.two_wall, "bytes": build.bytes,
                })
            })
            .collect();
        let means: Value = self
            .groups()
            .into_iter()
            .map(|(level, kind)| {
                let ratios = self.ratios(&level, kind);
                json!({"level": level, "rays": kind, "geometric_mean": mean(&ratios), "scenes": ratios.len()})
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
        if !self.rows.is_empty() {
            text += "\n## Ratios\n\nEmbree's best cycles per ray over Mobula's (packets of 64), geometric mean over scenes \
                     of the medians; above 1 Mobula is faster.\n\n";
            text += "| level | rays | mean | worst scene | best scene | scenes |\n|---|---|---|---|---|---|\n";
            for (level, kind) in self.groups() {
                let ratios = self.ratios(&level, kind);
                let of = |pick: fn(f64, f64) -> bool| {
                    let found = ratios.iter().fold(None::<&(String, f64)>, |best, next| match best {
                        Some(best) if !pick(next.1, best.1) => Some(best),
                        _ => Some(next),
                    });
                    found.map_or(String::new(), |(name, ratio)| format!("{name} {ratio:.2}"))
                };
                let (worst, best) = (of(|a, b| a < b), of(|a, b| a > b));
                let (mean, count) = (mean(&ratios), ratios.len());
                let _ = writeln!(text, "| {level} | {kind} | **{mean:.2}** | {worst} | {best} | {count} |");
            }
        }
        for (level, kind) in self.groups() {
            self.table(&mut text, &level, kind);
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

    fn table(&self, text: &mut String, level: &str, kind: &str) {
        let rows = || self.rows.iter().filter(|row| row.level == level && row.kind == kind);
        let Some(first) = rows().next() else { return };
        let _ = writeln!(text, "\n## {kind}, {level} (Embree isa={})\n", first.isa);
        *text += "| scene | rays | Embree's best | cycles (Mrays/s) |";
        for way in &first.mobula {
            let _ = write!(text, " Mobula {} |", way.name);
        }
        for way in &first.others {
            let _ = write!(text, " {} |", way.name);
        }
        *text += " ratio min / median / max | ties, band, lost by Embree, by Mobula |\n|---|---|---|---|";
        *text += &"---|".repeat(first.mobula.len() + first.others.len() + 2);
        *text += "\n";
        for row in rows() {
            let Some(embree) = row.embree.first() else { continue };
            let cell = |way: &Way| format!("{:.1} ({:.1})", way.cycles.median, self.mrays(way.cycles.median));
            let _ = write!(text, "| {} | {} | {} | {} |", row.scene, row.rays, embree.name, cell(embree));
            for way in row.mobula.iter().chain(&row.others) {
                let _ = write!(text, " {} |", cell(way));
            }
            let (r, v) = (row.ratio, &row.verdict);
            let _ = writeln!(
                text,
                " {:.2} / **{:.2}** / {:.2} | {}, {}, {}, {} |",
                r.min, r.median, r.max, v.ties, v.band, v.lost_by_first, v.lost_by_second
            );
        }
    }

    fn build_table(&self, text: &mut String) {
        if self.builds.is_empty() {
            return;
        }
        *text += "\n## Building\n\nMilliseconds on the wall with one thread and with two (the least of the repeats), and megabytes \
                  without the triangles that Embree shares. The compute loop is the same work for one thread or two: what \
                  the machine itself gains.\n\n";
        *text += "| scene | triangles | builder | 1 thread | 2 threads | gain | MB |\n";
        *text += "|---|---|---|---|---|---|---|\n";
        for build in &self.builds {
            let _ = writeln!(
                text,
                "| {} | {} | {} | {:.2} | {:.2} | {:.2} | {:.1} |",
                build.scene,
                build.triangles,
                build.builder,
                build.one_wall * 1e3,
                build.two_wall * 1e3,
                build.one_wall / build.two_wall,
                build.bytes as f64 * 1e-6
            );
        }
        *text += "\nMobula's time over Embree's, geometric mean over scenes (the target is 1.00 at most):\n\n";
        *text += "| Mobula | Embree | 1 thread | 2 threads | memory |\n|---|---|---|---|---|\n";
        for (ours, theirs) in
            [("Mobula fast", "Embree low"), ("Mobula", "Embree medium"), ("Mobula refit", "Embree refit")]
        {
            let pairs = self.builds.iter().filter(|build| build.builder == ours).filter_map(|build| {
                let same = |other: &&Build| other.scene == build.scene && other.builder == theirs;
                Some((build, self.builds.iter().find(same)?))
            });
            let pairs: Vec<_> = pairs.collect();
            let of = |value: fn(&Build) -> f64| {
                let ratio = |(a, b): &(&Build, &Build)| (a.scene.clone(), value(a) / value(b));
                mean(&pairs.iter().map(ratio).collect::<Vec<_>>())
            };
            let (one, two, bytes) = (of(|b| b.one_wall), of(|b| b.two_wall), of(|b| b.bytes as f64));
            let _ = writeln!(text, "| {ours} | {theirs} | **{one:.2}** | **{two:.2}** | {bytes:.2} |");
        }
    }

    fn mrays(&self, cycles: f64) -> f64 {
        self.frequency / cycles * 1e-6
    }

    /// Levels and kinds in the order in which they came.
    fn groups(&self) -> Vec<(String, &'static str)> {
        let mut groups: Vec<(String, &'static str)> = Vec::new();
        for row in &self.rows {
            let group = (row.level.clone(), row.kind);
            if !groups.contains(&group) {
                groups.push(group);
            }
        }
        let level = |name: &str| self.rows.iter().position(|row| row.level == name);
        groups.sort_by_key(|(name, _)| level(name));
        groups
    }

    fn ratios(&self, level: &str, kind: &str) -> Vec<(String, f64)> {
        let rows = self.rows.iter().filter(|row| row.level == level && row.kind == kind);
        rows.map(|row| (row.scene.clone(), row.ratio.median)).collect()
    }
}

/// Geometric mean.
fn mean(ratios: &[(String, f64)]) -> f64 {
    (ratios.iter().map(|(_, ratio)| ratio.ln()).sum::<f64>() / ratios.len().max(1) as f64).exp()
}

const EXPLANATION: &str = "\
One process, one thread; every repeat runs Embree's best interfaces (chosen by one trial of each) and Mobula's packet
widths in turn over the same rays, stored as arrays in tile order: load them into the library's structure, query, store the
distance and the triangle. Cycles are thread time multiplied by the frequency of the time stamp counter. Embree 3.13.5,
quality medium, flush-to-zero on for it and not for Mobula, which does not ask for it. 1024x1024 pixels, secondary rays from
every pixel that hits. `shadow-from-light` are the rays of `shadow-point` turned round, so that they share an origin.
Ties are rays for which both found the same distance at different triangles. The band are rays that pass an edge, end at a
surface or lie in a triangle's plane within rounding: either answer stands. Lost are those of which a computation in f64
says that they hit well inside a triangle.
";
