//! The plot: speed-up against processors, like the paper's Figure 8.

use plotters::prelude::*;

use super::PAPER;

type Problem = Box<dyn std::error::Error>;

/// Points to draw: processors and speed-up.
#[derive(Clone, Debug, Default)]
pub struct Curves {
    /// What was measured.
    pub measured: Vec<(f64, f64)>,
    /// What was projected.
    pub projected: Vec<(f64, f64)>,
    /// What the picture is of.
    pub title: String,
}

/// Draws an SVG.
///
/// # Errors
/// If the drawing library refuses.
pub fn svg(curves: &Curves) -> Result<String, Problem> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (800, 600)).into_drawing_area();
        root.fill(&WHITE)?;
        let points = curves.projected.iter().chain(&curves.measured);
        let most = points.map(|point| point.0.max(point.1)).fold(128.0, f64::max);
        let mut chart = ChartBuilder::on(&root)
            .caption(&curves.title, ("sans-serif", 20))
            .margin(16)
            .x_label_area_size(44)
            .y_label_area_size(56)
            .build_cartesian_2d(0.0..most, 0.0..most)?;
        chart.configure_mesh().x_desc("processors").y_desc("speed-up").light_line_style(WHITE).draw()?;
        let key = |style: RGBColor| move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], style.stroke_width(2));
        let ideal = RGBColor(160, 160, 160);
        chart.draw_series(LineSeries::new([(0.0, 0.0), (most, most)], ideal))?.label("linear").legend(key(ideal));
        chart
            .draw_series(LineSeries::new(curves.projected.iter().copied(), BLUE.stroke_width(2)))?
            .label("Mobula, projected")
            .legend(key(BLUE));
        chart.draw_series(curves.projected.iter().map(|&point| Circle::new(point, 3, BLUE.filled())))?;
        chart
            .draw_series(curves.measured.iter().map(|&point| Circle::new(point, 5, BLACK)))?
            .label("Mobula, measured")
            .legend(|(x, y)| Circle::new((x + 9, y), 5, BLACK));
        let paper = PAPER.map(|(processors, efficiency)| (processors as f64, processors as f64 * efficiency));
        chart
            .draw_series(paper.map(|point| TriangleMarker::new(point, 6, RED.filled())))?
            .label("Manta, Figure 8 of the paper")
            .legend(|(x, y)| TriangleMarker::new((x + 9, y), 6, RED.filled()));
        let labels = chart.configure_series_labels();
        { labels }.position(SeriesLabelPosition::UpperLeft).border_style(BLACK).background_style(WHITE).draw()?;
        root.present()?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plot_has_both_curves_and_the_paper() {
        let curves = Curves {
            measured: vec![(1.0, 1.0), (2.0, 1.96)],
            projected: vec![(64.0, 63.0), (126.0, 122.0), (512.0, 480.0)],
            title: "a <scene>".into(),
        };
        let text = svg(&curves).unwrap();
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"));
        for part in ["linear", "projected", "measured", "Figure 8", "a &lt;scene&gt;"] {
            assert!(text.contains(part), "{part}");
        }
        assert_eq!(text.matches("<circle").count(), 3 + 2 + 1, "the points, and one in the key");
    }
}
