//! The plots, drawn by `plotters` as SVG. Their colours are names that the page's style sheet replaces.

use crate::curve::{self, Piece};
use crate::strain::{Edge, Strains};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use rhytid_capture::Report;
use rhytid_core::{Error, Result};

/// The number of units in a pixel of the page: the backend rounds to whole units.
const FINE: u32 = 2;
/// The units of a plot's width, of its axis at the left, and of its margin.
const WIDTH: u32 = 1000 * FINE;
const LEFT: u32 = 52 * FINE;
const MARGIN: u32 = 8 * FINE;

const INK: RGBColor = RGBColor(51, 51, 51);
const GRID: RGBColor = RGBColor(221, 221, 221);
const CURVE: RGBColor = RGBColor(0, 114, 178);
const SHADE: RGBColor = RGBColor(238, 238, 238);

/// A plot over time.
struct Curve {
    height: u32,
    unit: &'static str,
    /// First and last time in seconds.
    span: [f64; 2],
    /// Least and greatest value.
    range: [f64; 2],
    pieces: Vec<Piece>,
    /// Spans of time to shade.
    shaded: Vec<[f64; 2]>,
}

/// The head's residuals in millimetres over time, with gaps where the head was not fitted. `None` if it never
/// was.
pub(crate) fn head(report: &Report) -> Result<Option<String>> {
    let time = |frame: usize| report.start + frame as f64 / report.rate;
    let span = not_empty([time(0), time(report.frames.saturating_sub(1))]);
    let samples = report.head_residuals_mm.iter().enumerate().map(|(frame, &residual)| {
        let fitted = residual > 0.0 && residual.is_finite();
        [time(frame), if fitted { f64::from(residual) } else { f64::NAN }]
    });
    let pieces = curve::thin(samples, span, columns());
    let greatest = pieces.iter().flatten().map(|p| p[1]).fold(0.0, f64::max);
    if greatest == 0.0 {
        return Ok(None);
    }
    let curve = Curve {
        height: 200 * FINE,
        unit: "mm",
        span,
        range: [0.0, greatest * 1.05],
        pieces,
        shaded: Vec::new(),
    };
    curve.draw().map(Some)
}

/// The strain of an edge in per cent over time, on an axis with room for the greatest of `all`. Spans in
/// which an end was not measured are shaded.
pub(crate) fn strain(strains: &Strains, edge: &Edge, all: &[Edge]) -> Result<String> {
    let percent = strains.over_time(edge).map(|[time, strain]| [time, 100.0 * strain]);
    let times = strains.span();
    let span = not_empty(times);
    let pieces = curve::thin(percent, span, columns());
    let least = all.iter().map(|e| 100.0 * e.least).fold(0.0, f64::min);
    let greatest = all.iter().map(|e| 100.0 * e.greatest).fold(0.0, f64::max);
    let room = 0.05 * (greatest - least).max(1.0);
    let column = (span[1] - span[0]) / columns() as f64;
    let shaded = curve::stretches(strains.doubtful(edge), 2.0 * column);
    let range = [least - room, greatest + room];
    Curve { height: 130 * FINE, unit: "%", span, range, pieces, shaded }.draw()
}

