//! Skin on every device of this machine, compared with physics.

use crate::each_device;
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{Error, Progress, UpAxis};
use rhytid_render::{
    Camera, FrameBuffers, Lights, Offscreen, Picture, Skin, SkinRenderer, Sky, Sphere, Tone, View,
};
use std::f32::consts::PI;
use std::sync::atomic::{AtomicU64, Ordering};

/// With this exposure, a display's white is 1.2 cd/m². A radiance of 1 is thus 1/1.2.
const EXPOSURE: f32 = 0.0;

struct Mesh {
    /// In millimetres.
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A grid of n × n squares from −1 to 1. `place` gives the position and the normal of each point.
    fn grid(n: u32, place: impl Fn(f32, f32) -> ([f32; 3], [f32; 3])) -> Self {
        let at = |i: u32| i as f32 / n as f32 * 2.0 - 1.0;
        let grid = (0..=n).flat_map(|y| (0..=n).map(move |x| [at(x), at(y)]));
        let (positions, normals) = grid.map(|[x, y]| place(x, y)).unzip();
        let triangles = (0..n)
            .flat_map(|y| (0..n).map(move |x| y * (n + 1) + x))
            .flat_map(|v| [[v, v + 1, v + n + 2], [v, v + n + 2, v + n + 1]])
            .collect();
        Self { positions, normals, triangles }
    }

    fn sheet(n: u32, side: f32) -> Self {
        Self::grid(n, |x, y| ([0.5 * side * x, 0.5 * side * y, 0.0], [0.0, 0.0, 1.0]))
    }

    fn ball(n: u32, radius: f32) -> Self {
        Self::grid(n, |x, y| {
            let [(s, c), (t, d)] = [x * PI, y * 0.5 * PI].map(f32::sin_cos);
            let normal = [s * d, t, c * d];
            (normal.map(|x| radius * x), normal)
        })
    }

    fn and(mut self, other: Self) -> Self {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| first + v)));
        self
    }

    fn camera(&self, view: View) -> Camera {
        Camera::around(Sphere::around(&self.positions), UpAxis::Y, view, 1.0)
    }

    fn draw(&self, wgpu: &Wgpu, camera: &Camera, skin: Skin, lights: &Lights) -> Picture {
        let (device, queue) = (wgpu.device(), wgpu.queue());
        let (rest, target) = (&self.positions, Offscreen::TARGET);
        let renderer = SkinRenderer::new(device, queue, rest, &self.triangles, 1.0, target, skin).unwrap();
        let page = Offscreen::new(device, queue, [SIDE; 2]).unwrap();
        let frame = FrameBuffers::new(device, queue, self.positions.len()).unwrap();
        frame.set(self.positions.as_flattened(), self.normals.as_flattened(), &[]);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.light(&mut encoder, frame.vertices(), camera, 1.0, lights).unwrap();
        queue.submit([encoder.finish()]);
        page.draw([0; 4], |pass| {
            renderer.draw(pass, frame.vertices());
            Ok(())
        })
        .unwrap()
    }
}

const SIDE: u32 = 200;

/// The linear colour of a pixel.
fn linear(picture: &Picture, at: [u32; 2]) -> [f32; 3] {
    let [r, g, b, _] = picture.pixel(at);
    [r, g, b].map(|part| {
        let x = f32::from(part) / 255.0;
        if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    })
}

/// The part of even light that one lobe reflects at a cosine. It is the fit that the shader names, with the
/// numbers of its article.
fn thrown_back(reflectance: f32, roughness: f32, cosine: f32) -> f32 {
    let r = [(-1.0, 1.0), (-0.0275, 0.0425), (-0.572, 1.04), (0.022, -0.04)].map(|(a, b)| roughness * a + b);
    let a = (r[0] * r[0]).min((-9.28 * cosine).exp2()) * r[0] + r[1];
    reflectance * (-1.04 * a + r[2]) + 1.04 * a + r[3]
}

