//! What FFmpeg, libwebp's tools and Chromium find in the films and animated pictures that `render` writes.

use super::programs::chromium;
use crate::common::Fixture;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

const PICTURES: usize = 12;
/// Both numbers are odd, and the face is not near the corner.
const SIZE: [usize; 2] = [203, 121];
/// Without strong blue: Chromium without a GPU converts with libyuv, which loses a twentieth of it.
const BACKGROUND: [u8; 4] = [0x60, 0xa0, 0x80, 255];
/// The error that the background may have where a film has rounded it.
const NEAR: u8 = 3;

/// Rates in FFmpeg's notation.
const RATES: [(&str, f64); 3] = [("30/1", 30.0), ("24000/1001", 24_000.0 / 1001.0), ("120/1", 120.0)];

/// A rig, a take of [`PICTURES`] frames at `rate`, and the expected pictures as `out/0000N.png`.
fn rendered(rate: f64) -> Fixture {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let take = f.take(PICTURES);
    let retimed = take.lines().enumerate().map(|(line, text)| match (line, text.split_once(',')) {
        (1.., Some((_, rest))) => format!("{:.9},{rest}\n", (line - 1) as f64 / rate),
        _ => format!("{text}\n"),
    });
    f.write("take.csv", retimed.collect::<String>());
    f.done(&format!("{} -o out/{{frame}}.png", render()));
    f
}

fn render() -> String {
    format!("render face.safetensors take.csv --size {}x{} --background 60a080 --whole", SIZE[0], SIZE[1])
}

