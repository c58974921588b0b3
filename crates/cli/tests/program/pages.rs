//! Pages and their pictures, with a device that draws and without one.

use crate::common::{Fixture, stderr};
use assert_cmd::Command;
use scraper::{Html, Selector};

/// Commands that write pages and pictures: the command, its page, the number of pictures.
const PAGES: [(&str, &str, usize); 3] = [
    ("evaluate face.toml --device cpu:0 --report", "evaluation", 6),
    ("coverage face.safetensors take.csv --plan 1 --report", "plan", 2),
    ("prepare take.csv --rig face.safetensors -o clean.csv --report", "report", 2),
];

fn texts(page: &str, selector: &str) -> Vec<String> {
    let page = Html::parse_document(page);
    let selector = Selector::parse(selector).unwrap();
    page.select(&selector).map(|element| element.text().collect()).collect()
}

/// Hides the drivers of every API.
fn without_drivers(f: &Fixture, command: &mut Command) {
    for name in ["VK_ICD_FILENAMES", "VK_DRIVER_FILES", "__EGL_VENDOR_LIBRARY_FILENAMES"] {
        command.env(name, f.path("nothing-here"));
    }
}

#[test]
fn pages_have_pictures_and_twice_the_same_bytes() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    for (command, name, pictures) in PAGES {
        let [first, again] = ["first", "again"].map(|folder| {
            f.done(&format!("{command} {folder}"));
            f.read_text(&format!("{folder}/{name}.html"))
        });
        let shown = |line: &str| line.chars().take(300).collect::<String>();
        let mut lines = first.lines().zip(again.lines()).enumerate();
        if let Some((i, (a, b))) = lines.find(|(_, (a, b))| a != b) {
            panic!("{name}: the same again has another line {i}:\n{}\n{}", shown(a), shown(b));
        }
        assert!(first == again, "{name}: the same again has other bytes");
        assert_eq!(texts(&first, "svg image").len(), pictures, "{name}");
        assert!(texts(&first, ".left-out").is_empty(), "{name}");
    }
    f.done("handles face.toml --count 8 -o handles.csv");
    assert!(f.read("handles.png").starts_with(b"\x89PNG"));
}

#[test]
fn where_nothing_draws_pages_say_what_to_install() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    for (command, name, _) in PAGES {
        let mut blind = f.rhytid(&format!("{command} blind"));
        without_drivers(&f, &mut blind);
        let output = blind.output().unwrap();
        let said = stderr(&output);
        assert!(output.status.success(), "{command}: {said}");
        assert_eq!(
            said.matches("pictures are left out: there is no device to draw with").count(),
            1,
            "{said}"
        );
        let page = f.read_text(&format!("blind/{name}.html"));
        assert!(texts(&page, "image").is_empty(), "{name}");
        let sentence = texts(&page, ".left-out");
        assert!(
            sentence.len() == 1 && sentence[0].contains("install a driver for Vulkan, Metal"),
            "{name}: {sentence:?}"
        );
        // Everything else is there.
        f.done(&format!("{command} seen"));
        let json = |folder: &str| f.read(&format!("{folder}/{name}.json"));
        assert!(json("blind") == json("seen"), "{name}");
        let rows = |folder: &str| texts(&f.read_text(&format!("{folder}/{name}.html")), "tr");
        assert_eq!(rows("blind"), rows("seen"), "{name}");
    }
    let mut blind = f.rhytid("handles face.toml --count 8 -o handles.csv");
    without_drivers(&f, &mut blind);
    let output = blind.output().unwrap();
    let (said, found) = (stderr(&output), String::from_utf8_lossy(&output.stdout).into_owned());
    assert!(
        output.status.success() && said.contains("handles.png is left out: there is no device"),
        "{said}"
    );
    assert!(found.contains("8 handles spread over the face") && !found.contains("look at it"), "{found}");
    assert!(f.path("handles.csv").is_file() && !f.path("handles.png").exists());
    let mut blind = f.rhytid("render face.safetensors take.csv -o out/face.png");
    without_drivers(&f, &mut blind);
    let output = blind.output().unwrap();
    assert!(output.status.code() == Some(2) && stderr(&output).contains("there is no device to draw with"));
    assert!(!f.path("out/face.png").exists());
}
