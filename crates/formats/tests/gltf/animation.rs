//! Small animations to export, and every way to export them.

use rhytid_core::{Faces, Materials, NoProgress, Result, RigidMotion, UpAxis, Uvs};
use rhytid_formats::export::{self, Frame, Options, Origin, Scene, Written};
use std::path::Path;

/// Everything that an exporter is told.
#[derive(Clone)]
pub struct Animation {
    pub name: String,
    pub rest: Vec<[f32; 3]>,
    pub rest_normals: Option<Vec<[f32; 3]>>,
    pub faces: Faces,
    pub triangle_corners: Vec<[u32; 3]>,
    pub uvs: Option<Uvs>,
    pub materials: Option<Materials>,
    pub head: Option<Vec<RigidMotion>>,
    pub metres_per_unit: f64,
    pub up_axis: UpAxis,
    pub rate: f64,
    pub first_time_code: f64,
    pub origin: Origin,
    /// Positions and normals of each frame.
    pub frames: Vec<[Vec<f32>; 2]>,
}

impl Animation {
    pub fn scene(&self) -> Scene<'_> {
        Scene {
            name: &self.name,
            rest: &self.rest,
            rest_normals: self.rest_normals.as_deref(),
            velocities: false,
            faces: &self.faces,
            triangle_corners: &self.triangle_corners,
            uvs: self.uvs.as_ref(),
            materials: self.materials.as_ref(),
            head: self.head.as_deref(),
            metres_per_unit: self.metres_per_unit,
            up_axis: self.up_axis,
            frames: self.frames.len(),
            rate: self.rate,
            first_time_code: self.first_time_code,
            origin: &self.origin,
        }
    }

    /// Frame `k` as the exporter wants it.
    pub fn frame(&self, k: usize) -> Frame<'_> {
        let [positions, normals] = &self.frames[k];
        Frame { positions, normals: self.rest_normals.is_some().then_some(normals), velocities: None }
    }

    pub fn export(&self, path: &Path, options: &Options) -> Result<Written> {
        let mut exporter = export::create(path, &self.scene(), options)?;
        for k in 0..self.frames.len() {
            exporter.frame(self.frame(k))?;
        }
        exporter.finish(&NoProgress)
    }
}

/// How texture coordinates are given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UvKind {
    None,
    PerVertex,
    PerCorner,
    /// Per corner, and beyond 0 to 1.
    Tiled,
}

/// A sheet of 5 × 4 quads with a triangle and a pentagon at its rim and one vertex of no face: a wave runs over it, and
/// it shakes a little.
pub fn animation(uvs: UvKind, frames: usize, seed: u64) -> Animation {
    let mut random = Random(seed);
    let mut faces = Faces::default();
    for y in 0..4 {
        for x in 0..5 {
            let v = y * 6 + x;
            faces.push(&[v, v + 1, v + 7, v + 6]);
        }
    }
    faces.push(&[0, 30, 1]);
    faces.push(&[24, 25, 26, 31, 32]);
    let vertices = 34;
    let rest: Vec<[f32; 3]> = (0..vertices).map(|_| random.vector(10.0)).collect();
    // The last vertex has no face, hence no normal.
    let normals = |random: &mut Random| -> Vec<[f32; 3]> {
        (0..vertices).map(|v| if v == vertices - 1 { [0.0; 3] } else { random.unit_vector() }).collect()
    };
    let rest_normals = normals(&mut random);
    let uvs = match uvs {
        UvKind::None => None,
        UvKind::PerVertex => {
            Some(Uvs { values: (0..vertices).map(|_| random.uv()).collect(), corners: None })
        }
        UvKind::PerCorner | UvKind::Tiled => {
            // Few values for many corners: some vertices get one, others several, some twice the same value
            // under two indices.
            let mut values: Vec<[f32; 2]> = (0..5).map(|_| random.uv()).collect();
            values.push(values[0]);
            if uvs == UvKind::Tiled {
                values[3] = [2.5, -1.25];
            }
            let corners = faces.indices.iter().map(|_| random.below(values.len() as u64) as u32).collect();
            Some(Uvs { values, corners: Some(corners) })
        }
    };
    let frames = (0..frames)
        .map(|k| {
            let positions = rest.iter().flat_map(|p| {
                let wave = (p[0] + k as f32 * 0.7).sin();
                let offset = random.vector(0.01);
                [p[0] + offset[0], p[1] + wave + offset[1], p[2] + 0.3 * wave + offset[2]]
            });
            [positions.collect(), normals(&mut random).into_flattened()]
        })
        .collect();
    Animation {
        name: "face".into(),
        triangle_corners: fans(&faces),
        rest,
        rest_normals: Some(rest_normals),
        faces,
        uvs,
        materials: None,
        head: None,
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        rate: 30.0,
        first_time_code: 1.0,
        origin: Origin { version: "0.1.0".into(), rig: "0f".repeat(32), end_frame: 9, ..Origin::default() },
        frames,
    }
}

