//! Meshes and animations that are shown without a rig.

use super::pictures::{differ, expected, shown};
use super::*;
use rhytid_backend_cpu::Cpu;
use rhytid_core::{Animator, Stage, UploadOptions};
use rhytid_formats::animation;
use rhytid_formats::export::{Frame, Scene, Shape, Shapes, StatedRecipe};
use rhytid_formats::mesh;
use rhytid_view::Show;

/// Every so many frames of the take are exported.
const EVERY: usize = 20;

/// The handle positions of the exported frames.
fn exported() -> Vec<Vec<[f32; 3]>> {
    let (face, rig) = demo();
    let all = rhytid_demo::performance(face).handle_positions(&rig.handles().labels).unwrap();
    let frames = all.chunks_exact(3 * rig.handles().len()).step_by(EVERY);
    frames.map(|frame| frame.as_chunks::<3>().0.to_vec()).collect()
}

/// Exports some frames of the demo's take at 10 frames per second.
fn export(path: &std::path::Path) {
    let rig = &demo().1;
    let cpu = Cpu::open(&Cpu::devices().unwrap()[0]).unwrap();
    let mut animator = Animator::new(&cpu, rig, UploadOptions::frames(1)).unwrap();
    let recipe = StatedRecipe::default();
    let (surface, frames) = (rig.surface(), exported());
    let scene = Scene {
        name: "demo",
        rest: &surface.rest,
        rest_normals: None,
        channels: &[],
        faces: &surface.faces,
        triangle_corners: &surface.triangle_corners().unwrap(),
        uvs: None,
        materials: None,
        head: None,
        metres_per_unit: surface.metres_per_unit,
        up_axis: surface.up_axis,
        frames: frames.len(),
        rate: 10.0,
        first_time_code: 0.0,
        recipe: &recipe,
        further: &[],
    };
    let mut exporter = animation::create(path, &scene, &Default::default()).unwrap();
    let mut positions = Vec::new();
    for frame in &frames {
        animator.evaluate(frame.as_flattened()).unwrap();
        animator.read(Stage::Positions, &mut positions).unwrap();
        exporter.frame(&Frame::new(&positions)).unwrap();
    }
    exporter.finish(&NoProgress).unwrap();
}

/// The part of the face's picture that differs from the rig's with these handles.
fn off(view: &mut View, handles: &[[f32; 3]]) -> f64 {
    let picture = shown(view);
    let size = [picture.width(), picture.height()];
    let background = view.ctx.global_style().visuals.extreme_bg_color.to_array();
    let other = expected(&view.state().orbit().unwrap().camera(), size, background, handles);
    differ(&picture, |x, y| other.pixel([x, y]), 3)
}

/// What the last line says, which is no error.
fn said(view: &View) -> &str {
    let (said, is_error) = view.state().note().expect("a sentence");
    assert!(!is_error, "{said}");
    said
}

#[test]
fn a_mesh_is_shown_as_it_is_and_its_markers_are_not_missed() {
    let folder = Folder::new();
    let (face, rig) = demo();
    mesh::write_obj(&folder.path("neutral.obj"), &face.neutral).unwrap();
    let mut view = window([900.0, 700.0], false);
    open(&mut view, &[folder.path("neutral.obj")]);
    view.run();
    assert!(document(&view).is_mesh());
    assert!(
        said(&view).contains("is a mesh of") && said(&view).contains("make a project"),
        "{}",
        said(&view)
    );
    let far = off(&mut view, &rig.handles().rest);
    assert!(far < 5e-5, "{far} of the pixels differ, or have the dot of a marker");

    // Markers can be neither selected nor dragged, and the panel says why.
    view.get_by_label_contains("no markers");
    view.key_press(egui::Key::N);
    view.run();
    assert!(view.state().selected().is_empty());
    let (from, before) = (super::face(&view).center(), view.state().orbit().unwrap().clone());
    drag(&mut view, from, from + egui::vec2(40.0, 0.0), Modifiers::NONE);
    view.run();
    assert_ne!(*view.state().orbit().unwrap(), before, "the drag turns the mesh");

    // Looks that need a rig say so. The others are drawn.
    for key in [egui::Key::F6, egui::Key::F7, egui::Key::F9] {
        view.key_press(key);
        view.run();
        assert_eq!(view.state_mut().settings_mut().show, Show::Shaded);
        assert!(said(&view).contains("need a rig"), "{}", said(&view));
    }
    let shaded = shown(&mut view);
    for key in [egui::Key::F3, egui::Key::F4, egui::Key::F5, egui::Key::F8, egui::Key::F2] {
        view.key_press(key);
        view.run();
        let picture = shown(&mut view);
        let other = differ(&picture, |x, y| shaded.get_pixel(x, y).0, 6);
        assert!(other > 0.02, "{key:?} looks as shaded: {other}");
    }

    // A take needs a rig. With the rig there are markers again.
    open(&mut view, &[folder.path("take.csv")]);
    assert!(view.state().note().unwrap().0.contains("open a rig first"), "{:?}", view.state().note());
    let mut view = stand(view, &folder);
    assert!(!document(&view).is_mesh());
    view.key_press(egui::Key::N);
    view.run();
    assert_eq!(view.state().selected().len(), 1);
}

