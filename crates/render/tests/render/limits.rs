//! Devices that allow less than is needed: the error is one sentence, and nothing panics.

use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{Backend, Error, Faces, Result, UpAxis};
use rhytid_render::{
    Camera, FrameBuffers, Mark, Offscreen, Overlay, Picture, Renderer, Skin, SkinRenderer, View,
};

/// A device of every adapter of this machine, with limits reduced by `lower`.
fn each_device(lower: impl Fn(&mut wgpu::Limits), test: impl Fn(&wgpu::Device, &wgpu::Queue)) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let devices = Wgpu::devices().unwrap();
    assert!(!devices.is_empty(), "there is no device of wgpu's here");
    let is_listed = |adapter: &wgpu::Adapter| devices.iter().any(|device| Wgpu::is(adapter, device));
    for adapter in adapters.into_iter().filter(is_listed) {
        let mut limits = wgpu::Limits::default().or_worse_values_from(&adapter.limits());
        lower(&mut limits);
        let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
        // An error that no scope catches would be a panic.
        test(&device, &queue);
    }
}

/// A sheet of n × n quads.
fn sheet(n: u32) -> (Vec<[f32; 3]>, Faces, Vec<[u32; 3]>) {
    let rest = (0..=n).flat_map(|y| (0..=n).map(move |x| [x as f32, y as f32, 0.0])).collect();
    let (mut faces, mut triangles) = (Faces::default(), Vec::new());
    for v in (0..n).flat_map(|y| (0..n).map(move |x| y * (n + 1) + x)) {
        let [a, b, c, d] = [v, v + 1, v + n + 2, v + n + 1];
        faces.push(&[a, b, c, d]);
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    (rest, faces, triangles)
}

/// Asserts that the error is one sentence that names the limit, the need, what there is, and what to do.
#[track_caller]
fn assert_refused<T>(result: Result<T>, words: &[&str]) {
    let Err(Error::Input(said)) = result.map(|_| ()) else { panic!("expected a sentence: {words:?}") };
    assert!(!said.sentence().contains('\n') && said.sentence().len() < 250, "{said}");
    for words in words {
        assert!(said.sentence().contains(words), "{words}: {said}");
    }
}

#[test]
fn a_mesh_that_is_too_large_is_refused() {
    // 40 × 40 quads: 1,681 vertices, 3,200 triangles, 3,280 edges.
    let (rest, faces, triangles) = sheet(40);
    let skin = |device: &wgpu::Device, queue: &wgpu::Queue| {
        SkinRenderer::new(device, queue, &rest, &triangles, 1.0, Offscreen::TARGET, Skin::default())
    };
    let with = |bytes: u64| move |limits: &mut wgpu::Limits| limits.max_buffer_size = bytes;
    each_device(with(38_399), |device, queue| {
        assert_refused(
            Renderer::new(device, queue, &faces, &triangles, Offscreen::TARGET),
            &["1,600 faces", "max_buffer_size of 38,400", "allows 38,399", "fewer vertices"],
        );
    });
    each_device(with(38_400), |device, queue| {
        Renderer::new(device, queue, &faces, &triangles, Offscreen::TARGET).unwrap();
    });
    each_device(with(20_171), |device, queue| {
        assert_refused(
            FrameBuffers::new(device, queue, rest.len()),
            &["1,681 vertices", "max_buffer_size of 20,172", "allows 20,171", "fewer vertices"],
        );
        assert_refused(skin(device, queue), &["skin on 1,681 vertices", "without skin"]);
    });
    each_device(with(20_172), |device, queue| {
        FrameBuffers::new(device, queue, rest.len()).unwrap();
    });
    // Each vertex has 16 bytes of light, and 8 bytes for each link to a neighbour. In a sheet of squares a
    // vertex has 4 links.
    let binding = |bytes| move |limits: &mut wgpu::Limits| limits.max_storage_buffer_binding_size = bytes;
    each_device(binding(26_895), |device, queue| {
        let words = ["max_storage_buffer_binding_size of 26,896", "allows 26,895", "draw without skin"];
        assert_refused(skin(device, queue), &words);
    });
    each_device(binding(8 * 6_400 - 4), |device, queue| {
        let words = ["skin on 1,681 vertices", "max_storage_buffer_binding_size of", "allows 51,196"];
        assert_refused(skin(device, queue), &words);
    });
    each_device(binding(8 * 8 * 1_681), |device, queue| {
        skin(device, queue).unwrap();
    });
}

#[test]
fn a_device_without_kernels_draws_but_has_no_skin() {
    let (rest, faces, triangles) = sheet(4);
    let lower = |limits: &mut wgpu::Limits| limits.max_storage_buffers_per_shader_stage = 4;
    each_device(lower, |device, queue| {
        let skin =
            SkinRenderer::new(device, queue, &rest, &triangles, 1.0, Offscreen::TARGET, Skin::default());
        let words = ["max_storage_buffers_per_shader_stage of 5", "allows 4", "draw without skin"];
        assert_refused(skin, &words);
        let renderer = Renderer::new(device, queue, &faces, &triangles, Offscreen::TARGET).unwrap();
        let page = Offscreen::new(device, queue, [20, 20]).unwrap();
        let frame = FrameBuffers::new(device, queue, rest.len()).unwrap();
        page.draw([0; 4], |pass| renderer.draw(pass, frame.vertices())).unwrap();
    });
}

#[test]
fn pictures_images_and_marks_that_are_too_large_are_refused() {
    let lower = |limits: &mut wgpu::Limits| {
        limits.max_buffer_size = 1 << 16;
        limits.max_texture_dimension_2d = 1024;
    };
    let (rest, faces, triangles) = sheet(4);
    each_device(lower, |device, queue| {
        let page = |size| Offscreen::new(device, queue, size);
        assert_refused(page([1025, 8]), &["1025 × 8 pixels", "1 to 1024"]);
        assert_refused(page([0, 8]), &["0 × 8 pixels", "1 to 1024"]);
        // A row has a multiple of 256 bytes.
        assert_refused(page([65, 129]), &["65 × 129", "max_buffer_size of 66,048", "a smaller picture"]);
        page([65, 128]).unwrap();
        let mut renderer = Renderer::new(device, queue, &faces, &triangles, Offscreen::TARGET).unwrap();
        let ball = Picture::filled([8, 1025], [0; 4]);
        let words = ["an image of 8 × 1025 pixels", "max_texture_dimension_2d of 1,025", "make it smaller"];
        assert_refused(renderer.set_matcap(&ball), &words);
        let mut overlay = Overlay::new(device, queue, Offscreen::TARGET).unwrap();
        let camera = Camera::framing(&rest, UpAxis::Y, View::default(), 1.0);
        let marks = vec![Mark::dot([0.0; 3], [1.0; 3], 4.0); 2_000];
        assert_refused(overlay.show(&camera, [20, 20], 0.0, &marks), &["2,000 marks", "draw fewer"]);
        overlay.show(&camera, [20, 20], 0.0, &marks[..1_000]).unwrap();
    });
}
