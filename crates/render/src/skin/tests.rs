//! The spread of light, compared with closed forms.

use super::diffusion::{Diffusion, Effort};
use super::pieces::Pieces;
use super::profile::SKIN_PROFILE;
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::Backend;
use rhytid_geometry::laplacian::laplacian;
use std::f64::consts::PI;

fn effort(longest: usize) -> Effort {
    Effort { always: longest, longest, spared: 0.0 }
}

struct Mesh {
    /// In millimetres.
    rest: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// A plane of (2 m + 1) × (2 n + 1) vertices `h` apart, with 0, 0 in its middle.
fn plane(m: i32, n: i32, h: f32) -> Mesh {
    let rest = (-n..=n).flat_map(|y| (-m..=m).map(move |x| [h * x as f32, h * y as f32, 0.0])).collect();
    let across = 2 * m as u32 + 1;
    let triangles = (0..2 * n as u32)
        .flat_map(|y| (0..2 * m as u32).map(move |x| y * across + x))
        .flat_map(|v| [[v, v + 1, v + across + 1], [v, v + across + 1, v + across]])
        .collect();
    Mesh { rest, triangles }
}

/// A ball of `radius`: an octahedron whose faces are cut `n` times each way.
fn ball(n: u32, radius: f64) -> Mesh {
    let mut rest: Vec<[f32; 3]> = Vec::new();
    let mut index = std::collections::HashMap::new();
    let mut triangles = Vec::new();
    for signs in 0..8 {
        let sign = |bit: u32| if signs >> bit & 1 == 0 { 1 } else { -1 };
        let mut at = |i: u32, j: u32| {
            let grid = [sign(0) * i as i32, sign(1) * j as i32, sign(2) * (n - i - j) as i32];
            *index.entry(grid).or_insert_with(|| {
                // This spaces the vertices more evenly than on the octahedron's faces.
                let [x, y, z] = grid.map(f64::from);
                let p = [x, y, z].map(|c| c.signum() * (0.5 * PI * c.abs() / f64::from(n)).sin());
                let length = p.iter().map(|c| c * c).sum::<f64>().sqrt();
                rest.push(p.map(|c| (radius * c / length) as f32));
                rest.len() as u32 - 1
            })
        };
        let flips = sign(0) * sign(1) * sign(2) < 0;
        for i in 0..n {
            for j in 0..n - i {
                let mut push =
                    |[a, b, c]: [u32; 3]| triangles.push(if flips { [a, c, b] } else { [a, b, c] });
                push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < n {
                    push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    Mesh { rest, triangles }
}

impl Mesh {
    /// Spreads the light at the vertices on each device of this machine.
    fn each_device(&self, light: &[[f32; 3]], test: impl Fn(&str, &[[f32; 4]])) {
        let devices = Wgpu::devices().unwrap();
        assert!(!devices.is_empty(), "there is no device of wgpu's here");
        for info in devices {
            let wgpu = Wgpu::open(&info).unwrap();
            let (device, queue) = (wgpu.device(), wgpu.queue());
            // The mesh unit is a centimetre.
            let rest: Vec<[f32; 3]> = self.rest.iter().map(|p| p.map(|x| 0.1 * x)).collect();
            let diffusion =
                Diffusion::new(device, queue, &rest, &self.triangles, 10.0, &SKIN_PROFILE, effort(512))
                    .unwrap();
            assert_eq!(diffusion.too_fine, 0.0);
            let light: Vec<[f32; 4]> = light.iter().map(|[r, g, b]| [*r, *g, *b, 0.0]).collect();
            test(&format!("{} {}", info.name, info.driver), &run(&wgpu, &diffusion, &light));
        }
    }
}

fn run(wgpu: &Wgpu, diffusion: &Diffusion, light: &[[f32; 4]]) -> Vec<[f32; 4]> {
    let (device, queue) = (wgpu.device(), wgpu.queue());
    queue.write_buffer(&diffusion.light, 0, bytemuck::cast_slice(light));
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    diffusion.run(&mut Pieces::Together(&mut encoder)).unwrap();
    let size = 16 * light.len() as u64;
    let read = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    encoder.copy_buffer_to_buffer(&diffusion.spread, 0, &read, 0, size);
    queue.submit([encoder.finish()]);
    read.map_async(wgpu::MapMode::Read, .., |_| ());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let spread: Vec<[f32; 4]> = bytemuck::cast_slice(&read.get_mapped_range(..).unwrap()).to_vec();
    spread
}

/// The normal distribution up to `x`, by Simpson's rule.
fn normal(x: f64) -> f64 {
    let (from, steps) = (-9.0, 2000);
    if x <= from {
        return 0.0;
    }
    let h = (x - from) / f64::from(steps);
    let density = |i: i32| (-0.5 * (from + h * f64::from(i)).powi(2)).exp();
    let sum: f64 = (0..=steps)
        .map(|i| if i == 0 || i == steps { 1.0 } else { f64::from(2 + 2 * (i % 2)) } * density(i))
        .sum();
    sum * h / 3.0 / (2.0 * PI).sqrt()
}

#[test]
fn the_edge_of_a_shadow_is_as_soft_as_the_profile_says() {
    let mesh = plane(400, 2, 0.05);
    // The right side is lit. The edge is half-way between two vertices.
    let lit = |p: &[f32; 3]| [if p[0] > 0.02 { 1.0 } else { 0.0 }; 3];
    let light: Vec<[f32; 3]> = mesh.rest.iter().map(lit).collect();
    mesh.each_device(&light, |device, spread| {
        let mut worst = [0.0_f64; 3];
        for (p, spread) in mesh.rest.iter().zip(spread) {
            let x = f64::from(p[0]) - 0.025;
            for c in 0..3 {
                let expected: f64 =
                    SKIN_PROFILE.iter().map(|g| g.weights[c] * normal(x / g.variance.sqrt())).sum();
                worst[c] = worst[c].max((f64::from(spread[c]) - expected).abs());
            }
        }
        println!("{device}: {worst:.4?}");
        assert!(worst.iter().all(|worst| *worst < 0.01), "{device}: {worst:?}");
    });
}

#[test]
fn a_point_of_light_becomes_the_profile() {
    let h = 0.13;
    let mesh = plane(70, 70, h);
    let middle = mesh.rest.len() / 2;
    let mut light = vec![[0.0; 3]; mesh.rest.len()];
    light[middle] = [1.0 / (h * h); 3];
    mesh.each_device(&light, |device, spread| {
        for (p, spread) in mesh.rest.iter().zip(spread) {
            let r2 = f64::from(p[0]).powi(2) + f64::from(p[1]).powi(2);
            // Red spreads this far. Within three vertices the mesh is too coarse for the narrowest Gaussian.
            if (0.45..5.0).contains(&r2.sqrt()) {
                let part = |g: &super::Gaussian| {
                    g.weights[0] * (-0.5 * r2 / g.variance).exp() / (2.0 * PI * g.variance)
                };
                let expected: f64 = SKIN_PROFILE.iter().map(part).sum();
                let off = f64::from(spread[0]) / expected - 1.0;
                assert!(off.abs() < 0.03, "{device}: {off} of {expected} at {}", r2.sqrt());
            }
        }
    });
}

#[test]
fn harmonics_on_a_ball_fade_as_fast_as_they_should() {
    const RADIUS: f64 = 10.0;
    let mesh = ball(48, RADIUS);
    // Harmonics of the orders 1 to 6: z, xy, 5z³ − 3z, and sectoral ones.
    type Harmonic = fn([f64; 3]) -> f64;
    let harmonics: [(f64, Harmonic); 5] = [
        (1.0, |[_, _, z]| z),
        (2.0, |[x, y, _]| x * y),
        (3.0, |[_, _, z]| 5.0 * z.powi(3) - 3.0 * z),
        (4.0, |[x, y, _]| x.powi(4) - 6.0 * x * x * y * y + y.powi(4)),
        (6.0, |[x, y, _]| (x * x - y * y) * ((x * x - y * y).powi(2) - 12.0 * x * x * y * y)),
    ];
    for (order, harmonic) in harmonics {
        let of = |p: &[f32; 3]| harmonic(p.map(|c| f64::from(c) / RADIUS));
        let light: Vec<[f32; 3]> = mesh.rest.iter().map(|p| [of(p) as f32; 3]).collect();
        mesh.each_device(&light, |device, spread| {
            let squares: f64 = mesh.rest.iter().map(|p| of(p).powi(2)).sum();
            for c in 0..3 {
                let products = mesh.rest.iter().zip(spread).map(|(p, spread)| of(p) * f64::from(spread[c]));
                let left = products.sum::<f64>() / squares;
                let fades = |g: &super::Gaussian| {
                    g.weights[c] * (-0.5 * g.variance * order * (order + 1.0) / (RADIUS * RADIUS)).exp()
                };
                let expected: f64 = SKIN_PROFILE.iter().map(fades).sum();
                assert!((left / expected - 1.0).abs() < 0.01, "{device}: {order}: {left}, not {expected}");
                // The light is still that harmonic.
                let off =
                    mesh.rest.iter().zip(spread).map(|(p, s)| (f64::from(s[c]) - expected * of(p)).abs());
                let (off, most) = (off.fold(0.0, f64::max), mesh.rest.iter().map(of).fold(0.0, f64::max));
                assert!(off < 0.01 * most, "{device}: {order}: {off} of {most}");
            }
        });
    }
}

#[test]
fn even_light_stays_even_and_none_is_lost() {
    let mesh = ball(20, 30.0);
    let even = vec![[0.3, 0.7, 0.9]; mesh.rest.len()];
    mesh.each_device(&even, |device, spread| {
        for s in spread {
            let off = (0..3).map(|c| (s[c] / even[0][c] - 1.0).abs()).fold(0.0, f32::max);
            assert!(off < 1e-5, "{device}: {s:?}");
        }
    });
    // Spots of different size.
    let spots: Vec<[f32; 3]> =
        mesh.rest.iter().map(|p| [p[0].max(0.0), if p[1] > 29.0 { 50.0 } else { 0.0 }, p[2].abs()]).collect();
    let positions: Vec<[f64; 3]> = mesh.rest.iter().map(|p| p.map(f64::from)).collect();
    let mass = laplacian(&positions, &mesh.triangles).mass;
    mesh.each_device(&spots, |device, spread| {
        for c in 0..3 {
            let before: f64 = spots.iter().zip(&mass).map(|(s, m)| m * f64::from(s[c])).sum();
            let after: f64 = spread.iter().zip(&mass).map(|(s, m)| m * f64::from(s[c])).sum();
            assert!((after / before - 1.0).abs() < 1e-5, "{device}: {before} became {after}");
        }
    });
}

#[test]
fn where_triangles_are_too_fine_light_is_slower_and_nothing_else() {
    // A plane in which one vertex is a micrometre beside another. Its light would leave at once.
    let mut mesh = plane(20, 20, 0.5);
    let middle = mesh.rest.len() / 2;
    mesh.rest[middle][0] += 0.499;
    let info = Wgpu::devices().unwrap().remove(0);
    let wgpu = Wgpu::open(&info).unwrap();
    let (device, queue) = (wgpu.device(), wgpu.queue());
    let diffusion =
        Diffusion::new(device, queue, &mesh.rest, &mesh.triangles, 1.0, &SKIN_PROFILE, effort(128)).unwrap();
    assert!(diffusion.too_fine > 0.0 && diffusion.too_fine < 0.01, "{}", diffusion.too_fine);
    let lit: Vec<[f32; 4]> = mesh.rest.iter().map(|p| [if p[1] > 0.1 { 1.0 } else { 0.0 }; 4]).collect();
    let found = run(&wgpu, &diffusion, &lit);
    // A wave that is not damped would be far outside of this range.
    let colours = found.iter().flat_map(|s| &s[..3]);
    let (least, most) = colours.fold((0.0_f32, 0.0_f32), |(a, b), x| (a.min(*x), b.max(*x)));
    assert!(least > -0.01 && most < 1.01, "{least} to {most}");
    // Far from the vertex, the light on both sides is that of a plane.
    let even = plane(20, 20, 0.5);
    let expected =
        Diffusion::new(device, queue, &even.rest, &even.triangles, 1.0, &SKIN_PROFILE, effort(128)).unwrap();
    let expected = run(&wgpu, &expected, &lit);
    for ((p, found), expected) in mesh.rest.iter().zip(&found).zip(&expected) {
        if p[0].abs() > 4.0 {
            assert!((found[0] - expected[0]).abs() < 5e-3, "{p:?}: {found:?}, {expected:?}");
        }
    }
}

#[test]
fn shaders_are_valid() {
    for info in Wgpu::devices().unwrap() {
        let wgpu = Wgpu::open(&info).unwrap();
        let mesh = plane(2, 2, 1.0);
        let (target, skin) = (crate::Offscreen::TARGET, super::Skin::default());
        let (device, queue) = (wgpu.device(), wgpu.queue());
        super::SkinRenderer::new(device, queue, &mesh.rest, &mesh.triangles, 1.0, target, skin).unwrap();
    }
}

#[test]
fn what_little_of_a_mesh_is_fine_costs_little() {
    let mut mesh = plane(30, 30, 1.0);
    let middle = mesh.rest.len() / 2;
    mesh.rest[middle][0] += 0.999;
    let info = Wgpu::devices().unwrap().remove(0);
    let wgpu = Wgpu::open(&info).unwrap();
    let new = |effort| {
        Diffusion::new(wgpu.device(), wgpu.queue(), &mesh.rest, &mesh.triangles, 1.0, &SKIN_PROFILE, effort)
            .unwrap()
    };
    assert_eq!(new(effort(128)).steps(), 127);
    let spared = new(Effort { always: 40, longest: 128, spared: 0.005 });
    assert!(spared.steps() < 40 && spared.too_fine < 0.005, "{} {}", spared.steps(), spared.too_fine);
}