#[test]
fn an_animation_is_played_as_its_file_has_it() {
    let folder = Folder::new();
    let frames = exported();
    for name in ["moves.usd", "moves.usda", "moves.glb", "moves.gltf"] {
        export(&folder.path(name));
        let mut view = window([900.0, 700.0], false);
        open(&mut view, &[folder.path(name)]);
        assert!(said(&view).contains(&format!("animation of {} frames", frames.len())), "{}", said(&view));
        assert!(document(&view).is_mesh());
        assert!(document(&view).transport.playing, "it plays at once");
        assert_eq!(document(&view).transport.frames(), frames.len());
        view.key_press(egui::Key::Space);
        for frame in [7, 3] {
            view.key_press(egui::Key::Home);
            for _ in 0..frame {
                view.key_press(egui::Key::Period);
            }
            view.run();
            assert_eq!(document(&view).transport.frame(), frame);
            let [here, elsewhere] = [frame, frame - 1].map(|frame| off(&mut view, &frames[frame]));
            assert!(here < 0.002 && elsewhere > 0.01, "{name}, frame {frame}: {here} {elsewhere}");
        }
        assert!((document(&view).transport.time() - 0.3).abs() < 1e-9, "at 10 frames per second");
    }
}

#[test]
fn shapes_foreign_files_and_folders_have_a_next_step() {
    let folder = Folder::new();
    let (face, rig) = demo();
    let surface = rig.surface();
    let recipe = StatedRecipe::default();
    let shapes = Shapes {
        name: "demo",
        rest: &surface.rest,
        rest_normals: None,
        faces: &surface.faces,
        triangle_corners: &surface.triangle_corners().unwrap(),
        uvs: None,
        materials: None,
        metres_per_unit: surface.metres_per_unit,
        up_axis: surface.up_axis,
        recipe: &recipe,
        shapes: &[Shape {
            name: "up".into(),
            offsets: vec![[0.0, 0.1, 0.0]; surface.rest.len()],
            normal_offsets: None,
        }],
    };
    for name in ["shapes.glb", "shapes.usda"] {
        animation::write_shapes(&folder.path(name), &shapes, &Default::default(), &NoProgress).unwrap();
    }
    std::fs::write(folder.path("foreign.glb"), rhytid_test_support::glb(&face.neutral)).unwrap();
    let mut view = window([900.0, 700.0], false);
    for (name, words) in [
        ("shapes.glb", "1 blend shape becomes an example"),
        ("shapes.usda", "1 blend shape becomes an example"),
        ("foreign.glb", "is shown at rest"),
    ] {
        open(&mut view, &[folder.path(name)]);
        view.run();
        assert!(
            said(&view).contains(words) && said(&view).contains("make a project"),
            "{name}: {}",
            said(&view)
        );
        assert_eq!(document(&view).rig.vertices(), surface.rest.len());
        assert!(!document(&view).transport.playing);
    }
    let scans = folder.path("scans");
    std::fs::create_dir(&scans).unwrap();
    mesh::write_obj(&scans.join("neutral.obj"), &face.neutral).unwrap();
    open(&mut view, &[scans]);
    let (said, is_error) = view.state().note().unwrap();
    assert!(
        is_error && said.contains("is a folder with 1 mesh;") && said.contains("make a project"),
        "{said}"
    );
    assert!(document(&view).is_mesh(), "what was open stays");
}
