//! Tests of the pictures on every device here. They are decoded and checked where known things are.

use crate::behind::behind;
use crate::painter::{Canvas, LIFT, Painter, camera};
use crate::tests::{DEMO, drawn, number, select, text, usual};
use crate::{Page, write_evaluation, write_handles, write_plan};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{Backend, NoProgress, Rig};
use rhytid_evaluate::coverage::coverage;
use rhytid_evaluate::{Errors, Evaluation, Map, NoiseAnswer, Regions, SkinErrors, Subject};
use rhytid_render::{Camera, Mark, Picture, Sphere};
use rhytid_test_support::skip;
use scraper::{ElementRef, Html, Selector};
use tempfile::TempDir;

/// The views of a page's pictures.
const TURNS: [f32; 2] = [0.0, 42.0];

/// Runs a check with a painter on each device here.
fn each_painter(check: impl Fn(&str, &Painter)) {
    let devices = Wgpu::devices().unwrap_or_default();
    if devices.is_empty() {
        return skip("nothing draws here");
    }
    for info in devices {
        let wgpu = Wgpu::open(&info).unwrap();
        check(&format!("{} {}", info.name, info.driver), &Painter::new(wgpu.device(), wgpu.queue()));
    }
}

/// A picture of a page, decoded.
fn decoded(image: &ElementRef) -> Picture {
    let data = image.attr("href").unwrap().strip_prefix("data:image/png;base64,").unwrap();
    Picture::decode(&STANDARD.decode(data).unwrap()).unwrap()
}

fn handles(rig: &Rig) -> Vec<[f32; 3]> {
    rig.handles().rest.clone()
}

fn camera_of(rig: &Rig, turn: f32, size: [u32; 2]) -> Camera {
    camera(&handles(rig), &rig.surface().rest, rig.surface().up_axis, turn, size)
}

/// The place of a point in a picture.
fn place(camera: &Camera, size: [u32; 2], point: [f32; 3]) -> [u32; 2] {
    let [x, y, _] = camera.project(size, point);
    [x as u32, y as u32]
}

#[test]
fn a_clean_ups_markers_are_where_the_camera_sees_them() {
    const SIZE: [u32; 2] = [520, 640];
    let (rig, take) = &*DEMO;
    let handles = handles(rig);
    each_painter(|device, painter| {
        let (html, _) = drawn(&usual(), take, Some(painter));
        assert!(!html.contains("left out, since"), "{device}");
        let page = Html::parse_document(&html);
        assert!(page.errors.is_empty(), "{:?}", page.errors);
        let views = select(&page, ".views svg");
        assert_eq!(views.len(), 2);
        for (view, turn) in views.iter().zip(TURNS) {
            let all = |class: &str| -> Vec<[f64; 2]> {
                let circles = Selector::parse(&format!("circle.{class}")).unwrap();
                view.select(&circles).map(|c| [number(&c, "cx"), number(&c, "cy")]).collect()
            };
            let (rings, dots) = (all("handle"), all("dot"));
            assert_eq!((rings.len(), dots.len()), (89, 89));
            let camera = camera_of(rig, turn, SIZE);
            for ((ring, dot), handle) in rings.iter().zip(&dots).zip(&handles) {
                let [x, y, _] = camera.project(SIZE, *handle).map(f64::from);
                assert!((ring[0] - x).abs() < 0.06 && (ring[1] - y).abs() < 0.06, "{ring:?}, {x} {y}");
                // At neutral the dots are in their rings.
                assert!((0..2).all(|c| (ring[c] - dot[c]).abs() < 1.0), "{ring:?} {dot:?}");
            }
            let picture = decoded(&view.select(&Selector::parse("image").unwrap()).next().unwrap());
            assert_eq!(picture.size, SIZE);
            // Skin where the handles are, and nothing in the corners.
            let is_skin = |handle: &&[f32; 3]| {
                let [r, g, b, opacity] = picture.pixel(place(&camera, SIZE, **handle));
                opacity == 255 && r >= g && g >= b
            };
            // Some handles are at the mesh's own rims.
            let on_skin = handles.iter().filter(is_skin).count();
            assert!(on_skin >= 80, "{device}: {on_skin} handles are on skin");
            for corner in [[0, 0], [519, 0], [0, 639], [519, 639]] {
                assert_eq!(picture.pixel(corner)[3], 0, "{device}: {corner:?}");
            }
        }
        let behind = select(&page, ".views g.behind");
        assert!(behind.len() < 89, "{} of 178 are behind the face", behind.len());
        let titles: Vec<String> = select(&page, ".views title").iter().map(text).collect();
        assert_eq!(&titles[..3], &rig.handles().labels[..3]);

        // The same page again has the same bytes.
        assert!(html == drawn(&usual(), take, Some(painter)).0, "{device}");
    });
}

