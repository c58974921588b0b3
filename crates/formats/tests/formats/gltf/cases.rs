//! What is written as glTF, and every way to write it.

use crate::animation::{self, Animation, Other, Random, UvKind};
use rhytid_core::{Channel, ChannelKind, Materials, RigidMotion, UpAxis};
use rhytid_formats::export::{Options, Written};
use std::path::Path;

/// The sheet of [`animation::animation`], with a wave that runs over it while it shakes a little. Few targets
/// can show it.
pub(super) fn animation(uvs: UvKind, frames: usize, seed: u64) -> Animation {
    let mut animation = animation::animation(uvs, frames, seed);
    let mut random = Random(!seed);
    for (k, [positions, _]) in animation.frames.iter_mut().enumerate() {
        for (position, rest) in positions.as_chunks_mut::<3>().0.iter_mut().zip(&animation.rest) {
            let wave = (rest[0] + k as f32 * 0.7).sin();
            let shake = random.vector(0.01);
            *position = [rest[0] + shake[0], rest[1] + wave + shake[1], rest[2] + 0.3 * wave + shake[2]];
        }
    }
    animation
}

/// Numbers that waves of the positions are a good part of, as strains are.
fn strains(animation: &Animation) -> Vec<Other> {
    let of_vertex = |[x, y, z]: &[f32; 3]| [0.1 * (x + y).sin(), 0.05 * (y - z)];
    let strains = |positions: &Vec<f32>| positions.as_chunks().0.iter().flat_map(of_vertex).collect();
    let wave = |positions: &Vec<f32>, i: usize| {
        positions.as_chunks::<3>().0.iter().map(|x| (0.05 * x[i % 3] + i as f32).sin().abs()).collect()
    };
    let examples = ["a", "b", "c", "d"].map(String::from);
    let kinds = [ChannelKind::Strain, ChannelKind::Wrinkles].into_iter();
    let channels = kinds.flat_map(|kind| kind.channels(&examples)).enumerate();
    let other = |(i, channel): (usize, Channel)| {
        let of_frame = |[positions, normals]: &[Vec<f32>; 2]| match channel.width {
            2 => strains(positions),
            3 => normals.clone(),
            _ => wave(positions, i),
        };
        Other { frames: animation.frames.iter().map(of_frame).collect(), channel }
    };
    channels.map(other).collect()
}

/// A head that turns and nods more than once around, given with quaternions of either sign.
pub(super) fn head(frames: usize) -> Vec<RigidMotion> {
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

/// One way to write one animation.
pub(super) struct Case {
    pub animation: Animation,
    pub options: Options,
    /// `glb` or `gltf`.
    pub extension: &'static str,
    /// A word for each choice.
    pub label: String,
}

impl Case {
    /// The corners of the triangles in the file's order: by material, and at last those without one.
    pub(super) fn corners(&self) -> Vec<[u32; 3]> {
        let mut triangles = self.animation.triangle_corners.clone();
        if let (Some(materials), false) = (&self.animation.materials, self.options.one_material) {
            triangles.sort_by_key(|corners| materials.of_face[self.face_of(corners[0])]);
        }
        triangles
    }

    /// The face that has a corner.
    pub(super) fn face_of(&self, corner: u32) -> usize {
        let mut end = 0;
        let counts = &self.animation.faces.counts;
        counts
            .iter()
            .take_while(|&&count| {
                end += count;
                end <= corner
            })
            .count()
    }

    /// Writes it to `folder` under a name of its own.
    pub(super) fn export(&self, folder: &Path) -> (std::path::PathBuf, Written) {
        let path = folder.join(format!("{}.{}", self.label.replace(' ', "-"), self.extension));
        let written = self
            .animation
            .export_with(&path, &self.options)
            .unwrap_or_else(|e| panic!("{}: {e}", self.label));
        (path, written)
    }
}

/// Three materials in turns, and faces without one.
pub(super) fn three_materials(faces: usize) -> Materials {
    let of_face = (0..faces).map(|face| [2, 0, Materials::NONE, 1, 0][face % 5]).collect();
    Materials::named(["skin", "teeth", "Auge – links"], of_face)
}

/// Every choice with every other.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for bits in 0..1 << 6 {
        let [compressed, quantize, meshopt, normals, with_head, z_up] =
            std::array::from_fn(|bit| bits >> bit & 1 == 1);
        for (u, uvs) in
            [UvKind::None, UvKind::PerVertex, UvKind::PerCorner, UvKind::Tiled].into_iter().enumerate()
        {
            // Every choice occurs with both kinds of file, and sometimes with a take of one frame.
            let extension = if (bits + u) % 2 == 0 { "glb" } else { "gltf" };
            let frames = if (bits * 4 + u) % 11 == 10 { 1 } else { 5 };
            let mut animation = animation(uvs, frames, 100 + bits as u64);
            animation.with_normals = normals;
            animation.head = with_head.then(|| head(frames));
            animation.up_axis = if z_up { UpAxis::Z } else { UpAxis::Y };
            // The waves of the positions are no strains of theirs, but numbers as good as any.
            if bits % 2 == u % 2 {
                animation.others = strains(&animation);
            }
            if bits % 3 == 1 {
                animation.materials = Some(three_materials(animation.faces.len()));
            }
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
            let one_material = (bits + u) % 5 == 4;
            let vertex_ids = (bits / 2 + u) % 2 == 0;
            let options =
                Options { max_error, quantize, meshopt, one_material, vertex_ids, ..Options::default() };
            cases.push(Case { animation, options, extension, label: label.concat() });
        }
    }
    cases
}
