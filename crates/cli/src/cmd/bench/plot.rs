//! The chart of a benchmark, as SVG.

use super::bytes::Stored;
use super::growth::{Point, What};
use super::{BenchReport, DeviceTimes};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use rhytid::core::human;
use rhytid::{Error, Result};

/// The backend rounds to whole units, so a pixel has two units.
const FINE: u32 = 2;
const WIDTH: u32 = 900 * FINE;
const LEFT: i32 = 150 * FINE as i32;
const RIGHT: i32 = 150 * FINE as i32;
const HEADING: u32 = 70 * FINE;
const BAR: u32 = 34 * FINE;
const BELOW: u32 = 40 * FINE;
/// Of the bytes: a heading, a bar for each storage, and the parts' names.
const BYTES: u32 = 70 * FINE + 3 * BAR + 24 * FINE;
const PANEL: u32 = 240 * FINE;

const INK: RGBColor = RGBColor(51, 51, 51);
const GRID: RGBColor = RGBColor(221, 221, 221);
/// Colours of stages and devices that people with any kind of colour vision can tell apart (Okabe and Ito).
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(86, 180, 233),
    RGBColor(213, 94, 0),
    RGBColor(240, 190, 40),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
];
/// The colour of time that belongs to no stage.
const REST: RGBColor = RGBColor(170, 170, 170);

type Root<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = std::result::Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// A bar for each device, made of its stages, and a bar for each storage, made of the parts of its bytes.
/// Below them, if measured, the growth of a frame's time.
///
/// # Errors
/// [`Error::Internal`] if `plotters` fails.
pub(super) fn svg(report: &BenchReport) -> Result<String> {
    let measured: Vec<&DeviceTimes> = report.devices.iter().filter(|d| d.whole.is_some()).collect();
    let bars = HEADING + measured.len() as u32 * BAR + BELOW;
    let grows = measured.iter().any(|device| !device.growth.is_empty());
    let above = bars + BYTES;
    let height = above + if grows { 2 * PANEL + 20 * FINE } else { 0 };
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
    let drawn = root.fill(&WHITE).and_then(|()| {
        let (top, bottom) = root.split_vertically(above);
        let (times, bytes) = top.split_vertically(bars);
        draw_bars(&times, report, &measured)?;
        draw_bytes(&bytes, report)?;
        if grows {
            for (what, panel) in
                What::ALL.into_iter().zip(bottom.margin(0, 20 * FINE, 0, 0).split_evenly((2, 2)))
            {
                draw_growth(&panel, what, &measured)?;
            }
        }
        root.present()
    });
    drawn.map_err(|e| Error::Internal(format!("the chart: {e}")))?;
    drop(root);
    Ok(svg)
}

