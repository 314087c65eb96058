//! `mobula kernels`: the matrix of kernel, special case, level and packet width, measured here and now.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use mobula_core::lab::{Entry, KERNELS, Plan, Row, WIDTHS, filtered};
use mobula_core::simd::{AnyToken, Level, clock};
use plotters::coord::Shift;
use plotters::prelude::*;

use crate::output;

mobula_core::traversals! { static TRAVERSALS; }

/// All kernels, then whole traversals.
#[must_use]
pub fn registry() -> Vec<Entry> {
    [KERNELS, TRAVERSALS].concat()
}

/// What `mobula kernels` may be told.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Options {
    /// Only kernels and special cases with this in `KERNEL CASE`, as in `triangle common`
    #[arg(long, value_name = "TEXT")]
    pub filter: Option<String>,
    /// Only this level; may be given more than once
    #[arg(long, visible_alias = "isa", value_name = "LEVEL")]
    pub level: Vec<Level>,
    /// Only this packet width; may be given more than once
    #[arg(long, visible_alias = "packet", value_name = "N", value_parser = width)]
    pub width: Vec<usize>,
    /// One JSON array on standard output
    #[arg(long, conflicts_with = "csv")]
    pub json: bool,
    /// Comma-separated values on standard output
    #[arg(long)]
    pub csv: bool,
    /// Draw speed-ups and cycles over packet widths as SVG files in this folder
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    /// Samples a row, of which the fastest counts
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u32).range(1..))]
    pub samples: u32,
}

fn width(text: &str) -> Result<usize, String> {
    let width = text.parse().ok().filter(|width| WIDTHS.contains(width));
    width.ok_or_else(|| format!("kernels are compiled for widths {WIDTHS:?}"))
}

/// A row of the matrix with what it is compared to.
#[derive(Clone, Debug)]
pub struct Measured {
    /// What was measured.
    pub row: Row,
    /// Nanoseconds per test.
    pub ns: f64,
    /// How much faster than the general path at the same level and width.
    pub vs_general: f64,
    /// How much faster than the same path at the scalar level and the same width.
    pub vs_scalar: f64,
}

/// Measures what `options` ask for and calls `each` with every row as it is there.
///
/// # Errors
/// What `each` returns.
pub fn measure(options: &Options, each: &mut dyn FnMut(&Measured) -> io::Result<()>) -> io::Result<Vec<Measured>> {
    let plan = Plan { samples: options.samples as usize, ..Plan::default() };
    let per_tick = nanoseconds_per_tick();
    let kernels = registry();
    let mut bench = Bench { plan, rows: BTreeMap::new() };
    let mut all = Vec::new();
    for entry in filtered(&kernels, options.filter.as_deref().unwrap_or("")) {
        let general = kernels.iter().find(|other| other.is_general_of(entry)).unwrap_or(entry);
        for token in AnyToken::available() {
            if !options.level.is_empty() && !options.level.contains(&token.level()) {
                continue;
            }
            for &width in WIDTHS.iter().filter(|w| options.width.is_empty() || options.width.contains(w)) {
                let row = bench.row(entry, token, width);
                let measured = Measured {
                    ns: row.ticks * per_tick,
                    vs_general: bench.row(general, token, width).cycles / row.cycles,
                    vs_scalar: bench.row(entry, scalar(), width).cycles / row.cycles,
                    row,
                };
                each(&measured)?;
                all.push(measured);
            }
        }
    }
    Ok(all)
}

/// Measures, prints as asked for to `out`, draws as asked for. Returns whether every row was right.
///
/// # Errors
/// If `out` or the folder of plots cannot be written.
pub fn run(options: &Options, out: &mut dyn Write) -> io::Result<bool> {
    if let Some(unavailable) = options.level.iter().find_map(|&level| AnyToken::for_level(level).err()) {
        return Err(io::Error::other(unavailable));
    }
    let filter = options.filter.as_deref().unwrap_or("");
    let kernels = registry();
    if filtered(&kernels, filter).is_empty() {
        let mut known: Vec<&str> = kernels.iter().map(|entry| entry.kernel).collect();
        known.dedup();
        let text =
            format!("no kernel or special case has {filter:?} in its name; the kernels are {}", known.join(", "));
        return Err(io::Error::other(text));
    }
    let table = !options.json && !options.csv;
    if options.csv {
        writeln!(out, "{}", CSV.join(","))?;
    } else if table {
        writeln!(out, "{}", head())?;
    }
    let all = measure(options, &mut |measured| {
        if options.csv {
            writeln!(out, "{}", csv(measured))
        } else if table {
            writeln!(out, "{}", line(measured))
        } else {
            Ok(())
        }
    })?;
    if options.json {
        writeln!(out, "{}", serde_json::Value::from_iter(all.iter().map(json)))?;
    }
    out.flush()?;
    if let Some(folder) = &options.plot {
        plot(&all, folder)?;
    }
    Ok(all.iter().all(|measured| measured.row.correct))
}