/// The host finds the same hidden points as a device's depth test.
#[test]
fn what_is_behind_is_what_a_device_hides() {
    const SIZE: [u32; 2] = [260, 320];
    const GREEN: [f32; 3] = [0.0, 1.0, 0.0];
    let (rig, _) = &*DEMO;
    let points: Vec<[f32; 3]> = rig.surface().rest.iter().step_by(rig.vertices() / 150).copied().collect();
    let lift = LIFT * Sphere::around(&handles(rig)).radius;
    each_painter(|device, painter| {
        let mut canvas =
            Canvas::new(painter, &rig.surface().faces, &rig.surface().triangles, rig.vertices(), SIZE)
                .unwrap();
        let (mut seen, mut cut) = ([0; 2], 0);
        for turn in [0.0, 70.0] {
            let camera = camera_of(rig, turn, SIZE);
            let found = behind(&camera, SIZE, &rig.surface().rest, &rig.surface().triangles, lift, &points);
            for (&point, is_behind) in points.iter().zip(found) {
                let dot = [Mark::dot(point, GREEN, 6.0)];
                let picture = canvas.draw(&camera, &rig.surface().rest, None, lift, &dot).unwrap();
                let [r, g, b, _] = picture.pixel(place(&camera, SIZE, point));
                match (r, g, b) {
                    (..=2, 253.., ..=2) => seen[1] += usize::from(!is_behind),
                    // Skin.
                    _ if g <= r => seen[0] += usize::from(is_behind),
                    // The rim of what hides it cuts the dot.
                    _ => cut += 1,
                }
            }
        }
        let wrong = 2 * points.len() - seen[0] - seen[1] - cut;
        assert!(wrong <= 3 && cut < 20, "{device}: {wrong} of {} are wrong, {cut} cut", 2 * points.len());
        assert!(seen.iter().all(|count| *count > 30), "{seen:?} are hidden and drawn");
    });
}

