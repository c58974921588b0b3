//! Tests of the page, read with an independent parser, and of its numbers, counted another way.

use super::*;
use rhytid_capture::{Event, Found, Kind, Mark};
use rhytid_core::{NoProgress, Table};
use rhytid_solve::solve;
use rhytid_test_support::changed;
use scraper::{ElementRef, Html, Selector};
use serde_json::Value;
use std::sync::LazyLock;
use tempfile::TempDir;

/// A label that would be markup if it were not escaped.
const NASTY: &str = "<b>&\"x'</b> –é";

pub(crate) static DEMO: LazyLock<(Rig, Take)> = LazyLock::new(|| {
    let mut face = rhytid_demo::face(2_000);
    let mut take = rhytid_demo::performance(&face);
    for labels in [&mut face.handles.labels, &mut take.labels] {
        labels[3] = NASTY.to_owned();
    }
    (solve(&face, &NoProgress).unwrap().rounded().unwrap(), take)
});

pub(crate) fn event(kind: Kind, marker: Option<usize>, first: usize, frames: usize) -> Event {
    Event { kind, marker, other: None, first, frames, distance_mm: None, strain: None, confidence: 0.5 }
}

/// A possible report of a clean-up of the demo's performance at 120 Hz, with the given frames and events.
pub(crate) fn report(frames: usize, events: Vec<Event>) -> Report {
    let labels = DEMO.0.handles().labels.clone();
    let offsets = (0..labels.len()).map(|i| (i != 7).then_some(0.3 + 0.02 * i as f64)).collect();
    Report {
        frames,
        rate: 120.0,
        start: 0.0,
        timecode: Some("01:02:03:04".to_owned()),
        marks: vec![Mark { name: "<b>clap</b>".to_owned(), frame: 12 }],
        setup: Found {
            markers: labels.iter().enumerate().map(|(i, l)| (i != 7).then(|| format!("Actor:{l}"))).collect(),
            subject: None,
            rigid: ["cap_1", "cap_2", "cap_3", "cap_4"].map(String::from).to_vec(),
            unused: vec!["*12".to_owned(), "<script>alert(1)</script>".to_owned()],
            metres_per_unit: 0.001,
            unit_is_guessed: true,
            axes: "+x+z-y".to_owned(),
            axes_are_guessed: true,
            neutral: 10..70,
            neutral_is_found: true,
            neutral_rival: None,
            scale: 0.93,
            in_head_space: false,
            offsets_mm: offsets,
            scales: vec![1.0; 89],
            poses: vec![],
        },
        events,
        head_residuals_mm: (0..frames).map(|i| 0.1 + 0.02 * (i as f32 * 0.05).sin()).collect(),
        noise_mm: 0.139,
        low_pass_hz: None,
        warnings: vec!["The file says nothing of its unit; <i>mm</i> is a guess.".to_owned().into()],
        labels,
    }
}

/// One event of each kind and a few more, some over each other.
pub(crate) fn usual() -> Report {
    let swap = Event { other: Some(12), confidence: 1.0, ..event(Kind::Swap, Some(11), 300, 40) };
    let ghost =
        |marker, first| Event { distance_mm: Some(41.2), ..event(Kind::Outlier, Some(marker), first, 1) };
    let events = vec![
        swap,
        ghost(3, 100),
        ghost(20, 863),
        event(Kind::FilledBefore, Some(5), 50, 30),
        event(Kind::Spline, Some(3), 100, 4),
        event(Kind::Spline, Some(3), 200, 10),
        event(Kind::Model, Some(3), 400, 60),
        event(Kind::Lost, Some(40), 500, 200),
        event(Kind::Model, Some(40), 650, 100),
        event(Kind::NeverSeen, Some(7), 0, 864),
        event(Kind::Left, Some(42), 700, 50),
        event(Kind::Head, None, 600, 24),
        Event { other: Some(14), ..event(Kind::Slide, Some(13), 120, 48) },
        event(Kind::Model, Some(13), 120, 48),
        event(Kind::Dropped, Some(15), 130, 9),
        Event { confidence: 0.8, ..event(Kind::Shuffled, Some(19), 150, 30) },
        event(Kind::Held, Some(16), 140, 60),
        Event { other: Some(18), strain: Some(2.5), ..event(Kind::Strain, Some(17), 500, 30) },
        event(Kind::Step, Some(17), 500, 1),
    ];
    report(864, events)
}