/// The markers' offsets from their handles in millimetres, the greatest first. Each is named if there is
/// room. `None` if none is known.
pub(crate) fn offsets(report: &Report) -> Result<Option<String>> {
    let known = report
        .labels
        .iter()
        .zip(&report.setup.offsets_mm)
        .filter_map(|(label, offset)| Some((label, (*offset)?)));
    let mut bars: Vec<(&String, f64)> = known.filter(|(_, offset)| offset.is_finite()).collect();
    bars.sort_by(|a, b| b.1.total_cmp(&a.1));
    let Some(&(_, greatest)) = bars.first() else { return Ok(None) };
    let range = 0.0..(greatest * 1.05).max(1e-3);
    let bar_width = f64::from(WIDTH - LEFT - 2 * MARGIN) / (FINE as usize * bars.len()) as f64;
    // A line of text needs 9 pixels. With narrower bars, only every n-th has its name.
    let step = (9.0 / bar_width).ceil().max(1.0) as usize;
    let size = bar_width.clamp(9.0, 12.0) as u32;
    let names: Vec<String> = bars.iter().map(|(label, _)| shortened(label)).collect();
    let longest = names.iter().map(|name| name.chars().count()).max().unwrap_or(0) as u32;
    let below = (12 + longest * size * 2 / 3) * FINE;
    let svg = draw(200 * FINE + below, |root| {
        let mut chart = ChartBuilder::on(root)
            .margin(MARGIN)
            .y_label_area_size(LEFT)
            .margin_bottom(below)
            .build_cartesian_2d(0.0..bars.len() as f64, range.clone())?;
        let value = |mm: &f64| tick(*mm, &range);
        chart
            .configure_mesh()
            .disable_x_mesh()
            .x_labels(0)
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .axis_style(GRID)
            .label_style(text(12))
            .y_label_formatter(&value)
            .y_labels(6)
            .y_desc("mm")
            .draw()?;
        let bar = |(i, (_, mm)): (usize, &(&String, f64))| {
            Rectangle::new([(i as f64 + 0.1, 0.0), (i as f64 + 0.9, *mm)], CURVE.filled())
        };
        chart.draw_series(bars.iter().enumerate().map(bar))?;
        let style = text(size).transform(FontTransform::Rotate270).pos(Pos::new(HPos::Right, VPos::Center));
        for (i, name) in names.iter().enumerate().step_by(step) {
            let (x, y) = chart.backend_coord(&(i as f64 + 0.5, 0.0));
            root.draw(&Text::new(name.as_str(), (x, y + 5 * FINE as i32), style.clone()))?;
        }
        Ok(())
    })?;
    Ok(Some(svg))
}

/// A label that fits under a bar.
fn shortened(label: &str) -> String {
    const ROOM: usize = 18;
    if label.chars().count() <= ROOM {
        return label.to_owned();
    }
    label.chars().take(ROOM - 1).chain(['…']).collect()
}

impl Curve {
    fn draw(&self) -> Result<String> {
        let [[start, end], [least, greatest]] = [self.span, self.range];
        draw(self.height, |root| {
            let mut chart = ChartBuilder::on(root)
                .margin(MARGIN)
                .x_label_area_size(24 * FINE)
                .y_label_area_size(LEFT)
                .build_cartesian_2d(start..end, least..greatest)?;
            let column = (end - start) / columns() as f64;
            let shade = |s: &[f64; 2]| {
                Rectangle::new([(s[0], least), (s[1].max(s[0] + column), greatest)], SHADE.filled())
            };
            chart.draw_series(self.shaded.iter().map(shade))?;
            let (seconds, value) =
                (|s: &f64| format!("{} s", tick(*s, &(start..end))), |y: &f64| tick(*y, &(least..greatest)));
            chart
                .configure_mesh()
                .bold_line_style(GRID)
                .light_line_style(TRANSPARENT)
                .axis_style(GRID)
                .label_style(text(12))
                .x_label_formatter(&seconds)
                .y_label_formatter(&value)
                .x_labels(12)
                .y_labels(5)
                .y_desc(self.unit)
                .draw()?;
            for piece in &self.pieces {
                let points = piece.iter().map(|&[time, value]| (time, value));
                match piece.as_slice() {
                    [_] => drop(chart.draw_series(points.map(|p| Circle::new(p, 1, CURVE.filled())))?),
                    _ => drop(chart.draw_series(LineSeries::new(points, CURVE))?),
                }
            }
            Ok(())
        })
    }
}

/// The number of the page's pixel columns in which a curve is drawn.
fn columns() -> usize {
    ((WIDTH - LEFT - 2 * MARGIN) / FINE) as usize
}

/// A number on an axis, with enough decimals to tell neighbouring ticks apart.
fn tick(x: f64, range: &std::ops::Range<f64>) -> String {
    let decimals = (1.0 - (range.end - range.start).log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{x:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.replace('-', "−") }
}

fn text(size: u32) -> TextStyle<'static> {
    // The SVG backend divides sizes by 1.24.
    ("sans-serif", f64::from(size * FINE) * 1.24).into_font().color(&INK)
}

/// A span of time that is not empty, for an axis: a take may have one frame.
fn not_empty([start, end]: [f64; 2]) -> [f64; 2] {
    if end > start { [start, end] } else { [start, start + 1.0] }
}

type Root<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type Drawn = std::result::Result<(), DrawingAreaErrorKind<std::io::Error>>;

fn draw(height: u32, on: impl FnOnce(&Root) -> Drawn) -> Result<String> {
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
    on(&root).and_then(|()| root.present()).map_err(|e| Error::Internal(format!("a plot: {e}")))?;
    drop(root);
    Ok(svg)
}
