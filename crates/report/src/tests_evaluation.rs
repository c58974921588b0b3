//! Tests of the pages of an evaluation and of a plan, read with an independent parser.

use super::{Page, write_evaluation, write_plan};
use rhytid_core::NoProgress;
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

/// Asserts that the page says once why it has no pictures, and what to do.
fn assert_left_out(page: &Html) {
    let said = texts(page, "p.left-out");
    assert!(said.len() == 1 && said[0].starts_with("The pictures are left out, since "), "{said:?}");
    assert_eq!(said[0].contains("install a driver for Vulkan"), cfg!(feature = "render"), "{said:?}");
    assert_eq!(said[0].contains("built without wgpu"), !cfg!(feature = "render"), "{said:?}");
    assert!(texts(page, "image").is_empty() && texts(page, "figure").is_empty());
}

fn to(folder: &Path) -> Page<'_> {
    Page { folder, title: "Anna" }
}

#[test]
fn an_evaluation_has_its_tables() {
    let mut face = rhytid_demo::face(2_000);
    face.examples[1].name = "<b>grin</b>".into();
    let device =
        rhytid_devices::choose_devices("cpu:0", rhytid_devices::Guard::NONE, &NoProgress).unwrap().devices;
    let (rig, found, maps) =
        evaluate(&face, |rig| Ok((Regions::by_handles(rig), None)), &device, &NoProgress).unwrap();
    let folder = TempDir::new().unwrap();
    write_evaluation(to(&folder.path().join("new")), &found, &maps, &rig, None).unwrap();
    let (page, json) = page(&folder.path().join("new"), "evaluation");
    assert_eq!(json["handles"], rig.handles().len());
    let verdict = texts(&page, ".opening .verdict");
    let left_out = found.leave_one_out.as_ref().unwrap();
    assert!(
        verdict.len() == 1 && verdict[0].contains("An expression without a scan is about "),
        "{verdict:?}"
    );
    let hardest =
        left_out.examples.iter().max_by(|a, b| a.errors.skin.rms_mm.total_cmp(&b.errors.skin.rms_mm));
    let findings = texts(&page, ".findings li");
    assert!((1..=3).contains(&findings.len()), "{findings:?}");
    assert!(
        findings[0].contains(&format!("Hardest without a scan: {}", hardest.unwrap().example)),
        "{findings:?}"
    );
    let rows = texts(&page, "tbody tr");
    assert_eq!(rows.len(), 1 + face.examples.len(), "a row for each example and one for all");
    assert!(
        rows[2].contains("<b>grin</b>")
            && rows[2].contains(&format!("{:.3}", left_out.examples[1].errors.skin.rms_mm))
    );
    assert_left_out(&page);

    // A map of another mesh is a fault.
    let short = Map { subject: Subject::Noise, title: "none".into(), values: vec![0.0; 3] };
    assert!(write_evaluation(to(folder.path()), &found, &[short], &rig, None).is_err());
}

#[test]
fn a_plan_shows_each_frame() {
    let mut face = rhytid_demo::face(2_000);
    face.examples.clear();
    let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
    let take = rhytid_demo::performance(&rhytid_demo::face(2_000));
    let regions = Regions::by_handles(&rig);
    let found = coverage(&rig, &take, &regions, None, 3, 3, &NoProgress).unwrap();
    let poses = vec![rig.surface().rest.clone(); 3];
    let folder = TempDir::new().unwrap();
    write_plan(to(folder.path()), "<take>.csv", &found, &regions, &poses, &rig, None).unwrap();
    let (page, json) = page(folder.path(), "plan");
    assert_eq!(texts(&page, "h1"), ["Anna"]);
    assert!(texts(&page, "header p")[0].contains("<take>.csv"));
    assert_eq!(texts(&page, ".opening .verdict"), [found.verdict()]);
    let findings = texts(&page, ".findings li");
    assert!(findings.len() == found.enough.min(3) && found.enough > 0, "{findings:?}");
    assert!(findings[0].contains(&format!("frame {}, ", found.scans[0].frame)), "{findings:?}");
    assert_eq!(json["scans"].as_array().unwrap().len(), 3);
    // Without pictures it still says what each scan is for.
    assert_left_out(&page);
    let rows = texts(&page, ".plan tbody tr");
    assert_eq!(rows.len(), 3);
    for (row, scan) in rows.iter().zip(&found.scans) {
        assert!(row.contains(&format!("frame {}, ", scan.frame)), "{row}");
        assert!(row.contains(&scan.regions[0].region), "{row}");
    }
    assert!(write_plan(to(folder.path()), "take", &found, &regions, &poses[1..], &rig, None).is_err());
}