/// The page and the JSON, without pictures.
fn written(report: &Report, take: &Take) -> (String, Value) {
    drawn(report, take, None)
}

/// The page and the JSON with a painter.
pub(crate) fn drawn(report: &Report, take: &Take, painter: Option<&Painter>) -> (String, Value) {
    let dir = TempDir::new().unwrap();
    let dir = dir.path().join("not/yet/there");
    write(Page { folder: &dir, title: "<b>Anna</b>" }, "a <take> & more.c3d", report, take, &DEMO.0, painter)
        .unwrap();
    let read = |name| std::fs::read_to_string(dir.join(name)).unwrap();
    (read("report.html"), serde_json::from_str(&read("report.json")).unwrap())
}

pub(crate) fn select<'a>(page: &'a Html, selector: &str) -> Vec<ElementRef<'a>> {
    page.select(&Selector::parse(selector).unwrap()).collect()
}

pub(crate) fn text(element: &ElementRef) -> String {
    element.text().collect()
}

pub(crate) fn number(element: &ElementRef, name: &str) -> f64 {
    element.attr(name).unwrap().parse().unwrap()
}

#[test]
fn the_page_is_well_formed_and_needs_nothing_else() {
    let (text, _) = written(&usual(), &DEMO.1);
    let page = Html::parse_document(&text);
    assert!(page.errors.is_empty(), "{:?}", page.errors);
    for element in page.root_element().descendent_elements() {
        let name = element.value().name();
        assert!(!["script", "link", "iframe"].contains(&name), "{name}");
        for (attribute, value) in element.value().attrs() {
            let elsewhere = ["src", "href", "action"].contains(&attribute) && !value.starts_with("data:");
            assert!(!elsewhere && !attribute.starts_with("on"), "{name} {attribute}={value}");
        }
    }
    let text = text.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for word in ["http://", "https://", "url(", "@import"] {
        assert!(!text.contains(word), "{word}");
    }
}

#[test]
fn labels_come_through_as_text() {
    let (html, json) = written(&usual(), &DEMO.1);
    let page = Html::parse_document(&html);
    assert_eq!(text(&select(&page, "h1")[0]), "<b>Anna</b>");
    assert!(text(&select(&page, "header p")[0]).contains("a <take> & more.c3d"));
    let labels: Vec<String> = select(&page, ".timeline .marker > th").iter().map(text).collect();
    assert_eq!(labels, DEMO.0.handles().labels);
    let handles: Vec<String> = select(&page, ".mapping td:first-child").iter().map(text).collect();
    assert_eq!(handles, DEMO.0.handles().labels);
    let unused: Vec<String> = select(&page, "code").iter().map(text).collect();
    assert!(unused.contains(&"<script>alert(1)</script>".to_owned()), "{unused:?}");
    assert_eq!(text(&select(&page, ".warnings li")[0]), usual().warnings[0].sentence());
    assert_eq!((&json["labels"][3], &json["title"]), (&NASTY.into(), &"a <take> & more.c3d".into()));
    // In the plots too, shortened to the room that there is.
    let short: String = NASTY.chars().take(17).collect();
    assert!(select(&page, ".plot text").iter().any(|t| text(t).trim().starts_with(&short[..5])));
}

