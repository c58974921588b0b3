//! What is shown of markers: names, values, followers, problems.

use super::*;
use image::RgbaImage;
use rhytid_view::Show;

/// The pixels of the window that are nearly of this colour, in sRGB.
fn coloured(picture: &RgbaImage, colour: [u8; 3]) -> usize {
    let is_near = |pixel: &&image::Rgba<u8>| (0..3).all(|c| pixel.0[c].abs_diff(colour[c]) < 24);
    picture.pixels().filter(is_near).count()
}

/// The colour of a selected marker: linear 1, 0.35, 0.
const HELD: [u8; 3] = [255, 160, 0];
/// The colour of a strain that no skin has.
const STRAIN: [u8; 3] = [222, 24, 40];

/// Whether a text of the window has this part.
fn has(view: &View, part: &str) -> bool {
    let contains = |text: Option<String>| text.is_some_and(|text| text.contains(part));
    view.query_all_by(|node| contains(node.label()) || contains(node.value())).next().is_some()
}

/// The window's picture at the place of the face.
fn picture(view: &mut View) -> RgbaImage {
    view.run();
    let picture = view.render().unwrap();
    let scale = view.ctx.pixels_per_point();
    let place = face(view) * scale;
    let [x, y, w, h] = [place.left(), place.top(), place.width(), place.height()].map(|n| n as u32);
    image::imageops::crop_imm(&picture, x, y, w, h).to_image()
}

#[test]
fn a_marker_under_the_pointer_has_a_name_and_values() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    seek(&mut view, 192);
    let handle = demo().1.handles().labels.iter().position(|label| label == "mouth_corner_L").unwrap();
    let label = demo().1.handles().labels[handle].clone();
    assert!(!has(&view, &label));
    view.event(egui::Event::PointerMoved(at(&view, handle)));
    view.run();
    assert!(view.query_by_label(&label).is_some(), "{label}");
    // The values are the distance between the take's position and the rig's.
    let rest = demo().1.handles().rest[handle];
    let now = document(&view).handles(true)[handle];
    let millimetres = 1e3 * demo().1.surface().metres_per_unit as f32;
    let moved: [f32; 3] = std::array::from_fn(|c| millimetres * (now[c] - rest[c]));
    let length = moved.iter().map(|x| x * x).sum::<f32>().sqrt();
    assert!(length > 0.1);
    assert!(has(
        &view,
        &format!("{length:.2} mm from rest ({:.2}, {:.2}, {:.2})", moved[0], moved[1], moved[2])
    ));
    let partner = document(&view).soft_selection().mirror_of(handle).expect("the demo is symmetric");
    let partner = if partner == handle { "middle of the face" } else { &demo().1.handles().labels[partner] };
    assert!(has(&view, partner), "{partner}");
    // The picture shows the partner, too.
    view.event(egui::Event::PointerGone);
    let without = picture(&mut view);
    view.key_press(egui::Key::A);
    let named = picture(&mut view);
    let changed = named.pixels().zip(without.pixels()).filter(|(a, b)| a != b).count();
    assert!(changed > 2_000, "names are beside the markers: {changed}");
}

#[test]
fn followers_have_the_colour_of_what_they_follow() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let handle = handle_in_front(&view);
    let place = at(&view, handle);
    click(&mut view, place, Modifiers::NONE);
    view.event(egui::Event::PointerGone);
    view.state_mut().settings_mut().reach = 0.0;
    let alone = coloured(&picture(&mut view), HELD);
    assert!(alone > 40, "{alone}");
    view.state_mut().settings_mut().reach = 60.0;
    let followed = picture(&mut view);
    // Followers, lines to the neighbours and the ring are orange in part.
    let orange =
        |picture: &RgbaImage| picture.pixels().filter(|p| p.0[0] > 90 && p.0[0] / 2 > p.0[2].max(20)).count();
    view.state_mut().settings_mut().reach = 0.0;
    let few = orange(&picture(&mut view));
    assert!(orange(&followed) > few + 200, "{} and {few}", orange(&followed));
}

#[test]
fn a_strain_that_no_skin_has_is_coloured_where_it_is() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    assert!(has(&view, "none in this frame"));
    assert_eq!(coloured(&picture(&mut view), STRAIN), 0);
    view.state_mut().settings_mut().reach = 0.0;
    let handle = handle_in_front(&view);
    let from = at(&view, handle);
    drag(&mut view, from, from + egui::vec2(160.0, 40.0), Modifiers::NONE);
    view.event(egui::Event::PointerGone);
    let torn = picture(&mut view);
    assert!(coloured(&torn, STRAIN) > 100, "{}", coloured(&torn, STRAIN));
    assert!(has(&view, "is stretched by") && !has(&view, "none in this frame"));
    let handles: Vec<usize> =
        document(&view).problems().iter().flat_map(|problem| problem.handles.clone()).collect();
    assert!(handles.contains(&handle));
    view.key_press_modifiers(Modifiers::COMMAND, egui::Key::Z);
    assert_eq!(coloured(&picture(&mut view), STRAIN), 0);
}

