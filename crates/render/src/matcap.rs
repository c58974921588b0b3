//! A matcap: a picture of a ball that gives a colour for each direction of a surface.

use crate::picture::{Picture, to_srgb};
use glam::{Vec3, vec3};

/// Pixels along each side.
const SIZE: u32 = 256;

impl Picture {
    /// A ball of grey clay with a dull highlight and a rim. It is lit by a broad lamp at the upper left, a
    /// bluish sky and a warm ground. This shows a surface's form better than one lamp.
    pub fn clay() -> Self {
        let key = vec3(-0.5, 0.65, 0.58).normalize();
        // The direction half-way between the lamp and the viewer, who is far away.
        let half = (key + Vec3::Z).normalize();
        let light = |n: Vec3| {
            // A broad lamp reaches around the ball's edge.
            let lit = ((n.dot(key) + 0.35) / 1.35).max(0.0).powi(2);
            let sky = 0.5 + 0.5 * n.y;
            let ambient = vec3(0.10, 0.085, 0.075).lerp(vec3(0.14, 0.17, 0.22), sky);
            let dull = 0.22 * n.dot(half).max(0.0).powi(28);
            let rim = 0.10 * (1.0 - n.z).powi(3) * sky;
            vec3(0.52, 0.505, 0.485) * (lit * vec3(1.0, 0.97, 0.92) + ambient) + dull + rim
        };
        let at = |i: u32| 2.0 * (i as f32 + 0.5) / SIZE as f32 - 1.0;
        let mut pixels = Vec::with_capacity((4 * SIZE * SIZE) as usize);
        for row in 0..SIZE {
            for column in 0..SIZE {
                let (x, y) = (at(column), -at(row));
                // Outside the ball the colours continue those of its edge.
                let across = (x * x + y * y).sqrt().max(1.0);
                let (x, y) = (x / across, y / across);
                let n = vec3(x, y, (1.0 - x * x - y * y).max(0.0).sqrt());
                pixels.extend(light(n).to_array().map(to_srgb));
                pixels.push(255);
            }
        }
        Self { size: [SIZE; 2], pixels }
    }
}