#[test]
fn the_timeline_shows_each_event_where_it_is() {
    let report = usual();
    let page = Html::parse_document(&written(&report, &DEMO.1).0);
    let rows = select(&page, ".timeline tbody tr");
    assert_eq!(rows.len(), 1 + report.labels.len());
    let class = |kind| match kind {
        Kind::Swap => "swap",
        Kind::Shuffled => "shuffled",
        Kind::Outlier => "outlier",
        Kind::FilledBefore => "before",
        Kind::Spline => "spline",
        Kind::Model => "model",
        Kind::Lost => "lost",
        Kind::NeverSeen => "never",
        Kind::Left => "left",
        Kind::Head => "head",
        Kind::Slide => "slide",
        Kind::Dropped => "dropped",
        Kind::Held => "held",
        Kind::Strain => "strain",
        Kind::Step => "step",
    };
    let mut bars = 0;
    for event in &report.events {
        let of = [event.marker.map_or(0, |m| m + 1)].into_iter().chain(event.other.map(|m| m + 1));
        for row in of {
            let selector = Selector::parse(&format!("rect.{}", class(event.kind))).unwrap();
            let begins = |bar: &ElementRef| {
                let (from, frames) = (number(bar, "x") * 0.864, number(bar, "width") * 0.864);
                let last = event.first + 1 == report.frames;
                (from - event.first as f64).abs() < if last { 2.0 } else { 0.01 }
                    && (frames - event.frames as f64).abs() < if event.frames == 1 { 2.0 } else { 0.01 }
            };
            assert!(rows[row].select(&selector).any(|bar| begins(&bar)), "{event:?}");
            bars += 1;
        }
    }
    assert_eq!(select(&page, ".timeline rect").len(), bars);
    let lost = rows[41].select(&Selector::parse(".number").unwrap()).map(|e| text(&e)).collect::<String>();
    assert_eq!(lost, format!("{:.1} %", 100.0 * 250.0 / 864.0));
    let titles: Vec<String> = select(&page, ".timeline title").iter().map(text).collect();
    assert!(titles.contains(&"spline: frames 200 to 209, from 1.667 s".to_owned()), "{titles:?}");
}

#[test]
fn neighbouring_events_of_a_long_take_share_a_bar_and_single_frames_are_seen() {
    let gaps = (0..10_000).map(|i| event(Kind::Spline, Some(0), 14 * i, 3));
    let ghosts = [event(Kind::Outlier, Some(1), 70_000, 1), event(Kind::Outlier, Some(1), 143_999, 1)];
    let report = report(144_000, gaps.chain(ghosts).collect());
    let page = Html::parse_document(&written(&report, &DEMO.1).0);
    assert!(select(&page, "rect.spline").len() < 5);
    let ghosts = select(&page, ".timeline rect.outlier");
    assert_eq!(ghosts.len(), 2);
    assert!(
        ghosts.iter().all(|g| number(g, "width") >= 1.5 && number(g, "x") + number(g, "width") <= 1000.0)
    );
}

#[test]
fn the_summary_counts_each_sample_once() {
    let report = usual();
    let (html, json) = written(&report, &DEMO.1);
    let summary = &json["summary"];
    let (mut measured, mut filled, mut corrected, mut lost) = (0, 0, 0, 0);
    for marker in 0..report.labels.len() {
        for frame in 0..report.frames {
            let is = |kinds: &[Kind]| {
                report.events.iter().any(|e| {
                    kinds.contains(&e.kind)
                        && (e.marker == Some(marker) || (e.kind == Kind::Swap && e.other == Some(marker)))
                        && (e.first..e.first + e.frames).contains(&frame)
                })
            };
            match () {
                () if is(&[Kind::Lost, Kind::NeverSeen, Kind::Left]) => lost += 1,
                () if is(&[Kind::Swap, Kind::Shuffled, Kind::Outlier, Kind::Slide, Kind::Dropped]) => {
                    corrected += 1;
                }
                () if is(&[Kind::FilledBefore, Kind::Spline, Kind::Model, Kind::Held]) => filled += 1,
                () => measured += 1,
            }
        }
    }
    assert_eq!((corrected, lost), (2 * 40 + 2 + 48 + 9 + 30, 200 + 864 + 50));
    for (key, expected) in
        [("measured", measured), ("filled", filled), ("corrected", corrected), ("lost", lost)]
    {
        assert_eq!(summary[key], expected, "{key}");
    }
    assert_eq!(summary["samples"], 864 * report.labels.len());
    assert_eq!(summary["events"]["spline"], 2);
    assert_eq!((&summary["handles"], &summary["markers"]), (&89.into(), &88.into()));
    assert!((summary["offset_mm"]["max"].as_f64().unwrap() - 2.06).abs() < 1e-9);
    let page = Html::parse_document(&html);
    let shown: String = select(&page, ".states").iter().map(text).collect();
    let share = 100.0 * f64::from(lost) / (864.0 * 89.0);
    assert!(shown.contains(&format!("{share:.2} % lost")), "{shown}");
    let facts = select(&page, "dl").iter().map(text).collect::<String>();
    for fact in
        ["864 frames at 120 Hz", "88 of 89 handles", "1 label swap, 2 outliers", "mm (guessed)", "93.00 %"]
    {
        assert!(facts.contains(fact), "{fact}: {facts}");
    }
}