/// The output of a program, which must succeed.
fn printed(program: &str, args: &[&str], folder: &Path) -> Vec<u8> {
    let output = Command::new(program).args(args).current_dir(folder).output();
    let output = output.unwrap_or_else(|e| panic!("{program}: {e}; run `cargo xtask setup`"));
    assert!(output.status.success(), "{program} {args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// What FFmpeg finds in a file's only stream.
fn stream(file: &str, folder: &Path) -> Value {
    let wanted = ["-v", "error", "-count_frames", "-show_streams", "-of", "json", file];
    let found: Value = serde_json::from_slice(&printed("ffprobe", &wanted, folder)).unwrap();
    assert_eq!(found["streams"].as_array().unwrap().len(), 1, "{found}");
    found["streams"][0].clone()
}

/// A file's pictures as FFmpeg decodes them, red, green, blue and opacity.
fn decoded(file: &str, folder: &Path) -> Vec<Vec<u8>> {
    let args = ["-v", "error", "-i", file, "-f", "rawvideo", "-pix_fmt", "rgba", "-"];
    printed("ffmpeg", &args, folder).chunks(4 * SIZE[0] * SIZE[1]).map(<[u8]>::to_vec).collect()
}

fn is_background(pixel: &[u8], within: u8) -> bool {
    pixel.iter().zip(BACKGROUND).all(|(found, wanted)| found.abs_diff(wanted) <= within)
}

#[test]
fn films_and_animated_pictures_are_what_other_programs_find() {
    for (rate, number) in RATES {
        let f = rendered(number);
        let folder = f.path("out");
        let stills: Vec<Vec<u8>> =
            (0..PICTURES).flat_map(|i| decoded(&format!("{i:05}.png"), &folder)).collect();
        assert_eq!(stills.len(), PICTURES);
        let files = ["face.mp4", "face.webp"];
        for file in files {
            f.done(&format!("{} -o out/{file}", render()));
        }

        let film = stream("face.mp4", &folder);
        let said = |key: &str| film[key].as_str().unwrap_or_default().to_owned();
        assert_eq!((film["width"].as_u64(), film["height"].as_u64()), (Some(203), Some(121)), "{film}");
        assert_eq!([said("codec_name"), said("pix_fmt")], ["av1", "yuv420p"]);
        assert_eq!([said("r_frame_rate"), said("avg_frame_rate")], [rate, rate]);
        assert_eq!(said("nb_read_frames"), PICTURES.to_string());
        assert_eq!([said("color_range"), said("chroma_location")], ["tv", "left"]);
        let colours = ["color_space", "color_transfer", "color_primaries"].map(said);
        assert_eq!(colours, ["bt709", "iec61966-2-1", "bt709"]);
        let seconds: f64 = said("duration").parse().unwrap();
        assert!((seconds - PICTURES as f64 / number).abs() < 1e-4, "{seconds} s");
        let filmed = decoded("face.mp4", &folder);
        assert_eq!(filmed.len(), PICTURES);
        for (picture, still) in filmed.iter().zip(&stills) {
            assert!(is_background(still, 0) && is_background(picture, NEAR), "{:?}", &picture[..4]);
            let off = picture.iter().zip(still).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>();
            assert!(off < 3.0 * picture.len() as f64, "{} of 255 on average", off / picture.len() as f64);
        }
        webp(&f, number, &stills);

        let paths: Vec<_> = files.iter().map(|file| folder.join(file)).collect();
        for (file, shown) in files.iter().zip(chromium(&paths, PICTURES).as_array().unwrap()) {
            assert_eq!(shown["size"], serde_json::json!(SIZE), "{file}");
            let (seconds, expected) = (shown["seconds"].as_f64().unwrap(), PICTURES as f64 / number);
            // A WebP's duration is a whole number of milliseconds.
            assert!((seconds - expected).abs() < 1e-3, "{file} lasts {seconds} s, not {expected}");
            let pixels = shown["pixels"].as_array().unwrap();
            assert_eq!(pixels.len(), PICTURES, "{file}");
            for (pixels, still) in pixels.iter().zip(&stills) {
                let [corner, middle]: [[u8; 4]; 2] = serde_json::from_value(pixels.clone()).unwrap();
                let within = if *file == "face.mp4" { NEAR } else { 0 };
                assert!(is_background(&corner, within), "{file}: {corner:?}");
                let at = 4 * (SIZE[1] / 2 * SIZE[0] + SIZE[0] / 2);
                let off = middle.iter().zip(&still[at..]).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
                assert!(off <= 4 * within, "{file}: {middle:?}, not {:?}", &still[at..at + 4]);
            }
        }
    }
}

/// What libwebp's tools find.
fn webp(f: &Fixture, rate: f64, stills: &[Vec<u8>]) {
    let folder = f.path("out");
    let said = String::from_utf8(printed("webpinfo", &["face.webp"], &folder)).unwrap();
    assert!(said.contains("No error detected."), "{said}");
    let said = String::from_utf8(printed("webpmux", &["-info", "face.webp"], &folder)).unwrap();
    assert!(said.contains("Canvas size: 203 x 121") && said.contains("Loop Count : 0"), "{said}");
    let frames = said.lines().filter_map(|line| line.trim().split_once(": "));
    let frames: Vec<Vec<&str>> = frames
        .filter(|(number, _)| number.parse::<usize>().is_ok())
        .map(|(_, columns)| columns.split_whitespace().collect())
        .collect();
    assert_eq!(frames.len(), PICTURES, "{said}");
    let mut end = 0;
    for (i, (columns, still)) in frames.iter().zip(stills).enumerate() {
        // Width, height, opacity, x and y offset, duration in ms, dispose, blend.
        assert_eq!([columns[0], columns[1], columns[3], columns[4]], ["203", "121", "0", "0"], "{said}");
        assert_eq!(columns[7], "no", "{said}");
        end += columns[5].parse::<u64>().unwrap();
        assert_eq!(end as f64, (1000.0 * (i + 1) as f64 / rate).round(), "after picture {i}");
        let number = (i + 1).to_string();
        printed("webpmux", &["-get", "frame", &number, "face.webp", "-o", "one.webp"], &folder);
        printed("dwebp", &["-quiet", "one.webp", "-o", "one.png"], &folder);
        assert!(decoded("one.png", &folder)[0] == *still, "picture {i} of the WebP differs");
    }
}

#[test]
fn a_webp_is_transparent_where_no_face_is() {
    let f = rendered(30.0);
    f.done("render face.safetensors take.csv -o out/clear.webp --frames 3..5 --size 203x121 --background none --whole");
    let shown = chromium(&[f.path("out/clear.webp")], 2);
    let pixels: Vec<[[u8; 4]; 2]> = serde_json::from_value(shown[0]["pixels"].clone()).unwrap();
    assert_eq!(
        pixels.iter().map(|[corner, middle]| [corner[3], middle[3]]).collect::<Vec<_>>(),
        [[0, 255]; 2]
    );
}
