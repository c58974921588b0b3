//! Pictures on every device of this machine, compared with known results.

use crate::each_device;
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{Faces, Materials, UpAxis, Uvs};
use rhytid_render::{
    Anchor, Camera, FrameBuffers, Heat, LEGEND, Look, Mark, Offscreen, Overlay, Picture, Renderer, Sphere,
    Surface, View, letter_scale,
};
use std::sync::Arc;

const NONE: [u8; 4] = [0; 4];

#[derive(Clone)]
struct Mesh {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    numbers: Vec<f32>,
    faces: Faces,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    fn push(&mut self, quad: [u32; 4]) {
        let [a, b, c, d] = quad;
        self.faces.push(&quad);
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// A sheet of n × n quads from −1 to 1 in x and y, facing +Z.
    fn sheet(n: u32) -> Self {
        let at = |i: u32| 2.0 * i as f32 / n as f32 - 1.0;
        let places = (0..=n).flat_map(|y| (0..=n).map(move |x| [x, y]));
        let positions: Vec<[f32; 3]> = places.map(|[x, y]| [at(x), at(y), 0.0]).collect();
        let (normals, numbers) = (vec![[0.0, 0.0, 1.0]; positions.len()], vec![0.0; positions.len()]);
        let mut mesh = Self { positions, normals, numbers, faces: Faces::default(), triangles: Vec::new() };
        for y in 0..n {
            for x in 0..n {
                let v = y * (n + 1) + x;
                mesh.push([v, v + 1, v + n + 2, v + n + 1]);
            }
        }
        mesh
    }

    /// A ball of radius 1: the sheet rolled up.
    fn ball(n: u32) -> Self {
        let mut mesh = Self::sheet(n);
        for (p, normal) in mesh.positions.iter_mut().zip(&mut mesh.normals) {
            let [(s, c), (t, d)] =
                [p[0] * std::f32::consts::PI, p[1] * std::f32::consts::FRAC_PI_2].map(f32::sin_cos);
            *p = [s * d, t, c * d];
            *normal = *p;
        }
        mesh
    }

    fn camera(&self, view: View, size: [u32; 2]) -> Camera {
        Camera::around(Sphere::around(&self.positions), UpAxis::Y, view, size[0] as f32 / size[1] as f32)
    }

    fn draw(&self, wgpu: &Wgpu, camera: &Camera, size: [u32; 2], look: Look) -> Picture {
        let (device, queue) = (wgpu.device(), wgpu.queue());
        let mut renderer =
            Renderer::new(device, queue, &self.faces, &self.triangles, Offscreen::TARGET).unwrap();
        let page = Offscreen::new(device, queue, size).unwrap();
        let frame = FrameBuffers::new(device, queue, self.positions.len()).unwrap();
        frame.set(self.positions.as_flattened(), self.normals.as_flattened(), &self.numbers);
        renderer.show(camera, page.aspect(), look);
        page.draw(NONE, |pass| renderer.draw(pass, frame.vertices())).unwrap()
    }
}

/// 8 bits of sRGB for a linear colour.
fn srgb(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    255.0 * if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

#[track_caller]
fn near(found: [u8; 4], expected: [f32; 3], device: &str) {
    for (found, expected) in found.into_iter().zip(expected.map(srgb)) {
        assert!((f32::from(found) - expected).abs() < 2.0, "{device}: {found:?}, expected {expected:?}");
    }
}

#[test]
fn a_ball_covers_its_disc() {
    let (mesh, size) = (Mesh::ball(256), [400, 300]);
    let camera = mesh.camera(View::default(), size);
    each_device(|device, wgpu| {
        let picture = mesh.draw(wgpu, &camera, size, Look::Smooth);
        let covered: f64 = picture.pixels.iter().skip(3).step_by(4).map(|a| f64::from(*a) / 255.0).sum();
        // The ball just fits into the height.
        let disc = std::f64::consts::PI * 150.0 * 150.0;
        assert!((covered / disc - 1.0).abs() < 0.005, "{device}: {covered} pixels, expected {disc}");
    });
}

/// The light of `shader.wgsl` on a normal in the camera's space.
fn light(n: [f32; 3]) -> f32 {
    let lamp = |from: [f32; 3]| {
        let length = from.iter().map(|x| x * x).sum::<f32>().sqrt();
        (0..3).map(|c| n[c] * from[c] / length).sum::<f32>().max(0.0)
    };
    0.75 * lamp([-0.45, 0.55, 0.7]) + 0.12 * lamp([0.8, 0.0, 0.6]) + 0.09 + 0.05 * n[1]
}

const SKIN: [f32; 3] = [0.85, 0.56, 0.44];

#[test]
fn light_falls_as_it_should_and_the_inside_is_darker() {
    let (mesh, size) = (Mesh::sheet(4), [200, 200]);
    let front = View { lens: 800.0, ..View::default() };
    each_device(|device, wgpu| {
        for look in [Look::Smooth, Look::Gouraud, Look::Flat] {
            let lit = SKIN.map(|part| part * light([0.0, 0.0, 1.0]));
            let camera = mesh.camera(front, size);
            near(mesh.draw(wgpu, &camera, size, look).pixel([100, 100]), lit, device);
            // Turned by 40°, its normal points to the picture's left.
            let camera = mesh.camera(View { turn: 40.0, ..front }, size);
            let (sin, cos) = 40.0_f32.to_radians().sin_cos();
            let turned = SKIN.map(|part| part * light([-sin, 0.0, cos]));
            near(mesh.draw(wgpu, &camera, size, look).pixel([100, 100]), turned, device);
            let camera = mesh.camera(View { turn: 180.0, ..front }, size);
            let behind = mesh.draw(wgpu, &camera, size, look).pixel([100, 100]);
            let expected =
                if look == Look::Gouraud { light([0.0, 0.0, -1.0]) } else { light([0.0, 0.0, 1.0]) };
            near(behind, SKIN.map(|part| 0.3 * part * expected), device);
        }
    });
}

#[test]
fn what_is_nearer_hides_what_is_behind() {
    let mut mesh = Mesh::sheet(1);
    // A smaller sheet in front, which is first in the file. It has another number.
    let small: Vec<[f32; 3]> = mesh.positions.iter().map(|p| [0.4 * p[0], 0.4 * p[1], 0.5]).collect();
    mesh.positions = [small, mesh.positions.clone()].concat();
    mesh.normals = vec![[0.0, 0.0, 1.0]; 8];
    mesh.numbers = [vec![1.0; 4], vec![0.0; 4]].concat();
    mesh.push([4, 5, 7, 6]);
    let size = [300, 300];
    let camera = mesh.camera(View::default(), size);
    let heat = Heat::From0(1.0);
    each_device(|device, wgpu| {
        let picture = mesh.draw(wgpu, &camera, size, Look::Heat(heat));
        near(picture.pixel([150, 150]), heat.colour(1.0), device);
        let [x, y, _] = camera.project(size, [0.8, 0.8, 0.0]);
        near(picture.pixel([x as u32, y as u32]), heat.colour(0.0), device);
        assert_eq!(picture.pixel([2, 2]), [0; 4], "{device}");
    });
}

#[test]
fn numbers_have_the_colours_that_the_legend_says() {
    let (mut mesh, size) = (Mesh::sheet(8), [600, 600]);
    for (i, number) in mesh.numbers.iter_mut().enumerate() {
        *number = (i * 37 % 81) as f32 / 40.0 - 1.0;
    }
    let camera = mesh.camera(View::default(), size);
    for heat in [Heat::From0(0.9), Heat::Signed(1.0)] {
        let look = Look::Heat(heat);
        each_device(|device, wgpu| {
            let picture = mesh.draw(wgpu, &camera, size, look);
            for v in [10, 12, 16, 24, 31, 40, 47, 55, 60, 70] {
                // The pixel's middle is up to 0.7 pixels from the vertex. Its number is interpolated by hand
                // within its triangle.
                let [x, y, _] = camera.project(size, mesh.positions[v]);
                let at = [x as u32, y as u32];
                let pixels = |x: f32| (x - 300.0) / (camera.project(size, [1.0, 0.0, 0.0])[0] - 300.0);
                let place = [pixels(at[0] as f32 + 0.5), -pixels(at[1] as f32 + 0.5)];
                let number = mesh.number_at(place);
                near(picture.pixel(at), heat.colour(number), device);
            }
        });
    }
}

#[test]
fn a_lit_heat_map_has_its_colours_in_the_light() {
    let (mut mesh, size) = (Mesh::sheet(4), [200, 200]);
    mesh.numbers = vec![0.15; mesh.positions.len()];
    let heat = Heat::Signed(0.2);
    let camera = mesh.camera(View { turn: 40.0, lens: 800.0, ..View::default() }, size);
    let (sin, cos) = 40.0_f32.to_radians().sin_cos();
    let expected = heat.colour(0.15).map(|part| part * light([-sin, 0.0, cos]));
    each_device(|device, wgpu| {
        near(mesh.draw(wgpu, &camera, size, Look::LitHeat(heat)).pixel([100, 100]), expected, device);
        near(mesh.draw(wgpu, &camera, size, Look::Heat(heat)).pixel([100, 100]), heat.colour(0.15), device);
    });
}

impl Mesh {
    /// The number at a place of the sheet. It is linear in each triangle.
    fn number_at(&self, [x, y]: [f32; 2]) -> f32 {
        let inside = self.triangles.iter().find_map(|triangle| {
            let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
            let area = |p: [f32; 2], q: [f32; 3], r: [f32; 3]| {
                (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
            };
            let whole = area([a[0], a[1]], b, c);
            let parts = [area([x, y], b, c), area([x, y], c, a), area([x, y], a, b)].map(|part| part / whole);
            let numbers = triangle.map(|v| self.numbers[v as usize]);
            parts.iter().all(|part| *part >= -1e-5).then(|| (0..3).map(|i| parts[i] * numbers[i]).sum())
        });
        inside.expect("a place on the sheet")
    }
}

#[test]
fn wires_are_the_edges_of_polygons_that_are_in_front() {
    let (mesh, size) = (Mesh::sheet(4), [400, 400]);
    let camera = mesh.camera(View::default(), size);
    each_device(|device, wgpu| {
        let picture = mesh.draw(wgpu, &camera, size, Look::Wireframe);
        let brightness = |x: f32, y: f32| {
            let [x, y, _] = camera.project(size, [x, y, 0.0]);
            // Lines are a pixel wide, and may be on either side of their place.
            let near = [[-1, 0], [0, 0], [0, -1], [-1, -1]];
            near.map(|[dx, dy]| picture.pixel([(x as i32 + dx) as u32, (y as i32 + dy) as u32])[1])
                .into_iter()
                .max()
        };
        for at in [-0.8, -0.2, 0.3] {
            assert!(brightness(0.5, at) > Some(110) && brightness(at, -0.5) > Some(110), "{device}");
        }
        // The diagonals that cut the quads are not drawn.
        for (x, y) in [(0.25, 0.25), (-0.25, -0.25), (0.6, 0.6)] {
            assert!(brightness(x, y) < Some(90), "{device}: {:?}", brightness(x, y));
        }
    });
}

#[test]
fn a_background_is_as_it_was_asked_for_and_shows_at_the_rim() {
    let (mesh, size) = (Mesh::sheet(1), [101, 101]);
    // The sheet is turned a little, so its rim runs through pixels.
    let camera = mesh.camera(View { turn: 10.0, raise: 10.0, ..View::default() }, size);
    each_device(|device, wgpu| {
        let (gpu, queue) = (wgpu.device(), wgpu.queue());
        let mut renderer =
            Renderer::new(gpu, queue, &mesh.faces, &mesh.triangles, Offscreen::TARGET).unwrap();
        let page = Offscreen::new(gpu, queue, size).unwrap();
        let frame = FrameBuffers::new(gpu, queue, 4).unwrap();
        frame.set(mesh.positions.as_flattened(), mesh.normals.as_flattened(), &mesh.numbers);
        renderer.show(&camera, 1.0, Look::Heat(Heat::Signed(1.0)));
        let on = |background| page.draw(background, |pass| renderer.draw(pass, frame.vertices())).unwrap();
        let (clear, blue) = (on([0; 4]), on([10, 60, 200, 255]));
        assert_eq!((clear.pixel([0, 0]), blue.pixel([0, 0])), ([0; 4], [10, 60, 200, 255]), "{device}");
        let mut rim = 0;
        for pixel in clear.pixels.chunks(4).filter(|pixel| !matches!(pixel[3], 0 | 255)) {
            // White skin stays white in pixels that it covers by half.
            assert!(pixel[..3].iter().all(|part| *part > 225), "{device}: {pixel:?}");
            rim += 1;
        }
        assert!(rim > 50, "{device}: {rim} pixels of the rim");
    });
}

#[test]
fn the_same_picture_twice_has_the_same_bytes() {
    let (mesh, size) = (Mesh::ball(48), [200, 160]);
    let camera = mesh.camera(View { turn: 20.0, raise: 15.0, ..View::default() }, size);
    each_device(|device, wgpu| {
        for look in [Look::Smooth, Look::Wireframe] {
            let [first, second] = [0; 2].map(|_| mesh.draw(wgpu, &camera, size, look).png().unwrap());
            assert!(first == second, "{device}");
        }
    });
}

#[test]
fn devices_draw_the_same_picture() {
    let (mesh, size) = (Mesh::ball(48), [200, 160]);
    let camera = mesh.camera(View { turn: 20.0, raise: 15.0, ..View::default() }, size);
    for look in [Look::Smooth, Look::Gouraud, Look::Flat, Look::Wireframe, Look::Matcap] {
        let pictures = std::cell::RefCell::new(Vec::new());
        each_device(|device, wgpu| {
            pictures.borrow_mut().push((device.to_owned(), mesh.draw(wgpu, &camera, size, look)));
        });
        let pictures = pictures.into_inner();
        for (device, picture) in &pictures {
            let first = &pictures[0].1.pixels;
            let apart: f64 = first.iter().zip(&picture.pixels).map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
            let mean = apart / first.len() as f64;
            assert!(mean < 1.0, "{device}: {look:?} is {mean} of 255 from {}", pictures[0].0);
        }
    }
}

#[test]
fn marks_are_on_the_skin_and_hidden_behind_it() {
    let (mesh, size) = (Mesh::sheet(1), [300, 300]);
    let camera = mesh.camera(View::default(), size);
    let [red, green, blue] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let marks = [
        Mark::dot([0.5, 0.5, 0.0], red, 20.0),
        Mark { ends: [[-0.8, -0.5, 0.0], [0.8, -0.5, 0.0]], colour: green, width: 8.0 },
        // Too far behind.
        Mark::dot([-0.5, 0.5, -0.2], blue, 20.0),
        // Over the line.
        Mark::dot([0.0, -0.5, 0.0], blue, 12.0),
    ];
    each_device(|device, wgpu| {
        let (gpu, queue) = (wgpu.device(), wgpu.queue());
        let mut renderer =
            Renderer::new(gpu, queue, &mesh.faces, &mesh.triangles, Offscreen::TARGET).unwrap();
        let mut overlay = Overlay::new(gpu, queue, Offscreen::TARGET).unwrap();
        let page = Offscreen::new(gpu, queue, size).unwrap();
        let frame = FrameBuffers::new(gpu, queue, 4).unwrap();
        frame.set(mesh.positions.as_flattened(), mesh.normals.as_flattened(), &[]);
        renderer.show(&camera, 1.0, Look::Smooth);
        overlay.show(&camera, size, 0.05, &marks).unwrap();
        let picture = page
            .draw(NONE, |pass| {
                renderer.draw(pass, frame.vertices())?;
                overlay.draw(pass);
                Ok(())
            })
            .unwrap();
        let at = |x: f32, y: f32, dx: i32, dy: i32| {
            // The lift brings it nearer to the picture's rim.
            let [x, y, _] = camera.project(size, [x, y, 0.05]);
            picture.pixel([(x as i32 + dx) as u32, (y as i32 + dy) as u32])
        };
        for (dx, dy) in [(0, 0), (8, 0), (0, -8), (6, 6)] {
            near(at(0.5, 0.5, dx, dy), red, device);
        }
        let skin = SKIN.map(|part| part * light([0.0, 0.0, 1.0]));
        for (dx, dy) in [(12, 0), (0, 12), (9, 9)] {
            near(at(0.5, 0.5, dx, dy), skin, device);
        }
        near(at(-0.5, 0.5, 0, 0), skin, device);
        near(at(0.4, -0.5, 0, 0), green, device);
        near(at(-0.4, -0.5, 0, 2), green, device);
        near(at(0.4, -0.5, 0, 6), skin, device);
        near(at(0.0, -0.5, 0, 0), blue, device);
    });
}

#[test]
fn a_matcap_is_a_balls_picture_by_direction() {
    let (mut mesh, size) = (Mesh::sheet(4), [200, 200]);
    let ball = Picture::clay();
    let at = |[x, y]: [f32; 2]| {
        let place = |s: f32| ((0.5 + 0.498 * s) * 256.0) as u32;
        let [r, g, b, _] = ball.pixel([place(x), place(-y)]);
        [r, g, b].map(|part| {
            let x = f32::from(part) / 255.0;
            if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
        })
    };
    let camera = mesh.camera(View { lens: 800.0, ..View::default() }, size);
    // Clay is lit from the upper left.
    assert!(at([-0.5, 0.6])[0] > 2.0 * at([0.5, -0.6])[0]);
    each_device(|device, wgpu| {
        for (x, y) in [(0.0, 0.0), (-0.5, 0.6), (0.5, -0.6), (0.0, 0.7)] {
            let normal = [x, y, (1.0_f32 - x * x - y * y).sqrt()];
            let turned = Mesh { normals: vec![normal; mesh.normals.len()], ..mesh.clone() };
            near(turned.draw(wgpu, &camera, size, Look::Matcap).pixel([100, 100]), at([x, y]), device);
        }
    });
    // The inside looks like the outside, but darker.
    for normal in &mut mesh.normals {
        *normal = [0.0, 0.0, 1.0];
    }
    let behind = mesh.camera(View { turn: 180.0, lens: 800.0, ..View::default() }, size);
    each_device(|device, wgpu| {
        let found = mesh.draw(wgpu, &behind, size, Look::Matcap).pixel([100, 100]);
        near(found, at([0.0, 0.0]).map(|part| 0.3 * part), device);
    });
}

/// The sheet with an image whose lower left corner is its own; `materials` of the faces.
fn textured(
    mesh: &Mesh,
    wgpu: &Wgpu,
    camera: &Camera,
    size: [u32; 2],
    (uvs, materials, images): (&Uvs, Option<&Materials>, &[Option<Picture>]),
) -> Picture {
    let (device, queue) = (wgpu.device(), wgpu.queue());
    let mut renderer = Renderer::new(device, queue, &mesh.faces, &mesh.triangles, Offscreen::TARGET).unwrap();
    let images: Vec<_> = images.iter().cloned().map(|image| image.map(Arc::new)).collect();
    let surface = Surface { faces: &mesh.faces, triangles: &mesh.triangles, uvs, materials, images: &images };
    renderer.set_textures(surface).unwrap();
    let page = Offscreen::new(device, queue, size).unwrap();
    let frame = FrameBuffers::new(device, queue, mesh.positions.len()).unwrap();
    frame.set(mesh.positions.as_flattened(), mesh.normals.as_flattened(), &[]);
    renderer.show(camera, page.aspect(), Look::Textured);
    page.draw(NONE, |pass| renderer.draw(pass, frame.vertices())).unwrap()
}

#[test]
fn textures_are_where_their_coordinates_say() {
    // Two quads beside each other, of three columns of vertices.
    let mut mesh = Mesh::sheet(2);
    mesh.faces = Faces::default();
    mesh.triangles.clear();
    [[0, 1, 4, 3], [1, 2, 5, 4]].into_iter().for_each(|quad| mesh.push(quad));
    let size = [400, 400];
    let camera = mesh.camera(View { lens: 800.0, ..View::default() }, size);
    let (red, green, blue, white) = ([255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]);
    // Rows begin at the top: red and green over blue and white. With 64 pixels along each side, the middle of
    // each quarter has exactly its colour.
    let mut image = Picture::filled([64, 64], white);
    for (colour, at) in [(red, [0, 0]), (green, [32, 0]), (blue, [0, 32])] {
        image.put(&Picture::filled([32, 32], colour), at);
    }
    // Each quad has the whole image. So vertices between quads have two places on it.
    let square = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let uvs = Uvs { values: square, corners: Some(vec![0, 1, 2, 3, 0, 1, 2, 3]) };
    let materials = Materials::named(["a", "b"], vec![0, 1]);
    let lit = |colour: [f32; 3]| colour.map(|part| part * light([0.0, 0.0, 1.0]));
    each_device(|device, wgpu| {
        let pixel = |picture: &Picture, x: f32, y: f32| {
            let [x, y, _] = camera.project(size, [x, y, 0.0]);
            picture.pixel([x as u32, y as u32])
        };
        let all = textured(&mesh, wgpu, &camera, size, (&uvs, None, &[Some(image.clone())]));
        for left in [-1.0, 0.0] {
            for (x, y, colour) in [
                (0.2, -0.2, [1.0, 0.0, 0.0]),
                (0.8, -0.2, [0.0, 1.0, 0.0]),
                (0.2, -0.8, [0.0, 0.0, 1.0]),
                (0.8, -0.8, [1.0; 3]),
            ] {
                near(pixel(&all, left + x, y), lit(colour), device);
            }
        }
        // The second material has no image.
        let one =
            textured(&mesh, wgpu, &camera, size, (&uvs, Some(&materials), &[Some(image.clone()), None]));
        near(pixel(&one, -0.8, -0.2), lit([1.0, 0.0, 0.0]), device);
        near(pixel(&one, 0.2, -0.2), lit(SKIN), device);
        // Coordinates per vertex: one image over both quads.
        let over = (0..9).map(|v| [(v % 3) as f32 / 2.0, (v / 3) as f32]).collect();
        let over = Uvs { values: over, corners: None };
        let wide = textured(&mesh, wgpu, &camera, size, (&over, None, &[Some(image.clone())]));
        near(pixel(&wide, -0.2, -0.2), lit([1.0, 0.0, 0.0]), device);
        near(pixel(&wide, 0.2, -0.2), lit([0.0, 1.0, 0.0]), device);
        // A checkerboard finer than pixels is grey: half the light.
        let fine = (0..512 * 512).flat_map(|i| if (i + i / 512) % 2 == 0 { white } else { [0, 0, 0, 255] });
        let fine = Picture { size: [512, 512], pixels: fine.collect() };
        let far = mesh.camera(View { lens: 8.0, ..View::default() }, [40, 40]);
        let grey = textured(&mesh, wgpu, &far, [40, 40], (&uvs, None, &[Some(fine)]));
        let [x, y, _] = far.project([40, 40], [-0.3, -0.5, 0.0]);
        near(grey.pixel([x as u32, y as u32]), lit([0.5; 3]), device);
    });
}

#[test]
fn textures_that_do_not_fit_are_refused() {
    let mesh = Mesh::sheet(1);
    let values = vec![[0.0; 2]; 4];
    each_device(|device, wgpu| {
        let mut renderer =
            Renderer::new(wgpu.device(), wgpu.queue(), &mesh.faces, &mesh.triangles, Offscreen::TARGET)
                .unwrap();
        for corners in [Some(vec![0, 1]), Some(vec![0, 1, 2, 9])] {
            let uvs = Uvs { values: values.clone(), corners };
            let surface = Surface {
                faces: &mesh.faces,
                triangles: &mesh.triangles,
                uvs: &uvs,
                materials: None,
                images: &[],
            };
            let refused = renderer.set_textures(surface).unwrap_err().to_string();
            assert!(refused.contains("texture coordinate"), "{device}: {refused}");
        }
    });
}

#[test]
fn sizes_that_cannot_be_are_refused() {
    each_device(|device, wgpu| {
        for size in [[0, 10], [10, 0], [100_000, 10]] {
            let refused = Offscreen::new(wgpu.device(), wgpu.queue(), size).unwrap_err().to_string();
            assert!(refused.contains("pixels: expected 1 to"), "{device}: {refused}");
        }
    });
}

#[test]
fn a_legend_shows_the_colours_and_their_numbers() {
    let mut picture = Picture::filled([400, 120], [255; 4]);
    let heat = Heat::Signed(0.25);
    picture.legend(heat, "strain", [40, 10], [0; 3], 1);
    for part in [0.01, 0.25, 0.5, 0.75, 0.99] {
        let x = 40 + (part * LEGEND[0] as f32) as u32;
        near(picture.pixel([x, 10 + 24 + 4]), heat.colour(0.5 * part - 0.25), "legend");
    }
    // Words are dark on white, on the left, in the middle and on the right.
    for x in [30..60, 180..200, 320..360] {
        let dark = x.filter(|&x| (46..70).any(|y| picture.pixel([x, y]) == [0, 0, 0, 255])).count();
        assert!(dark > 3, "{dark}");
    }
    let mut small = Picture::filled([20, 20], [0; 4]);
    small.write("beyond the edge", [-30, 10], Anchor::Left, [255; 3], 1);
    small.legend(heat, "strain", [10, 10], [255; 3], 1);
    // Twice the scale has each dot as four.
    let dark = |picture: &Picture| {
        let [width, height] = picture.size;
        let places = (0..width).flat_map(|x| (0..height).map(move |y| [x, y]));
        places.filter(|at| picture.pixel(*at) == [0, 0, 0, 255]).count()
    };
    let [once, twice] = [1, 2].map(|scale| {
        let mut page = Picture::filled([200, 60], [255; 4]);
        page.write("frame 12", [100, 5], Anchor::Center, [0; 3], scale);
        dark(&page)
    });
    assert!(once > 100 && twice == 4 * once, "{once} and {twice}");
    assert_eq!([[320, 240], [900, 900], [1920, 1080], [4096, 4096]].map(letter_scale), [1, 2, 2, 8]);
}
