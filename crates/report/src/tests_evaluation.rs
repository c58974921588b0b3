//! Tests of the pages of an evaluation and of a plan, read with an independent parser.

use super::{write_evaluation, write_plan};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rhytid_core::{NoProgress, Rig};
use rhytid_evaluate::coverage::coverage;
use rhytid_evaluate::{Map, Regions, Subject, evaluate};
use scraper::{Html, Selector};
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

fn page(folder: &Path, name: &str) -> (Html, Value) {
    let text = std::fs::read_to_string(folder.join(format!("{name}.html"))).unwrap();
    let page = Html::parse_document(&text);
    assert!(page.errors.is_empty(), "{:?}", page.errors);
    assert!(!text.contains("http://") && !text.contains("https://"), "the page needs something else");
    let json = std::fs::read_to_string(folder.join(format!("{name}.json"))).unwrap();
    (page, serde_json::from_str(&json).unwrap())
}

fn texts(page: &Html, selector: &str) -> Vec<String> {
    let selector = Selector::parse(selector).unwrap();
    page.select(&selector).map(|element| element.text().collect::<String>()).collect()
}

/// The pictures, each as wide as high it should be, and whether it has a colour at all.
fn pictures(page: &Html) -> Vec<bool> {
    let selector = Selector::parse("svg image").unwrap();
    page.select(&selector)
        .map(|image| {
            let data = image.value().attr("href").unwrap().strip_prefix("data:image/png;base64,").unwrap();
            let bytes = STANDARD.decode(data).unwrap();
            let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!((reader.info().width, reader.info().height), (300, 370));
            // Warm: red far above blue.
            pixels
                .as_chunks::<4>()
                .0
                .iter()
                .any(|[red, _, blue, alpha]| *alpha == 255 && *red > blue.saturating_add(60))
        })
        .collect()
}

fn rig() -> Rig {
    rhytid_solve::solve(&rhytid_demo::face(2_000), &NoProgress).unwrap().cast()
}

#[test]
fn an_evaluation_is_drawn_on_the_face() {
    let mut face = rhytid_demo::face(2_000);
    face.examples[1].name = "<b>grin</b>".into();
    let device =
        rhytid_playback::choose_devices("cpu:0", rhytid_playback::Guard::NONE, &NoProgress).unwrap().devices;
    let (rig, found, maps) =
        evaluate(&face, |rig| Ok((Regions::by_handles(rig), None)), &device, &NoProgress).unwrap();
    let folder = TempDir::new().unwrap();
    write_evaluation(&folder.path().join("new"), &found, &maps, &rig).unwrap();
    let (page, json) = page(&folder.path().join("new"), "evaluation");
    assert_eq!(json["handles"], rig.handles.len());
    let rows = texts(&page, "tbody tr");
    assert_eq!(rows.len(), 1 + face.examples.len(), "a row for each example and one for all");
    let left_out = found.leave_one_out.unwrap();
    assert!(
        rows[2].contains("<b>grin</b>")
            && rows[2].contains(&format!("{:.3}", left_out.examples[1].errors.rms_mm))
    );
    // Two views of each map; an example that moves the face is missed somewhere.
    let drawn = pictures(&page);
    assert_eq!(drawn.len(), 2 * (2 + face.examples.len()));
    assert!(drawn[0], "nothing is coloured");
    let titles = texts(&page, "figcaption");
    assert!(titles[2].contains("without <b>grin</b>"), "{titles:?}");

    // A map that is 0 everywhere has no colour, and one of another mesh is a fault.
    let zero = Map { subject: Subject::Noise, title: "none".into(), values: vec![0.0; rig.vertices()] };
    let found = rhytid_evaluate::Evaluation { leave_one_out: None, ..found };
    write_evaluation(folder.path(), &found, std::slice::from_ref(&zero), &rig).unwrap();
    assert_eq!(pictures(&self::page(folder.path(), "evaluation").0), [false, false]);
    let short = Map { values: vec![0.0; 3], ..zero };
    assert!(write_evaluation(folder.path(), &found, &[short], &rig).is_err());
}

#[test]
fn a_plan_shows_each_frame() {
    let rig = rig();
    let take = rhytid_demo::performance(&rhytid_demo::face(2_000));
    let regions = Regions::by_handles(&rig);
    let found = coverage(&rig, &take, &regions, None, (3, 3), &NoProgress).unwrap();
    let poses = vec![rig.rest.clone(); 3];
    let folder = TempDir::new().unwrap();
    write_plan(folder.path(), "<take>.csv", &found, &regions, &poses, &rig).unwrap();
    let (page, json) = page(folder.path(), "plan");
    assert_eq!(texts(&page, "h1"), ["<take>.csv"]);
    assert_eq!(json["scans"].as_array().unwrap().len(), 3);
    let captions = texts(&page, "figcaption");
    for (caption, scan) in captions.iter().zip(&found.scans) {
        assert!(caption.contains(&format!("frame {}, ", scan.frame)), "{caption}");
        assert!(caption.contains(&scan.regions[0].region), "{caption}");
    }
    assert_eq!(pictures(&page), [true; 6]);
    // Markers that the head does not hide.
    assert!(texts(&page, "circle.dot").len() > 2 * rig.handles.len());
    assert!(write_plan(folder.path(), "take", &found, &regions, &poses[1..], &rig).is_err());
}