/// Rows measured so far: those that others are compared to are needed more than once.
struct Bench {
    plan: Plan,
    rows: BTreeMap<(&'static str, &'static str, Level, usize), Row>,
}

impl Bench {
    fn row(&mut self, entry: &Entry, token: AnyToken, width: usize) -> Row {
        let measure = || entry.measure(token, width, self.plan);
        self.rows.entry((entry.kernel, entry.case, token.level(), width)).or_insert_with(measure).clone()
    }
}

fn scalar() -> AnyToken {
    AnyToken::Scalar(mobula_core::simd::Scalar::new())
}

/// The rate of the clock that kernels are timed with.
fn nanoseconds_per_tick() -> f64 {
    let (start, ticks) = (Instant::now(), clock::ticks());
    while start.elapsed() < Duration::from_millis(30) {
        std::hint::spin_loop();
    }
    start.elapsed().as_nanos() as f64 / clock::ticks().saturating_sub(ticks).max(1) as f64
}

fn head() -> String {
    format!(
        "{:<10} {:<28} {:<7} {:>5} {:>9} {:>8} {:>8} {:>9} {:>10} {:>9}  right",
        "kernel", "case", "level", "width", "ns", "TSC", "cycles", "Mtests/s", "vs general", "vs scalar"
    )
}

fn line(Measured { row, ns, vs_general, vs_scalar }: &Measured) -> String {
    let tick = if row.correct { "ok" } else { "WRONG" };
    format!(
        "{:<10} {:<28} {:<7} {:>5} {:>9.3} {:>8.2} {:>8.2} {:>9.0} {:>10.2} {:>9.2}  {tick}",
        row.kernel,
        row.case,
        row.level,
        row.width,
        ns,
        row.ticks,
        row.cycles,
        1e3 / ns,
        vs_general,
        vs_scalar
    )
}

const CSV: [&str; 11] = [
    "kernel",
    "case",
    "level",
    "width",
    "ns_per_test",
    "cycles_per_test",
    "core_cycles_per_test",
    "mtests_per_second",
    "speedup_vs_general",
    "speedup_vs_scalar",
    "correct",
];

fn csv(Measured { row, ns, vs_general, vs_scalar }: &Measured) -> String {
    let mut text = String::new();
    // Cannot fail: it is a string.
    let _ = write!(text, "{},{},{},{},{ns},{},{},", row.kernel, row.case, row.level, row.width, row.ticks, row.cycles);
    let _ = write!(text, "{},{vs_general},{vs_scalar},{}", 1e3 / ns, row.correct);
    text
}

/// The keys are a contract. `cycles_per_test` counts the time stamp counter, `core_cycles_per_test` the core's own clock.
fn json(Measured { row, ns, vs_general, vs_scalar }: &Measured) -> serde_json::Value {
    serde_json::json!({
        "kernel": row.kernel,
        "case": row.case,
        "level": row.level.name(),
        "width": row.width,
        "ns_per_test": ns,
        "cycles_per_test": row.ticks,
        "core_cycles_per_test": row.cycles,
        "mtests_per_second": 1e3 / ns,
        "speedup_vs_general": vs_general,
        "speedup_vs_scalar": vs_scalar,
        "correct": row.correct,
    })
}

/// Curves over the packet width: what each special case costs at a level, and how much faster each level is.
fn plot(all: &[Measured], folder: &Path) -> io::Result<()> {
    let named = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", folder.display()));
    std::fs::create_dir_all(folder).map_err(named)?;
    let mut charts: BTreeMap<String, Chart> = BTreeMap::new();
    for Measured { row, vs_scalar, .. } in all {
        let (kernel, case, level) = (row.kernel, row.case, row.level);
        let cost = charts.entry(format!("{kernel}-{level}-cycles")).or_default();
        cost.title = format!("{kernel} at {level}: core cycles per test");
        cost.lines.entry(case.to_owned()).or_default().push((row.width, row.cycles));
        let gain = charts.entry(format!("{kernel}-{case}-speedup")).or_default();
        gain.title = format!("{kernel} {case}: speed-up over scalar");
        gain.lines.entry(level.to_string()).or_default().push((row.width, *vs_scalar));
    }
    for (name, chart) in charts {
        let path = folder.join(name + ".svg");
        let text = chart.draw().map_err(|error| io::Error::other(format!("{}: {error}", path.display())))?;
        let named = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
        output::write(&path, |mut file| file.write_all(text.as_bytes())).map_err(named)?;
    }
    Ok(())
}