/// The first column of the tables under a heading of docs/report.md.
fn documented(heading: &str) -> Vec<String> {
    let page = include_str!("../../../docs/report.md");
    let section = page.split_once(&format!("\n### {heading}\n")).unwrap_or_else(|| panic!("no {heading}")).1;
    let section = section.split("\n#").next().unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    rows.map(|row| row.split('`').nth(1).unwrap().to_owned()).collect()
}

#[test]
fn the_keys_of_the_json_are_documented() {
    let (_, json) = written(&usual(), &DEMO.1);
    let objects = [
        ("The whole", &json),
        ("`summary`", &json["summary"]),
        ("`setup`", &json["setup"]),
        ("`events`", &json["events"][0]),
        ("`strains`", &json["strains"][0]),
    ];
    for (heading, object) in objects {
        let mut promised = documented(heading);
        promised.sort();
        let mut found: Vec<&String> = object.as_object().unwrap().keys().collect();
        found.sort();
        assert_eq!(found, promised.iter().collect::<Vec<_>>(), "{heading}");
    }
    assert_eq!(json["events"].as_array().unwrap().len(), usual().events.len());
}

/// The greatest height of a curve over its lowest point, in pixels.
fn height(page: &Html) -> f64 {
    let curve =
        select(page, ".plot svg")[0].select(&Selector::parse("polyline[stroke='#0072B2']").unwrap()).next();
    let points = curve.unwrap().attr("points").unwrap().to_owned();
    let rows: Vec<f64> =
        points.split_whitespace().map(|p| p.split_once(',').unwrap().1.parse().unwrap()).collect();
    let [low, high] = [f64::max, f64::min].map(|pick| rows.iter().copied().reduce(pick).unwrap());
    low - high
}

#[test]
fn a_spike_of_one_frame_is_in_the_plot_at_its_height() {
    let mut report = report(144_000, Vec::new());
    report.head_residuals_mm.fill(1.0);
    report.head_residuals_mm[77_777] = 9.0;
    let svg = |report: &Report| Html::parse_document(&written(report, &DEMO.1).0);
    let nine = height(&svg(&report));
    // A second and lower spike does not change the scale; alone it is half as high.
    let area = nine / (9.0 - 1.0) * 9.0 * 1.05;
    assert!((area - 320.0).abs() < 4.0, "{area}");
    report.head_residuals_mm[77_777] = 1.0;
    assert!(height(&svg(&report)) < 1.0);
}

#[test]
fn strains_are_those_of_the_take() {
    let (rig, take) = &*DEMO;
    let rest: Vec<[f64; 3]> = rig.handles().rest.iter().map(|x| x.map(f64::from)).collect();
    let scaled = |factor: f64| rest.iter().map(move |p| p.map(|x| factor * x));
    let order: Vec<String> = rig.handles().labels.iter().rev().cloned().collect();
    let positions = [1.0, 1.1, 0.8].iter().flat_map(|&s| scaled(s).rev()).collect();
    let take = Take { labels: order, times: vec![2.0, 2.5, 3.0], positions, ..take.clone() };
    let strains = Strains::new(&take, rig).unwrap();
    assert_eq!(strains.edges.len(), rig.handles().strain_edges.len());
    for edge in &strains.edges {
        assert!((edge.greatest - 0.1).abs() < 1e-9 && (edge.least + 0.2).abs() < 1e-9, "{edge:?}");
        assert_eq!((edge.time, edge.frame), (3.0, 2));
    }
}