fn draw_bars(root: &Root, report: &BenchReport, devices: &[&DeviceTimes]) -> Drawn {
    let at = |x: i32, y: u32| (x, y as i32);
    let title = format!(
        "{} vertices, {} handles, {} centres, basis in {}: ms per frame, {}",
        human::count(report.vertices),
        report.handles,
        report.centers,
        report.storage,
        if report.frames == 1 { "one at a time".to_owned() } else { format!("{} at once", report.frames) },
    );
    root.draw(&Text::new(title, at(12 * FINE as i32, 10 * FINE), text(15)))?;
    draw_legend(root, devices)?;
    let longest = devices.iter().filter_map(|d| d.whole.as_ref()).map(|w| w.ms).fold(1e-9, f64::max);
    let width = f64::from(WIDTH as i32 - LEFT - RIGHT);
    let x = |ms: f64| LEFT + (ms / longest * width) as i32;
    for ((i, device), color) in devices.iter().enumerate().zip(colors_of_devices()) {
        let Some(whole) = &device.whole else { continue };
        let (top, bottom) = (HEADING + i as u32 * BAR, HEADING + (i as u32 + 1) * BAR - 10 * FINE);
        let middle = (top + bottom) / 2;
        let left = text(12).pos(Pos::new(HPos::Right, VPos::Center));
        root.draw(&Text::new(device.device.as_str(), at(LEFT - 8 * FINE as i32, middle), left))?;
        if !device.growth.is_empty() {
            root.draw(&Circle::new(at(18 * FINE as i32, middle), 4 * FINE, color.filled()))?;
        }
        root.draw(&Rectangle::new([at(LEFT, top), at(x(whole.ms), bottom)], REST.filled()))?;
        let mut start = 0.0;
        for (stage, color) in device.stages.iter().zip(COLORS) {
            let end = (start + stage.ms).min(whole.ms);
            root.draw(&Rectangle::new([at(x(start), top), at(x(end), bottom)], color.filled()))?;
            start = end;
        }
        // The time that the bytes of a frame take at the memory's speed.
        let least = whole.share_of_bandwidth.map(|share| x(whole.ms * share));
        if let Some(least) = least {
            let mark = [at(least, top - 3 * FINE), at(least, bottom + 3 * FINE)];
            root.draw(&PathElement::new(mark, INK.stroke_width(2 * FINE)))?;
        }
        let right = text(12).pos(Pos::new(HPos::Left, VPos::Center));
        let end = x(whole.ms).max(least.unwrap_or(0)) + 6 * FINE as i32;
        let times = format!("{:.2} ms, {:.0} frames/s", whole.ms, whole.fps);
        root.draw(&Text::new(times, at(end, middle), right))?;
    }
    let note = format!(
        "The mark is what a frame's bytes take at the speed at which this machine's processor reads memory. Rhytid {} ({}).",
        report.version, report.commit
    );
    let y = HEADING + devices.len() as u32 * BAR + 4 * FINE;
    root.draw(&Text::new(note, at(12 * FINE as i32, y), text(11)))
}

/// A bar for each storage.
fn draw_bytes(root: &Root, report: &BenchReport) -> Drawn {
    let at = |x: i32, y: u32| (x, y as i32);
    let title = format!(
        "bytes of a vertex and frame, by part, {}",
        if report.frames == 1 { "one at a time".to_owned() } else { format!("{} at once", report.frames) }
    );
    root.draw(&Text::new(title, at(12 * FINE as i32, 10 * FINE), text(15)))?;
    let names: Vec<&str> = report.bytes[0].parts.iter().map(|part| part.part).collect();
    draw_names(root, &names)?;
    let most = report.bytes.iter().map(Stored::sum).fold(1e-9, f64::max);
    let x = |bytes: f64| LEFT + (bytes / most * f64::from(WIDTH as i32 - LEFT - RIGHT)) as i32;
    for (i, stored) in report.bytes.iter().enumerate() {
        let (top, bottom) = (HEADING + i as u32 * BAR, HEADING + (i as u32 + 1) * BAR - 10 * FINE);
        let middle = (top + bottom) / 2;
        let left = text(12).pos(Pos::new(HPos::Right, VPos::Center));
        root.draw(&Text::new(stored.storage, at(LEFT - 8 * FINE as i32, middle), left))?;
        let mut start = 0.0;
        for (part, color) in stored.parts.iter().zip(COLORS.iter().cycle()) {
            let end = start + part.bytes_per_vertex;
            root.draw(&Rectangle::new([at(x(start), top), at(x(end), bottom)], color.filled()))?;
            start = end;
        }
        let right = text(12).pos(Pos::new(HPos::Left, VPos::Center));
        root.draw(&Text::new(
            format!("{:.0} bytes", stored.sum()),
            at(x(start) + 6 * FINE as i32, middle),
            right,
        ))?;
    }
    Ok(())
}

fn colors_of_devices() -> impl Iterator<Item = &'static RGBColor> {
    COLORS.iter().cycle().skip(1)
}

/// The stages' names beside their colours, if any device times them.
fn draw_legend(root: &Root, devices: &[&DeviceTimes]) -> Drawn {
    let Some(device) = devices.iter().find(|device| !device.stages.is_empty()) else { return Ok(()) };
    let names: Vec<String> = device.stages.iter().map(|stage| stage.stage.replace('_', " ")).collect();
    draw_names(root, &names)
}