/// A head that turns and nods more than once around, given with quaternions of either sign.
pub fn head(frames: usize) -> Vec<RigidMotion> {
    (0..frames)
        .map(|k| {
            let half = 0.9 * k as f64;
            let sign = if k % 3 == 1 { -1.0 } else { 1.0 };
            let axis = [0.36, 0.48, 0.8];
            let [x, y, z] = axis.map(|a| sign * a * half.sin());
            RigidMotion {
                rotation: [x, y, z, sign * half.cos()],
                translation: [k as f64, 2.5, -0.5 * k as f64],
            }
        })
        .collect()
}

/// Each polygon as a fan of triangles, by corner.
fn fans(faces: &Faces) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    let mut first = 0;
    for &count in &faces.counts {
        triangles.extend((1..count - 1).map(|i| [first, first + i, first + i + 1]));
        first += count;
    }
    triangles
}

/// One way to write one animation.
pub struct Case {
    pub animation: Animation,
    pub options: Options,
    /// `glb` or `gltf`.
    pub extension: &'static str,
    /// A word for each choice.
    pub label: String,
}

impl Case {
    /// Writes it to `folder` under a name of its own.
    pub fn export(&self, folder: &Path) -> (std::path::PathBuf, Written) {
        let path = folder.join(format!("{}.{}", self.label.replace(' ', "-"), self.extension));
        let written =
            self.animation.export(&path, &self.options).unwrap_or_else(|e| panic!("{}: {e}", self.label));
        (path, written)
    }
}

/// Every choice with every other.
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for bits in 0..1 << 6 {
        let [compressed, quantize, meshopt, normals, with_head, z_up] =
            std::array::from_fn(|bit| bits >> bit & 1 == 1);
        for (u, uvs) in
            [UvKind::None, UvKind::PerVertex, UvKind::PerCorner, UvKind::Tiled].into_iter().enumerate()
        {
            // Both kinds of file turn up with everything, and a take of one frame now and then.
            let extension = if (bits + u) % 2 == 0 { "glb" } else { "gltf" };
            let frames = if (bits * 4 + u) % 11 == 10 { 1 } else { 5 };
            let mut animation = animation(uvs, frames, 100 + bits as u64);
            if !normals {
                animation.rest_normals = None;
            }
            animation.head = with_head.then(|| head(frames));
            animation.up_axis = if z_up { UpAxis::Z } else { UpAxis::Y };
            animation.metres_per_unit = [0.001, 0.0254, 1.0][bits % 3];
            animation.rate = [30.0, 30.0 / 1.001, 120.0][(bits / 3) % 3];
            let max_error = compressed.then_some(0.05);
            let word = |is, word| if is { word } else { "" };
            let label = [
                word(compressed, "compressed "),
                word(quantize, "quantize "),
                word(meshopt, "meshopt "),
                word(normals, "normals "),
                word(with_head, "head "),
                word(z_up, "z-up "),
                &format!("{uvs:?} {frames} frames"),
            ];
            let options = Options { max_error, quantize, meshopt, force: false };
            cases.push(Case { animation, options, extension, label: label.concat() });
        }
    }
    cases
}

/// SplitMix64: the same numbers everywhere.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    /// From 0 to 1.
    fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    pub fn vector(&mut self, size: f32) -> [f32; 3] {
        std::array::from_fn(|_| (self.unit() - 0.5) * size)
    }

    fn uv(&mut self) -> [f32; 2] {
        [self.unit(), self.unit()]
    }

    fn unit_vector(&mut self) -> [f32; 3] {
        loop {
            let v = self.vector(2.0);
            let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
            if length > 0.1 {
                return v.map(|x| x / length);
            }
        }
    }
}
