//! Examples whose wrinkles are an artist's image.

use rhytid_core::Face;
use rhytid_formats::{Reach, project};
use rhytid_test_support::Logged;
use std::f64::consts::TAU;
use std::fs;

/// Quads along an edge of the sheet, its size in mesh units, and how high a bump is on it.
const N: usize = 40;
const SIZE: f64 = 10.0;
const HEIGHT: f64 = 1.0;

const PIXELS: u32 = 128;

/// The height of a bump in the middle at texture coordinates, and its slopes along u and v.
fn bump(u: f64, v: f64) -> [f64; 3] {
    let along = |x: f64| {
        let t = ((x - 0.2) / 0.6).clamp(0.0, 1.0);
        let slope = if t > 0.0 && t < 1.0 { 0.5 * TAU * (TAU * t).sin() / (0.6 * SIZE) } else { 0.0 };
        (0.5 - 0.5 * (TAU * t).cos(), slope)
    };
    let ((f, df), (g, dg)) = (along(u), along(v));
    [HEIGHT * f * g, HEIGHT * df * g, HEIGHT * f * dg]
}

fn png(folder: &std::path::Path, name: &str, pixel: impl Fn(f64, f64) -> [f64; 3]) {
    let mut bytes = Vec::new();
    for y in 0..PIXELS {
        for x in 0..PIXELS {
            let at = |i: u32| (f64::from(i) + 0.5) / f64::from(PIXELS);
            for c in pixel(at(x), 1.0 - at(y)) {
                bytes.extend((((c + 1.0) * 0.5 * 65_535.0).round() as u16).to_be_bytes());
            }
        }
    }
    let mut encoder = png::Encoder::new(fs::File::create(folder.join(name)).unwrap(), PIXELS, PIXELS);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
}

/// A sheet in the plane z = 0, u along x and v along y, in centimetres, whose one example is itself with a
/// map; and the warnings.
fn load(map: &str) -> (Face, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let mut obj = String::new();
    for i in 0..(N + 1) * (N + 1) {
        let [u, v] = [i % (N + 1), i / (N + 1)].map(|x| x as f64 / N as f64);
        obj += &format!("v {} {} 0\nvt {u} {v}\n", u * SIZE, v * SIZE);
    }
    for a in (0..N).flat_map(|j| (1..=N).map(move |i| j * (N + 1) + i)) {
        let [b, c, d] = [a + 1, a + N + 2, a + N + 1];
        obj += &format!("f {a}/{a} {b}/{b} {c}/{c} {d}/{d}\n");
    }
    fs::write(folder.path().join("sheet.obj"), obj).unwrap();
    fs::write(folder.path().join("markers.csv"), "label,vertex\na,0\nb,40\nc,1680\n").unwrap();
    png(folder.path(), "white.png", |_, _| [0.0, 0.0, 1.0]);
    for (name, upwards) in [("up.png", 1.0), ("down.png", -1.0)] {
        png(folder.path(), name, |u, v| {
            let [_, du, dv] = bump(u, v);
            let size = (1.0 + du * du + dv * dv).sqrt();
            [-du / size, -upwards * dv / size, 1.0 / size]
        });
    }
    let path = folder.path().join("sheet.toml");
    let text = format!(
        "[mesh]\nneutral = \"sheet.obj\"\nunits = \"cm\"\nup = \"y\"\n[handles]\nvertices = \"markers.csv\"\n[[example]]\nname = \"bump\"\nmesh = \
         \"sheet.obj\"\n{map}\n"
    );
    fs::write(&path, text).unwrap();
    let logged = Logged::start();
    let face = project::read(&path, Reach::Below).unwrap();
    (face, logged.lines())
}

/// How far the example is out of the plane.
fn heights(face: &Face) -> Vec<f64> {
    face.examples[0].positions.iter().map(|x| x[2]).collect()
}

#[test]
fn displacements_are_in_millimetres() {
    let (face, said) = load("displacement = \"white.png\"\nmillimetres = 1.5");
    assert!(heights(&face).iter().all(|height| (height - 0.15).abs() < 1e-6));
    assert_eq!(said, [""; 0]);
}

#[test]
fn a_normal_maps_surface_is_found_and_green_that_points_elsewhere_is_said() {
    for (file, green, strength) in
        [("up", "", 1.0), ("up", "green = \"up\"", 0.5), ("down", "green = \"down\"", 2.0)]
    {
        let (face, said) = load(&format!("normal_map = \"{file}.png\"\n{green}\nstrength = {strength}"));
        assert_eq!(said, [""; 0]);
        let expected: Vec<f64> = (0..(N + 1) * (N + 1))
            .map(|i| strength * bump((i % (N + 1)) as f64 / N as f64, (i / (N + 1)) as f64 / N as f64)[0])
            .collect();
        let found = heights(&face);
        // But for a height of all of the sheet, which slopes do not have.
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let by = mean(&found) - mean(&expected);
        let off = found.iter().zip(&expected).map(|(a, b)| (a - by - b).abs()).fold(0.0, f64::max);
        assert!(off < 0.04 * strength * HEIGHT, "{file}, {strength}: {off}");
    }
    for (file, green, other) in [("down", "", "down"), ("up", "green = \"down\"", "up")] {
        let (_, said) = load(&format!("normal_map = \"{file}.png\"\n{green}"));
        let [line] = &said[..] else { panic!("{said:?}") };
        assert!(line.contains(&format!("{file}.png: its green seems to point {other}")), "{line}");
        assert!(line.ends_with(&format!("say green = \"{other}\"")), "{line}");
    }
}