/// Names beside their colours, in a row.
fn draw_names<S: AsRef<str>>(root: &Root, names: &[S]) -> Drawn {
    let mut x = 12 * FINE as i32;
    let y = 42 * FINE as i32;
    for (name, color) in names.iter().map(AsRef::as_ref).zip(COLORS.iter().cycle()) {
        let box_ = 10 * FINE as i32;
        root.draw(&Rectangle::new([(x, y - box_ / 2), (x + box_, y + box_ / 2)], color.filled()))?;
        x += box_ + 5 * FINE as i32;
        let width = name.chars().count() as i32 * 7 * FINE as i32;
        root.draw(&Text::new(name, (x, y), text(12).pos(Pos::new(HPos::Left, VPos::Center))))?;
        x += width + 14 * FINE as i32;
    }
    Ok(())
}

/// A chart of time over one size.
///
/// The sizes stand at equal distances, since they grow by nearly equal ratios. Times start at 0. Over
/// vertices the time axis is logarithmic.
fn draw_growth(panel: &Root, what: What, devices: &[&DeviceTimes]) -> Drawn {
    let of = |device: &DeviceTimes| {
        device.growth.iter().filter(|p| p.what == what).cloned().collect::<Vec<Point>>()
    };
    let sizes: Vec<usize> =
        devices.first().map(|d| of(d).iter().map(|p| p.size).collect()).unwrap_or_default();
    let times = || devices.iter().flat_map(|d| of(d)).filter_map(|p| p.ms);
    let (least, most) = times().fold((f64::MAX, f64::MIN), |(a, b), ms| (a.min(ms), b.max(ms)));
    if sizes.len() < 2 || least > most {
        return Ok(());
    }
    let in_powers = what == What::Vertices;
    let range = if in_powers { (least * 0.8).log10()..(most * 1.25).log10() } else { 0.0..most * 1.15 };
    let height = |ms: f64| if in_powers { ms.log10() } else { ms };
    let value = |y: &f64| if in_powers { two_digits(10f64.powf(*y)) } else { format!("{y}") };
    let mut chart = ChartBuilder::on(panel)
        .margin(10 * FINE)
        .margin_right(24 * FINE)
        .x_label_area_size(34 * FINE)
        .y_label_area_size(52 * FINE)
        .build_cartesian_2d(0.0..(sizes.len() - 1) as f64, range)?;
    let size = |x: &f64| {
        let whole = (x - x.round()).abs() < 1e-6;
        if whole { sizes.get(x.round() as usize).map_or(String::new(), |&n| short(n)) } else { String::new() }
    };
    chart
        .configure_mesh()
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .axis_style(GRID)
        .label_style(text(11))
        .x_labels(sizes.len())
        .x_label_formatter(&size)
        .y_labels(6)
        .y_label_formatter(&value)
        .x_desc(what.name())
        .y_desc("ms per frame")
        .draw()?;
    for (device, color) in devices.iter().zip(colors_of_devices()) {
        let points = of(device).into_iter().enumerate();
        let points: Vec<(f64, f64)> = points.filter_map(|(i, p)| Some((i as f64, height(p.ms?)))).collect();
        chart.draw_series(LineSeries::new(points.iter().copied(), color.stroke_width(2 * FINE)))?;
        chart.draw_series(points.iter().map(|&p| Circle::new(p, 3 * FINE, color.filled())))?;
    }
    Ok(())
}

/// 10600 as 11 k.
fn short(n: usize) -> String {
    match n {
        0..10_000 => n.to_string(),
        10_000..1_000_000 => format!("{:.0} k", n as f64 / 1e3),
        _ => format!("{:.1} M", n as f64 / 1e6),
    }
}

/// A time with two significant digits.
fn two_digits(ms: f64) -> String {
    let decimals = (1.0 - ms.log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{ms:.decimals$}")
}

fn text(size: u32) -> TextStyle<'static> {
    // The SVG backend divides sizes by 1.24.
    ("sans-serif", f64::from(size * FINE) * 1.24).into_font().color(&INK)
}