fn thrown_back_by(skin: &Skin, cosine: f32) -> f32 {
    let [first, second] = skin.roughness.map(|roughness| thrown_back(skin.reflectance, roughness, cosine));
    skin.first_lobe * first + (1.0 - skin.first_lobe) * second
}

fn white() -> Skin {
    Skin { albedo: [1.0; 3], ..Skin::default() }
}

fn dark() -> Lights {
    Lights {
        key: [0.0; 3],
        sky: Sky::even([0.0; 3]),
        exposure: EXPOSURE,
        tone: Tone::Linear,
        ..Lights::default()
    }
}

#[test]
fn a_white_furnace_throws_back_no_more_than_comes() {
    let ball = Mesh::ball(64, 20.0);
    let camera = ball.camera(View::default());
    let lights = Lights { sky: Sky::even([0.6; 3]), ..dark() };
    each_device(|device, wgpu| {
        let picture = ball.draw(wgpu, &camera, white(), &lights);
        for y in 0..SIDE {
            for x in 0..SIDE {
                let from_middle = (x as f32 - 99.5).hypot(y as f32 - 99.5);
                for part in linear(&picture, [x, y]) {
                    // 0.5 is expected. A little of the light that the surface reflects is lost inside.
                    let least = if from_middle < 90.0 { 0.44 } else { 0.0 };
                    assert!(part < 0.505 && part >= least, "{device}: {part} at {x}, {y}");
                }
            }
        }
    });
}

#[test]
fn the_key_light_falls_and_shines_as_it_should() {
    let sheet = Mesh::sheet(24, 60.0);
    let skin = Skin { albedo: [0.8, 0.5, 0.2], ..Skin::default() };
    each_device(|device, wgpu| {
        for (turn, toward) in [(0.0, [0.0, 0.0, 1.0]), (0.0, [0.6, 0.0, 0.8]), (40.0, [0.0, 0.6, 0.8])] {
            let camera = sheet.camera(View { turn, lens: 2000.0, ..View::default() });
            let lights = Lights { toward, key: [1.5; 3], ..dark() };
            let picture = sheet.draw(wgpu, &camera, skin, &lights);
            // The sheet's normal as the camera sees it. The eye is far away.
            let (sin, cos) = f32::sin_cos(f32::to_radians(turn));
            let (n, eye): ([f32; 3], [f32; 3]) = ([-sin, 0.0, cos], [0.0, 0.0, 1.0]);
            let dot = |a: [f32; 3], b: [f32; 3]| (0..3).map(|c| a[c] * b[c]).sum::<f32>();
            let half: [f32; 3] = std::array::from_fn(|c| eye[c] + toward[c]);
            let length = dot(half, half).sqrt();
            let half = half.map(|x| x / length);
            let (to_light, to_eye) = (dot(n, toward), dot(n, eye));
            let lobe = |roughness: f32| {
                let a2 = roughness.powi(4);
                let d = a2 / (PI * (dot(n, half).powi(2) * (a2 - 1.0) + 1.0).powi(2));
                // Smith's masking of both directions, correlated by height: 1 / (1 + Λ(l) + Λ(v)).
                let lambda = |c: f32| 0.5 * ((1.0 + a2 * (1.0 / (c * c) - 1.0)).sqrt() - 1.0);
                d / (1.0 + lambda(to_light) + lambda(to_eye)) / (4.0 * to_light * to_eye)
            };
            let fresnel = skin.reflectance + (1.0 - skin.reflectance) * (1.0 - dot(eye, half)).powi(5);
            let [first, second] = skin.roughness.map(lobe);
            let shine = fresnel * (skin.first_lobe * first + (1.0 - skin.first_lobe) * second);
            let inside = (1.0 - thrown_back_by(&skin, to_light)) * (1.0 - thrown_back_by(&skin, to_eye));
            let found = linear(&picture, [SIDE / 2; 2]);
            for c in 0..3 {
                let expected = 1.5 * to_light * (skin.albedo[c] / PI * inside + shine) / 1.2;
                assert!(
                    (found[c] - expected).abs() < 0.008,
                    "{device}: {toward:?}: {found:?}, not {expected}"
                );
            }
        }
    });
}