#[test]
fn maps_have_the_colours_of_their_numbers() {
    const SIZE: [u32; 2] = [300, 370];
    let (rig, _) = &*DEMO;
    // 0 on the face's right, 2 mm on its left, 50 mm at one vertex, and no number on the forehead.
    let sides = rig.surface().rest.iter().map(|p| if p[0] > 0.0 { 2.0 } else { 0.0 });
    let mut values: Vec<f32> = sides.collect();
    let left = values.iter().position(|x| *x > 0.0).unwrap();
    values[left] = 50.0;
    let is_forehead = |p: &[f32; 3]| p[1] > 5.0;
    for (value, p) in values.iter_mut().zip(&rig.surface().rest).filter(|(_, p)| is_forehead(p)) {
        let _ = p;
        *value = f32::NAN;
    }
    let maps = [("sides", values), ("none", vec![0.0; rig.vertices()])].map(|(title, values)| Map {
        subject: Subject::Noise,
        title: title.into(),
        values,
    });
    let errors = Errors {
        rms_mm: 0.0,
        p95_mm: 0.0,
        p99_9_mm: 0.0,
        worst_mm: 0.0,
        frame: 0,
        vertex: 0,
        regions: Vec::new(),
        skin: SkinErrors::default(),
        others_rms_mm: None,
    };
    let found = Evaluation {
        name: "face".into(),
        vertices: rig.vertices(),
        handles: rig.handles().len(),
        leave_one_out: None,
        noise: NoiseAnswer { noise_mm: 0.1, errors },
        truth: None,
    };
    each_painter(|device, painter| {
        let folder = TempDir::new().unwrap();
        let html = || {
            write_evaluation(
                Page { folder: folder.path(), title: "Anna" },
                &found,
                &maps,
                rig,
                Some(painter),
            )
            .unwrap();
            std::fs::read_to_string(folder.path().join("evaluation.html")).unwrap()
        };
        let html = [html(), html()];
        assert!(html[0] == html[1], "{device}: the same again has other bytes");
        let page = Html::parse_document(&html[0]);
        let images = select(&page, ".maps svg image");
        assert_eq!(images.len(), 2 * maps.len());
        // The legend's ends: white and red, as docs/evaluate.md says.
        let legend = select(&page, ".scale i")[0].attr("style").unwrap().to_owned();
        let ends: Vec<[u8; 3]> = legend
            .split("rgb(")
            .skip(1)
            .map(|colour| {
                let parts = colour.split(')').next().unwrap().split(' ');
                let parts: Vec<u8> = parts.map(|part| part.parse().unwrap()).collect();
                [parts[0], parts[1], parts[2]]
            })
            .collect();
        let (first, last) = (ends[0], ends[ends.len() - 1]);
        let is_white = |c: &[u8]| c[..3].iter().all(|x| *x > 40) && c[0].abs_diff(c[2]) < 8;
        let is_red = |c: &[u8]| c[0] > 60 && c[0] > c[1].saturating_add(60) && c[0] > c[2].saturating_add(40);
        assert!(is_white(&first) && first[0] > 225 && is_red(&last), "{first:?} to {last:?}");
        assert!(text(&select(&page, ".scale")[0]).contains("2 mm and more"));
        // The first findings' picture is that of a map: it is in the page once.
        for picture in select(&page, ".findings use") {
            let name = picture.attr("href").unwrap().trim_start_matches('#').to_owned();
            assert_eq!(select(&page, &format!("[id={name}]")).len(), 1, "{name}");
        }
        for (image, turn) in images[..2].iter().zip(TURNS) {
            let (picture, camera) = (decoded(image), camera_of(rig, turn, SIZE));
            let on_face = |x: f32| {
                // The foremost vertex about here.
                let near = rig.surface().rest.iter().filter(|p| (p[0] - x).abs() < 0.4 && p[1].abs() < 1.0);
                *near.max_by(|a, b| a[2].total_cmp(&b[2])).unwrap()
            };
            let [right, left] = [-2.0, 2.0].map(|x| picture.pixel(place(&camera, SIZE, on_face(x))));
            assert!(is_white(&right) && right[3] == 255, "{device}: {right:?}, expected white in some light");
            assert!(is_red(&left) && left[3] == 255, "{device}: {left:?}, expected red in some light");
            assert_eq!(picture.pixel([0, 0])[3], 0);
            // What has no number is darker than white, and has no hue.
            let forehead = rig.surface().rest.iter().filter(|p| p[1] > 6.0 && p[0].abs() < 1.0);
            let forehead = *forehead.max_by(|a, b| a[2].total_cmp(&b[2])).unwrap();
            let grey = picture.pixel(place(&camera, SIZE, forehead));
            assert!(
                grey[0].abs_diff(grey[2]) < 8 && grey[0] + 20 < right[0],
                "{device}: {grey:?}, beside {right:?}"
            );
        }
        let none = decoded(&images[2]);
        let face: Vec<&[u8; 4]> = none.pixels.as_chunks().0.iter().filter(|pixel| pixel[3] == 255).collect();
        let is_grey = |c: &&[u8; 4]| c[0].abs_diff(c[2]) < 8;
        assert!(
            face.len() > 20_000 && face.iter().all(is_grey),
            "{device}: {} pixels of the face",
            face.len()
        );
    });
}