#[test]
fn dots_have_the_same_size_on_a_display_of_twice_the_density() {
    let folder = Folder::new();
    let mut sizes = Vec::new();
    for scale in [1.0, 2.0] {
        let builder = Harness::builder().with_size([700.0, 560.0]).with_pixels_per_point(scale);
        let view = builder.wgpu_setup(setup()).build_eframe(|context| {
            let mut app = ViewApp::new(context).unwrap().with_whole_pictures();
            (app.settings_mut().show, app.settings_mut().reach) = (Show::Wireframe, 0.0);
            app
        });
        let mut view = stand(view, &folder);
        let handle = handle_in_front(&view);
        let place = at_scale(&view, handle, scale);
        click(&mut view, place, Modifiers::NONE);
        view.event(egui::Event::PointerGone);
        // The pixels of the dot in the row through its middle.
        let picture = picture(&mut view);
        let [x, y] = [place.x * scale, place.y * scale].map(|n| n.round() as u32);
        let row = RgbaImage::from_fn(60, 1, |i, _| *picture.get_pixel(x + i - 30, y));
        sizes.push(coloured(&row, HELD));
    }
    assert!((7..12).contains(&sizes[0]) && sizes[1].abs_diff(2 * sizes[0]) < 5, "{sizes:?} pixels");
}

/// The place of a handle in a window of this many pixels a point.
fn at_scale(view: &View, handle: usize, scale: f32) -> Pos2 {
    let rect = face(view);
    let size = [rect.width(), rect.height()].map(|n| (n * scale).round() as u32);
    let camera = view.state().orbit().unwrap().camera();
    let [x, y, _] = camera.project(size, document(view).handles(true)[handle]);
    rect.min + egui::vec2(x, y) / scale
}

#[test]
fn maps_are_lit_and_their_scales_end_at_round_numbers() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    seek(&mut view, 192);
    view.state_mut().settings_mut().markers = false;
    view.state_mut().settings_mut().show = Show::Detail;
    view.state_mut().settings_mut().detail_range = 0.05;
    let lit = picture(&mut view);
    let beyond = "beyond the scale: ";
    assert!(has(&view, beyond) && !has(&view, "beyond the scale: 0.0 %"));
    view.get_by_label("Lit").click();
    let flat = picture(&mut view);
    let colours = |picture: &RgbaImage| {
        let colours: std::collections::HashSet<[u8; 4]> = picture.pixels().map(|pixel| pixel.0).collect();
        colours.len()
    };
    assert!(
        colours(&lit) > 3 * colours(&flat),
        "light has more colours: {} {}",
        colours(&lit),
        colours(&flat)
    );
    view.get_by_label("Fit the scale").click();
    view.run();
    let end = view.state_mut().settings_mut().detail_range;
    assert!(end > 0.05 && has(&view, "beyond the scale: 0.0 %"));
    assert_eq!(rhytid_core::scale::round_up(end), end);
    // In another frame, the scale is the same.
    seek(&mut view, 90);
    assert_eq!(view.state_mut().settings_mut().detail_range, end);
}

#[test]
fn the_keys_are_listed_in_groups_beside_the_face_and_the_title_names_the_files() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    assert_eq!(view.state().title(), "FACE.safetensors, take.csv – Rhytid");
    let before = face(&view);
    view.key_press(egui::Key::H);
    view.run();
    for title in ["Pointer", "Time", "Markers", "Camera", "Look", "Files", "Window"] {
        assert!(view.query_by_label(title).is_some(), "{title}");
    }
    assert_eq!(face(&view), before, "the face stays where it is");
    view.get_by_label("Close the keys").click();
    view.run();
    assert!(view.query_by_label("Pointer").is_none() && view.query_by_label("Mirrored").is_some());
}

/// The demo's performance as a TRC file in which two markers have each other's label in some frames.
fn swapped(folder: &Folder, labels: [&str; 2], frames: std::ops::Range<usize>) -> PathBuf {
    let take = rhytid_demo::performance(&demo().0);
    let column = |label: &str| take.labels.iter().position(|other| other == label).unwrap();
    let [a, b] = labels.map(column);
    let (rate, count, markers) = (take.rate(), take.frames(), take.labels.len());
    let mut text = String::from(
        "PathFileType\t4\t(X/Y/Z)\traw.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n",
    );
    text += &format!("{rate}\t{rate}\t{count}\t{markers}\tmm\nFrame#\tTime");
    take.labels.iter().for_each(|label| text += &format!("\t{label}\t\t"));
    text += "\n\t";
    (1..=markers).for_each(|i| text += &format!("\tX{i}\tY{i}\tZ{i}"));
    text += "\n\n";
    let millimetres = 1e3 * demo().1.surface().metres_per_unit;
    for frame in 0..count {
        text += &format!("{}\t{}", frame + 1, take.times[frame]);
        for marker in 0..markers {
            let from = match marker {
                m if frames.contains(&frame) && m == a => b,
                m if frames.contains(&frame) && m == b => a,
                m => m,
            };
            let at = take.positions[frame * markers + from].map(|x| millimetres * x);
            text += &format!("\t{}\t{}\t{}", at[0], at[1], at[2]);
        }
        text += "\n";
    }
    let path = folder.path("raw.trc");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn markers_that_had_each_others_label_are_coloured_in_these_frames() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let raw = swapped(&folder, ["brow_L2", "lip_low"], 60..90);
    open(&mut view, &[raw]);
    view.key_press(egui::Key::Space);
    view.run();
    let purple = [214, 40, 190];
    seek(&mut view, 75);
    assert!(coloured(&picture(&mut view), purple) > 30, "{:?}", document(&view).problems());
    let problems = document(&view).problems();
    let labels = &demo().1.handles().labels;
    for label in ["brow_L2", "lip_low"] {
        let of =
            |problem: &&rhytid_view::Problem| problem.handles.iter().any(|&handle| labels[handle] == label);
        let problem = problems.iter().find(of).unwrap_or_else(|| panic!("{label}: {problems:?}"));
        assert_eq!(problem.kind, rhytid_view::ProblemKind::Label, "{problem:?}");
        assert!(has(&view, &problem.words));
    }
    seek(&mut view, 120);
    assert_eq!(coloured(&picture(&mut view), purple), 0);
}