#[test]
fn shadows_are_where_they_should_be_and_nowhere_else() {
    // A square of 8 mm, 10 mm above a sheet, lit from 45° on the right. A ball is beside it.
    let square = Mesh::grid(4, |x, y| ([4.0 * x, 4.0 * y, 10.0], [0.0, 0.0, 1.0]));
    let mesh = Mesh::sheet(120, 60.0).and(square);
    let camera = mesh.camera(View { lens: 2000.0, ..View::default() });
    let at = |x: f32, y: f32| {
        let [x, y, _] = camera.project([SIDE; 2], [x, y, 0.0]);
        [x as u32, y as u32]
    };
    let matt = Skin { reflectance: 0.0, ..white() };
    let lights = Lights { toward: [1.0, 0.0, 1.0], key: [2.0; 3], penumbra: 1.0, ..dark() };
    let half = 0.5_f32.sqrt();
    each_device(|device, wgpu| {
        let picture = mesh.draw(wgpu, &camera, matt, &lights);
        let lit = linear(&picture, at(20.0, 15.0))[1];
        let grazing = 1.0 - thrown_back_by(&matt, half);
        let expected = 2.0 * half * grazing * (1.0 - thrown_back_by(&matt, 1.0)) / PI / 1.2;
        assert!((lit - expected).abs() < 0.01, "{device}: {lit}, not {expected}");
        // Rays at 45° put the shadow as far to the left as the square is high. Red light spreads to its
        // middle by 4 mm from its four sides: 1 − erf(4/√2v)² of each Gaussian, times its weight.
        let outside = 0.078 * (1.0 - 0.858_4_f32.powi(2)) + 0.358 * (1.0 - 0.995_4_f32.powi(2));
        let dark = linear(&picture, at(-10.0, 0.0));
        let off = (dark[0] / lit - outside).abs();
        assert!(off < 0.008 && dark[2] < 0.002, "{device}: {dark:?} of {lit}, not {outside}");
        // Green spreads less than a millimetre, so half of it arrives at the shadow's rims.
        for (x, y) in [(-14.0, 0.0), (-6.0, 0.0), (-10.0, 4.0), (-10.0, -4.0)] {
            let [_, rim, _] = linear(&picture, at(x, y));
            assert!((rim / lit - 0.5).abs() < 0.2, "{device}: {} at {x}, {y}", rim / lit);
        }
        // No other place is darker: no surface shades itself.
        for i in 0..40 {
            for j in 0..40 {
                let (x, y) = (1.4 * i as f32 - 27.0, 1.4 * j as f32 - 27.0);
                let near = (-19.0..9.0).contains(&x) && y.abs() < 9.0;
                let green = linear(&picture, at(x, y))[1];
                assert!(near || (green - lit).abs() < 0.012, "{device}: {green}, not {lit}, at {x}, {y}");
            }
        }
    });
    // A ball is lit up to the places where the light only grazes it.
    let ball = Mesh::ball(96, 40.0);
    let camera = ball.camera(View { lens: 2000.0, ..View::default() });
    each_device(|device, wgpu| {
        let picture = ball.draw(wgpu, &camera, matt, &lights);
        for i in 0..20 {
            let angle = (5.0 * i as f32 - 50.0).to_radians();
            let normal = [angle.sin(), 0.0, angle.cos()];
            let cosine = half * (normal[0] + normal[2]);
            let [x, y, _] = camera.project([SIDE; 2], normal.map(|x| 40.0 * x));
            let found = linear(&picture, [x as u32, y as u32])[2];
            let inside =
                (1.0 - thrown_back_by(&matt, cosine.max(0.0))) * (1.0 - thrown_back_by(&matt, normal[2]));
            let expected = 2.0 * cosine.max(0.0) * inside / PI / 1.2;
            if cosine > 0.1 {
                assert!((found - expected).abs() < 0.03, "{device}: {found}, not {expected}, at {angle}");
            }
        }
    });
}

