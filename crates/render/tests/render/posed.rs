//! A rig in textures: evaluated while it is drawn, within the limits of WebGL 2.

use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{Animator, Backend, BasisStorage, NoProgress, Rig, Stage, UploadOptions};
use rhytid_render::{Camera, Look, Offscreen, Picture, Renderer, Vertices, View};
use rhytid_solve::solve;
use rhytid_test_support::changed;

/// A plain rig, one whose handles turn, and one whose large scale has much to take back beyond the reach.
fn rigs() -> [(&'static str, Rig); 3] {
    let mut face = rhytid_demo::face(3_000);
    let plain = solve(&face, &NoProgress).unwrap().rounded().unwrap();
    let limited = changed(&plain, |parts| {
        let learned = parts.learned.as_mut().unwrap();
        learned.reach = 1.0;
        learned.feature_gains = learned.feature_gains.map(|_| 0.05);
    });
    face.settings.rotations = true;
    let turning = solve(&face, &NoProgress).unwrap().rounded().unwrap();
    [("plain", plain), ("turning", turning), ("limited", limited.unwrap())]
}

/// Rest, an example, and twice that example, which is beyond the reach.
fn frames(rig: &Rig) -> [Vec<f32>; 3] {
    let rest = rig.handles().rest.as_flattened();
    let example = rig.examples().handles.row(1).as_flattened();
    [0.0, 1.0, 2.0].map(|part| rest.iter().zip(example).map(|(r, e)| r + part * (e - r)).collect())
}

/// Where the kernels have a frame's vertices, and a picture of them in each look.
struct Expected {
    positions: Vec<[f32; 3]>,
    pictures: Vec<Picture>,
}

const LOOKS: [Look; 2] = [Look::Smooth, Look::Flat];

/// By kernels, the frames of each rig.
fn expected(wgpu: &Wgpu, rig: &Rig) -> Vec<Expected> {
    let options = UploadOptions { max_frames: 1, basis: BasisStorage::Clustered };
    let mut animator = Animator::new(wgpu, rig, options).unwrap();
    let page = Offscreen::new(wgpu.device(), wgpu.queue(), [240, 300]).unwrap();
    let (mut renderer, camera) = prepared(wgpu.device(), wgpu.queue(), rig, &page);
    let mut all = Vec::new();
    for frame in frames(rig) {
        animator.evaluate(&frame).unwrap();
        let mut positions = Vec::new();
        animator.read(Stage::Positions, &mut positions).unwrap();
        let result = |stage| animator.session().results(stage).next().unwrap().1.slice(..);
        let [positions_there, normals] = [Stage::Positions, Stage::Normals].map(result);
        let mut pictures = Vec::new();
        for look in LOOKS {
            let vertices = Vertices { positions: positions_there, normals, numbers: None };
            renderer.show(&camera, page.aspect(), look);
            pictures.push(page.draw([0; 4], |pass| renderer.draw(pass, vertices)).unwrap());
        }
        all.push(Expected { positions: positions.as_chunks().0.to_vec(), pictures });
    }
    all
}

fn prepared(device: &wgpu::Device, queue: &wgpu::Queue, rig: &Rig, page: &Offscreen) -> (Renderer, Camera) {
    let surface = rig.surface();
    let target = Offscreen::TARGET;
    let renderer = Renderer::new(device, queue, &surface.faces, &surface.triangles, target).unwrap();
    (renderer, Camera::framing(&surface.rest, surface.up_axis, View::default(), page.aspect()))
}

/// Adapters of this machine, each with what a browser with WebGL 2 has: no compute shaders and no storage
/// buffers.
fn each_small_device(test: impl Fn(&str, &wgpu::Device, &wgpu::Queue)) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let devices = Wgpu::devices().unwrap();
    for adapter in adapters.iter().filter(|adapter| devices.iter().any(|device| Wgpu::is(adapter, device))) {
        let limits = wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits());
        assert_eq!(
            limits.max_storage_buffers_per_shader_stage + limits.max_compute_workgroups_per_dimension,
            0
        );
        let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
        test(&adapter.get_info().name, &device, &queue);
    }
}