#[derive(Default)]
struct Chart {
    title: String,
    lines: BTreeMap<String, Vec<(usize, f64)>>,
}

impl Chart {
    fn draw(&self) -> Result<String, Box<dyn std::error::Error>> {
        let mut text = String::new();
        self.draw_to(&SVGBackend::with_string(&mut text, (800, 500)).into_drawing_area())?;
        Ok(text)
    }

    fn draw_to(&self, root: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), Box<dyn std::error::Error>> {
        root.fill(&WHITE)?;
        let values = || self.lines.values().flatten().map(|&(_, y)| y);
        let (least, greatest) = (values().fold(f64::MAX, f64::min), values().fold(f64::MIN_POSITIVE, f64::max));
        let mut chart = ChartBuilder::on(root)
            .caption(&self.title, ("sans-serif", 20))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(50)
            .build_cartesian_2d(
                (1f64..256.0).log_scale().base(2.0),
                (least.min(greatest) / 1.2..greatest * 1.2).log_scale().base(2.0),
            )?;
        chart
            .configure_mesh()
            .x_desc("packet width")
            .x_labels(WIDTHS.len())
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_label_formatter(&|y| format!("{y}"))
            .max_light_lines(0)
            .draw()?;
        for (place, (name, points)) in self.lines.iter().enumerate() {
            let color = Palette99::pick(place).to_rgba();
            let points = points.iter().map(|&(width, y)| (width as f64, y));
            chart
                .draw_series(LineSeries::new(points, color.stroke_width(2)))?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], color.stroke_width(2)));
        }
        // Where the curves are not: cycles fall with the width, speed-ups rise.
        let falls = self.lines.values().any(|points| points.first().map(|p| p.1) > points.last().map(|p| 1.5 * p.1));
        let place = if falls { SeriesLabelPosition::UpperRight } else { SeriesLabelPosition::UpperLeft };
        chart.configure_series_labels().position(place).background_style(WHITE.mix(0.8)).border_style(BLACK).draw()?;
        root.present()?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small() -> Options {
        Options {
            filter: Some("node_d".to_owned()),
            level: vec![Level::Scalar, Level::Sse2],
            width: vec![64, 256],
            samples: 1,
            ..Options::default()
        }
    }

    #[test]
    fn json_has_the_keys_of_the_contract_and_every_row_is_right() {
        let mut out = Vec::new();
        assert!(run(&Options { json: true, ..small() }, &mut out).unwrap());
        let rows: serde_json::Value = serde_json::from_slice(&out).unwrap();
        let rows = rows.as_array().unwrap();
        assert!(!rows.is_empty() && rows.len().is_multiple_of(4), "{}", rows.len());
        for row in rows {
            for key in CSV {
                assert!(!row[key].is_null(), "{key} in {row}");
            }
            assert_eq!(row["correct"], true);
            if row["case"] == "general" {
                assert_eq!(row["speedup_vs_general"], 1.0);
            }
            if row["level"] == "scalar" {
                assert_eq!(row["speedup_vs_scalar"], 1.0);
            }
        }
    }

    #[test]
    fn tables_and_values_have_a_line_a_row() {
        for csv in [false, true] {
            let mut out = Vec::new();
            run(&Options { csv, filter: Some("node_single general".to_owned()), ..small() }, &mut out).unwrap();
            assert_eq!(String::from_utf8(out).unwrap().lines().count(), 1 + 4);
        }
    }

    #[test]
    fn a_filter_that_nothing_matches_is_an_error_that_names_the_kernels() {
        let options = Options { filter: Some("cone".to_owned()), ..small() };
        let error = run(&options, &mut io::sink()).unwrap_err().to_string();
        assert!(error.contains("\"cone\"") && error.contains("triangle, sphere, iso_cell"), "{error}");
    }

    #[test]
    fn plots_are_drawn_and_a_folder_that_cannot_be_made_is_an_error() {
        let folder = std::env::temp_dir().join(format!("mobula-kernels-{}", std::process::id()));
        let options = Options { plot: Some(folder.clone()), filter: Some("node_single general".to_owned()), ..small() };
        run(&options, &mut io::sink()).unwrap();
        let drawn = std::fs::read_dir(&folder).unwrap().count();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(drawn, 3, "two levels, one case");
        let file = std::env::temp_dir().join(format!("mobula-kernels-{}.txt", std::process::id()));
        std::fs::write(&file, "").unwrap();
        let refused = run(&Options { plot: Some(file.join("in")), ..options }, &mut io::sink());
        std::fs::remove_file(&file).unwrap();
        assert!(refused.is_err());
    }
}