#[test]
fn a_wall_takes_half_of_the_sky() {
    // A sheet, and a wall of 100 mm on its left.
    let wall = Mesh::grid(40, |x, y| ([-30.0, 30.0 * y, 50.0 + 50.0 * x], [1.0, 0.0, 0.0]));
    let mesh = Mesh::sheet(120, 60.0).and(wall);
    let camera = mesh.camera(View { lens: 2000.0, ..View::default() });
    let matt = Skin { reflectance: 0.0, ..white() };
    let lights = Lights { sky: Sky::even([0.6; 3]), ..dark() };
    each_device(|device, wgpu| {
        let picture = mesh.draw(wgpu, &camera, matt, &lights);
        let at = |x: f32| {
            let [x, y, _] = camera.project([SIDE; 2], [x, 0.0, 0.0]);
            linear(&picture, [x as u32, y as u32])[2]
        };
        let even = 0.5 * (1.0 - thrown_back_by(&matt, 0.5)) * (1.0 - thrown_back_by(&matt, 1.0));
        // The part of the sky that a wall of height h and length l hides from a point at the distance d, by
        // its view factor.
        let hidden = |d: f32| {
            let (h, l) = (100.0_f32, 30.0_f32);
            let c = (h * h + d * d).sqrt();
            // Twice the view factor of half of the wall, on one side of the point.
            ((l / d).atan() - d / c * (l / c).atan()) / PI
        };
        // There are 16 directions on this side.
        for d in [2.0_f32, 10.0, 30.0, 55.0] {
            let (found, expected) = (at(d - 30.0) / even, 1.0 - hidden(d));
            assert!(
                (found - expected).abs() < 0.08,
                "{device}: {found}, not {expected}, {d} mm from the wall"
            );
        }
    });
}

#[test]
fn tones_are_what_their_makers_say() {
    let sheet = Mesh::sheet(8, 60.0);
    let camera = sheet.camera(View { lens: 2000.0, ..View::default() });
    let matt = Skin { reflectance: 0.0, ..white() };
    let inside = (1.0 - thrown_back_by(&matt, 0.5)) * (1.0 - thrown_back_by(&matt, 1.0));
    each_device(|device, wgpu| {
        let shown = |tone, colour: [f32; 3]| {
            let sky = Sky::even(colour.map(|x| 1.2 * x / inside));
            linear(&sheet.draw(wgpu, &camera, matt, &Lights { sky, tone, ..dark() }), [SIDE / 2; 2])
        };
        let near = |found: [f32; 3], expected: [f32; 3]| {
            let off = (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f32::max);
            assert!(off < 0.01, "{device}: {found:?}, expected {expected:?}");
        };
        near(shown(Tone::Linear, [0.2, 0.5, 3.0]), [0.2, 0.5, 1.0]);
        // Colours that are not bright stay unchanged, except for the 4 % that a mirror of 4 % reflects.
        near(shown(Tone::Neutral, [0.2, 0.5, 0.7]), [0.16, 0.46, 0.66]);
        near(shown(Tone::Neutral, [0.04, 0.04, 0.04]), [0.01; 3]);
        // 1.04 is 1 without the mirror. This is 0.24 beyond the knee, which has room for 0.24. Half of the
        // room is used.
        near(shown(Tone::Neutral, [1.04, 1.04, 1.04]), [0.88; 3]);
        // A middle grey is half-way up the display's scale, and a bright colour becomes paler.
        near(shown(Tone::Agx, [0.18; 3]), [0.5_f32.powf(2.2); 3]);
        let [r, g, b] = shown(Tone::Agx, [60.0, 2.0, 2.0]);
        assert!(r > 0.85 && g > 0.2 && (g - b).abs() < 0.02, "{device}: {r} {g} {b}");
    });
}

