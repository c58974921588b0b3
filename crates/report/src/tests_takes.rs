//! Tests of the page of a folder of takes, read with an independent parser.

use super::takes::{MadeFrom, Outcome, Run, TakeOutcome, Takes, write_takes};
use scraper::{Html, Selector};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn take(name: &str, outcome: Outcome, frames: usize, doubtful: &[usize]) -> TakeOutcome {
    let mut take = TakeOutcome {
        take: PathBuf::from(name),
        file: PathBuf::from("out.usd"),
        outcome,
        error: (outcome == Outcome::Failed).then(|| format!("{name}: has no marker; export it again")),
        warnings: Vec::new(),
        events: BTreeMap::new(),
        frames: 0,
        doubtful_frames: 0,
        doubtful: Vec::new(),
        bytes: 0,
        seconds: 0.0,
        made_from: MadeFrom::default(),
    };
    let mut is_doubtful = vec![false; frames];
    doubtful.iter().for_each(|&frame| is_doubtful[frame] = true);
    take.doubt(&is_doubtful);
    take
}

/// Five takes, added in an order that is not theirs.
fn takes() -> Takes {
    let mut takes = Takes::new(Path::new("face.safetensors"));
    let warned = TakeOutcome {
        warnings: vec!["a <b>marker</b> is missing".to_owned()],
        ..take("d.csv", Outcome::Written, 100, &[])
    };
    takes.add(take("e.csv", Outcome::Unchanged, 100, &[]));
    takes.add(warned);
    takes.add(take("c.csv", Outcome::Written, 1000, &[0, 999]));
    takes.add(take("<i>a.csv", Outcome::Failed, 0, &[]));
    takes.add(take("b.csv", Outcome::Written, 10, &[2, 3, 4, 9]));
    takes
}

fn texts(page: &Html, selector: &str) -> Vec<String> {
    let selector = Selector::parse(selector).unwrap();
    page.select(&selector).map(|found| found.text().collect()).collect()
}

#[test]
fn takes_are_ranked_and_their_doubtful_frames_are_drawn() {
    let takes = takes();
    assert_eq!((takes.written, takes.unchanged, takes.failed), (3, 1, 1));
    assert_eq!(takes.takes[1].doubtful, [Run { first: 2, frames: 3 }, Run { first: 9, frames: 1 }]);
    let folder = tempfile::tempdir().unwrap();
    write_takes(folder.path(), &takes).unwrap();
    let text = std::fs::read_to_string(folder.path().join("takes.html")).unwrap();
    let page = Html::parse_document(&text);
    assert_eq!(texts(&page, "tbody td.frame"), ["<i>a", "b", "c", "d", "e"]);
    assert_eq!(
        texts(&page, "tbody td:nth-child(2)"),
        ["failed", "written", "written", "written", "unchanged"]
    );
    assert_eq!(texts(&page, "tbody td.number"), ["10", "40 %", "1,000", "< 1 %", "100", "0 %", "100", "0 %"]);
    assert_eq!(texts(&page, ".verdict"), ["1 of 5 takes failed, and 3 need a look."]);
    assert_eq!(texts(&page, ".findings b"), ["<i>a", "b", "c"]);
    assert_eq!(texts(&page, "details li"), ["a <b>marker</b> is missing"]);

    // The bars, against the frames.
    let bars = Selector::parse("svg").unwrap();
    let runs = Selector::parse("rect").unwrap();
    let number = |rect: scraper::ElementRef<'_>, name: &str| rect.attr(name).unwrap().parse::<f64>().unwrap();
    let places: Vec<Vec<[f64; 2]>> = page
        .select(&bars)
        .map(|bar| bar.select(&runs).map(|run| [number(run, "x"), number(run, "width")]).collect())
        .collect();
    // A single frame of a thousand is three units wide, and within the bar.
    let expected: [Vec<[f64; 2]>; 4] =
        [vec![[200.0, 300.0], [900.0, 100.0]], vec![[0.0, 3.0], [997.0, 3.0]], vec![], vec![]];
    assert_eq!(places, expected);
}

#[test]
fn the_data_are_what_the_page_was_made_of() {
    let takes = takes();
    let folder = tempfile::tempdir().unwrap();
    write_takes(folder.path(), &takes).unwrap();
    let text = std::fs::read_to_string(folder.path().join("takes.json")).unwrap();
    assert_eq!(serde_json::from_str::<Takes>(&text).unwrap(), takes);
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["takes"][0]["outcome"], "failed");
    assert_eq!(json["takes"][1]["doubtful"][0]["first"], 2);
}

#[test]
fn good_takes_are_said_to_be_good() {
    let mut takes = Takes::new(Path::new("face.safetensors"));
    takes.add(take("a.csv", Outcome::Written, 5, &[]));
    let folder = tempfile::tempdir().unwrap();
    write_takes(folder.path(), &takes).unwrap();
    let text = std::fs::read_to_string(folder.path().join("takes.html")).unwrap();
    assert_eq!(texts(&Html::parse_document(&text), ".verdict"), ["Nothing was found in 1 take."]);
    takes.add(take("b.csv", Outcome::Written, 5, &[1]));
    write_takes(folder.path(), &takes).unwrap();
    let text = std::fs::read_to_string(folder.path().join("takes.html")).unwrap();
    assert_eq!(texts(&Html::parse_document(&text), ".verdict"), ["1 of 2 takes needs a look."]);
}