#[test]
fn a_plan_shows_each_frame_with_its_markers() {
    let (rig, take) = &*DEMO;
    let regions = Regions::by_handles(rig);
    let found = coverage(rig, take, &regions, None, 3, 3, &NoProgress).unwrap();
    let poses = vec![rig.surface().rest.clone(); 3];
    each_painter(|device, painter| {
        let folder = TempDir::new().unwrap();
        write_plan(
            Page { folder: folder.path(), title: "Anna" },
            "take",
            &found,
            &regions,
            &poses,
            rig,
            Some(painter),
        )
        .unwrap();
        let html = std::fs::read_to_string(folder.path().join("plan.html")).unwrap();
        let page = Html::parse_document(&html);
        let captions: Vec<String> = select(&page, "figcaption").iter().map(text).collect();
        assert_eq!(captions.len(), 3);
        assert_eq!(select(&page, ".findings use").len(), found.enough.min(3));
        for (caption, scan) in captions.iter().zip(&found.scans) {
            assert!(caption.contains(&format!("frame {}, ", scan.frame)), "{caption}");
        }
        // The first scan, which takes away most, is red where it does so. All have one scale.
        for image in select(&page, ".maps svg image").iter().take(2) {
            let picture = decoded(image);
            let is_warm = |p: &[u8; 4]| p[3] == 255 && p[0] > p[1].saturating_add(60);
            assert!(picture.pixels.as_chunks().0.iter().any(is_warm), "{device}: nothing is coloured");
        }
        let dots = select(&page, "circle.dot").len();
        // Over all six pictures.
        assert!(dots > 3 * 89 && dots < 6 * 89, "{dots} markers are not hidden");
    });
}

#[test]
fn handles_are_dots_on_the_neutral() {
    const SIZE: [u32; 2] = [860, 1060];
    let face = rhytid_demo::face(2_000);
    let rest: Vec<[f32; 3]> = face.neutral.positions.iter().map(|p| p.map(|x| x as f32)).collect();
    let at: Vec<[f32; 3]> = face.handles.points.iter().map(|point| point.at(&rest)).collect();
    let doubtful: Vec<bool> = (0..at.len()).map(|i| i % 2 == 1).collect();
    // The place of a marker: before the first vertex that is far from all handles.
    let far =
        |p: &[f32; 3]| at.iter().map(|q| Sphere::around(&[*p, *q]).radius).fold(f32::INFINITY, f32::min);
    let front = rest.iter().filter(|p| p[2] > 0.0).max_by(|a, b| far(a).total_cmp(&far(b))).unwrap();
    let marker = [front[0], front[1], front[2] + 0.2];
    each_painter(|device, painter| {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("handles.png");
        write_handles(&path, &face, &doubtful, &[marker.map(f64::from)], painter).unwrap();
        let picture = Picture::decode(&std::fs::read(&path).unwrap()).unwrap();
        assert_eq!(picture.size, [3 * SIZE[0], SIZE[1] + 44]);
        let lift = LIFT * Sphere::around(&at).radius;
        for (i, turn) in (0..).zip([-50.0, 0.0, 50.0]) {
            let camera = camera(&at, &rest, face.up_axis, turn, SIZE);
            let triangles = rhytid_geometry::triangulate(&face.neutral);
            let hidden = behind(&camera, SIZE, &rest, &triangles, lift, &at);
            let (mut shown, mut right) = (0, 0);
            for (h, point) in at.iter().enumerate().filter(|(h, _)| !hidden[*h]) {
                let [x, y] = place(&camera, SIZE, *point);
                let others = at.iter().enumerate().filter(|(other, _)| *other > h);
                if others
                    .map(|(_, p)| place(&camera, SIZE, *p))
                    .any(|p| p[0].abs_diff(x) < 9 && p[1].abs_diff(y) < 9)
                {
                    continue;
                }
                let [r, g, b, opacity] = picture.pixel([i * SIZE[0] + x, y]);
                let others = if doubtful[h] { g.max(b) } else { r.max(g) };
                let is_right = if doubtful[h] { r } else { b } > others.saturating_add(60);
                right += usize::from(is_right && opacity == 255);
                shown += 1;
            }
            // Except for those that the rim of the hiding surface cuts.
            assert!(shown > 40 && shown - right <= 3, "{device}: {right} of {shown} in view {i}");
            assert_eq!(picture.pixel([i * SIZE[0], 0])[3], 0);
        }
        let [x, y] = place(&camera(&at, &rest, face.up_axis, 0.0, SIZE), SIZE, marker);
        let [r, g, b, _] = picture.pixel([SIZE[0] + x, y]);
        assert!(r > 220 && g > 150 && b < 80, "{device}: yellow at the marker: {r} {g} {b}");
    });
}