#[test]
fn shaders_that_draw_evaluate_the_rig_as_kernels_do() {
    let devices = Wgpu::devices().unwrap();
    let wgpu = Wgpu::open(devices.first().expect("a device of wgpu's")).unwrap();
    for (name, rig) in rigs() {
        let expected = expected(&wgpu, &rig);
        let size = rig.surface().rest.as_flattened().iter().fold(0.0_f32, |size, x| size.max(x.abs()));
        each_small_device(|device, wgpu_device, queue| {
            let page = Offscreen::new(wgpu_device, queue, [240, 300]).unwrap();
            let (mut renderer, camera) = prepared(wgpu_device, queue, &rig, &page);
            renderer.set_rig(&rig).unwrap();
            for (i, (frame, expected)) in frames(&rig).iter().zip(&expected).enumerate() {
                let at = format!("{device}: {name}, frame {i}");
                renderer.pose(frame).unwrap();
                renderer.place().unwrap();
                let placed = renderer.read_placed().unwrap();
                assert_eq!(placed.len(), rig.vertices());
                let apart = placed.as_flattened().iter().zip(expected.positions.as_flattened());
                let apart = apart.fold(0.0_f32, |apart, (a, b)| apart.max((a - b).abs()));
                assert!(apart < 3e-6 * size, "{at}: {apart} of {size}");
                for (look, expected) in LOOKS.into_iter().zip(&expected.pictures) {
                    renderer.show(&camera, page.aspect(), look);
                    let picture = page.draw([0; 4], |pass| renderer.draw_posed(pass)).unwrap();
                    let pixels = picture.pixels.iter().zip(&expected.pixels);
                    let apart: f64 = pixels.map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
                    let mean = apart / picture.pixels.len() as f64;
                    assert!(mean < 0.3, "{at}: {look:?} is {mean} of 255 from that of the kernels");
                }
            }
        });
        // The frames differ by far more than what is allowed.
        let [rest, example] = [0, 1].map(|i| expected[i].positions.as_flattened());
        assert!(rest.iter().zip(example).any(|(a, b)| (a - b).abs() > 0.01 * size));
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let rig = solve(&rhytid_demo::face(1_000), &NoProgress).unwrap().rounded().unwrap();
    let mut by_chapter = rhytid_demo::face(1_000);
    by_chapter.settings.method = rhytid_core::Method::Chapter;
    let by_chapter = solve(&by_chapter, &NoProgress).unwrap().rounded().unwrap();
    let finer = solve(&rhytid_demo::face(3_000), &NoProgress).unwrap().rounded().unwrap();
    each_small_device(|_, device, queue| {
        let page = Offscreen::new(device, queue, [20, 20]).unwrap();
        let (mut renderer, camera) = prepared(device, queue, &rig, &page);
        let said = |result: rhytid_core::Result<()>| result.unwrap_err().to_string();
        let rest = rig.handles().rest.as_flattened();
        assert!(said(renderer.pose(rest)).contains("the renderer was given none"));
        assert!(said(renderer.set_rig(&by_chapter)).contains("solve it by the learned method"));
        assert!(said(renderer.set_rig(&finer)).contains("the renderer was made for a mesh of"));
        renderer.set_rig(&rig).unwrap();
        assert!(said(renderer.pose(&rest[1..])).contains("three for each handle"));
        let mut unknown = rest.to_vec();
        unknown[4] = f32::NAN;
        assert!(said(renderer.pose(&unknown)).contains("finite"));
        let drawn = |renderer: &mut Renderer, look| {
            renderer.show(&camera, 1.0, look);
            said(page.draw([0; 4], |pass| renderer.draw_posed(pass)).map(|_| ()))
        };
        renderer.pose(rest).unwrap();
        renderer.place().unwrap();
        assert!(drawn(&mut renderer, Look::Wireframe).contains("smooth or flat"));
        // The vertices are those of the frame before.
        renderer.pose(rest).unwrap();
        assert!(drawn(&mut renderer, Look::Smooth).contains("not placed"));
    });
}