#[test]
fn the_same_report_gives_the_same_bytes() {
    let [a, b] = [(); 2].map(|()| written(&usual(), &DEMO.1));
    assert!(a == b);
}

#[test]
fn ten_minutes_of_markers_stay_small() {
    let (take, labels) = (&DEMO.1, DEMO.0.handles().labels.len());
    let gap = |i: usize| event(Kind::Spline, Some(i % labels), 57 * i, 4 + i % 60);
    let ghost = |i: usize| event(Kind::Outlier, Some(i * 7 % labels), 390 * i, 1);
    let events = (0..2_500).map(gap).chain((0..360).map(ghost)).collect();
    let mut report = report(144_000, events);
    report.rate = 240.0;
    let long = take.resample(20_000.0).unwrap();
    assert!(long.frames() > 143_000);
    let (html, _) = written(&report, &long);
    assert!(html.len() < 3_000_000, "{}", html.len());
    report.events = (0..200_000).map(|i| event(Kind::Spline, Some(i % labels), 7 * i / 10, 3)).collect();
    let (html, _) = written(&report, take);
    assert!(html.len() < 6_000_000, "{}", html.len());
    assert!(html.contains("199,000 more are in report.json"));
}

#[test]
fn takes_with_hardly_anything_in_them() {
    let (rig, take) = &*DEMO;
    let one = take.slice(0..1);
    let mut lost = report(1, (0..89).map(|m| event(Kind::NeverSeen, Some(m), 0, 1)).collect());
    lost.setup.neutral = 0..0;
    lost.setup.markers.fill(None);
    lost.setup.offsets_mm.fill(None);
    lost.head_residuals_mm.fill(0.0);
    let page = Html::parse_document(&written(&lost, &one).0);
    assert!(page.errors.is_empty(), "{:?}", page.errors);
    assert!(select(&page, ".states").iter().map(text).collect::<String>().contains("100 % lost"));

    let empty = Take { times: Vec::new(), positions: Vec::new(), ..take.clone() };
    assert!(Html::parse_document(&written(&report(0, Vec::new()), &empty).0).errors.is_empty());
    let far = Take { positions: vec![[1e300, f64::INFINITY, 0.0]; take.positions.len()], ..take.clone() };
    assert!(Html::parse_document(&written(&usual(), &far).0).errors.is_empty());
    let nowhere = Take { positions: vec![[f64::NAN; 3]; take.positions.len()], ..take.clone() };
    assert!(Html::parse_document(&written(&usual(), &nowhere).0).errors.is_empty());
    let rigid = changed(rig, |r| {
        let (v, centers) = (r.surface.rest.len(), r.examples.len() + 1);
        r.handles.strain_edges.clear();
        (r.influences.edges, r.influences.weights) = (Table::without_columns(v), Table::without_columns(v));
        r.fine_scale.pose_features = Table::without_columns(centers);
        r.learned = None;
    })
    .unwrap();
    let dir = TempDir::new().unwrap();
    write(Page { folder: dir.path(), title: "face" }, "no edges", &usual(), take, &rigid, None).unwrap();
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let (rig, take) = &*DEMO;
    let dir = TempDir::new().unwrap();
    let refused = |report: &Report, take: &Take, word: &str| {
        let message = write(Page { folder: dir.path(), title: "face" }, "t", report, take, rig, None)
            .unwrap_err()
            .to_string();
        assert!(message.contains(word), "{message}");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
    };
    refused(&report(10, vec![event(Kind::Spline, Some(89), 0, 1)]), take, "no handle");
    refused(&report(10, vec![event(Kind::Spline, Some(0), 9, 2)]), take, "after the take");
    refused(&report(10, vec![event(Kind::Spline, Some(0), 1, usize::MAX)]), take, "after the take");
    refused(&Report { labels: Vec::new(), ..usual() }, take, "labels");
    refused(&Report { rate: 0.0, ..usual() }, take, "no times");
    refused(&usual(), &Take { labels: vec!["a".to_owned(); 89], ..take.clone() }, "lacks the handle");
}