#[test]
fn devices_draw_the_same_skin_and_twice_the_same_bytes() {
    let ball = Mesh::ball(64, 30.0).and(Mesh::grid(24, |x, y| ([20.0 * x, 20.0 * y, 36.0], [0.0, 0.0, 1.0])));
    let camera = ball.camera(View { turn: 30.0, raise: 10.0, ..View::default() });
    let pictures = std::cell::RefCell::new(Vec::new());
    each_device(|device, wgpu| {
        let [first, second] = [0; 2].map(|_| ball.draw(wgpu, &camera, Skin::default(), &Lights::default()));
        assert!(first == second, "{device}");
        pictures.borrow_mut().push((device.to_owned(), first));
    });
    let pictures = pictures.into_inner();
    for (device, picture) in &pictures {
        let first = &pictures[0].1.pixels;
        let apart: f64 = first.iter().zip(&picture.pixels).map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
        let mean = apart / first.len() as f64;
        assert!(mean < 1.0, "{device}: {mean} of 255 from {}", pictures[0].0);
    }
}

/// Counts the pieces of the work, and stops it after some of them.
struct Counting {
    most: u64,
    seen: AtomicU64,
}

impl Progress for Counting {
    fn report(&self, _: &'static str, done: u64, total: u64) {
        assert!(done <= total, "{done} of {total}");
        self.seen.store(done, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.seen.load(Ordering::Relaxed) >= self.most
    }
}

#[test]
fn light_in_pieces_is_the_same_light_and_a_light_that_is_stopped_changes_nothing() {
    let ball = Mesh::ball(24, 40.0);
    let camera = ball.camera(View::default());
    let (lights, others) = (Lights::default(), Lights { toward: [0.9, -0.3, 0.3], ..Lights::default() });
    each_device(|_, wgpu| {
        let together = |lights| ball.draw(wgpu, &camera, Skin::default(), lights);
        let (first, second) = (together(&lights), together(&others));
        let (device, queue) = (wgpu.device(), wgpu.queue());
        let (rest, target) = (&ball.positions, Offscreen::TARGET);
        let renderer =
            SkinRenderer::new(device, queue, rest, &ball.triangles, 1.0, target, Skin::default()).unwrap();
        let page = Offscreen::new(device, queue, [SIDE; 2]).unwrap();
        let frame = FrameBuffers::new(device, queue, rest.len()).unwrap();
        frame.set(ball.positions.as_flattened(), ball.normals.as_flattened(), &[]);
        let light = |lights: &Lights, most: u64| {
            let counting = Counting { most, seen: AtomicU64::new(0) };
            let lit = renderer.light_in_pieces(frame.vertices(), &camera, 1.0, lights, &counting);
            (lit, counting.seen.into_inner())
        };
        let draw = || {
            let draw = |pass: &mut wgpu::RenderPass<'_>| {
                renderer.draw(pass, frame.vertices());
                Ok(())
            };
            page.draw([0; 4], draw).unwrap()
        };
        let (lit, pieces) = light(&lights, u64::MAX);
        lit.unwrap();
        assert!(pieces > 33, "{pieces} pieces: the lights and the steps of the spreading");
        assert_eq!(draw(), first);
        // It is stopped in the middle, after the shadows and some steps.
        let (stopped, _) = light(&others, pieces / 2 + 10);
        assert!(matches!(stopped, Err(Error::Cancelled)));
        renderer.aim(&camera, 1.0, &lights);
        assert_eq!(draw(), first, "the light of the last frame stays whole");
        light(&others, u64::MAX).0.unwrap();
        assert_eq!(draw(), second);
        assert_ne!(first, second);
    });
}
