//! The crate gltf: reads each file of a job, and evaluates its animation as glTF says. `client.py` describes
//! the job and the lines that are printed.
#![forbid(unsafe_code)]

use gltf::animation::util::ReadOutputs;
use serde_json::{Value, json};
use std::error::Error;
use std::path::Path;

/// The version in the workspace's lock file; a crate does not say it.
const VERSION: &str = "1.4";

type Triple = [f32; 3];
type Matrix = [[f32; 4]; 4];

/// The parts of a mesh that are drawn: positions and normals of a primitive and of its targets.
struct Part {
    positions: Vec<Triple>,
    normals: Vec<Triple>,
    targets: Vec<[Vec<Triple>; 2]>,
}

/// What moves at a time.
#[derive(Default)]
struct Pose {
    translation: Option<Triple>,
    rotation: Option<[f32; 4]>,
    weights: Option<Vec<f32>>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("give the job")?;
    let job: Value = serde_json::from_slice(&std::fs::read(path)?)?;
    for (number, file) in job["files"].as_array().ok_or("no files")?.iter().enumerate() {
        let mut line = match read(file.as_str().ok_or("a file is no text")?, &job, number) {
            Ok(found) => found,
            Err(error) => json!({ "error": error.to_string() }),
        };
        line["file"] = number.into();
        line["version"] = VERSION.into();
        println!("{line}");
    }
    Ok(())
}

fn read(file: &str, job: &Value, number: usize) -> Result<Value, Box<dyn Error>> {
    let folder = Path::new(file).parent().ok_or("no folder")?;
    let gltf::Gltf { document, blob } = gltf::Gltf::open(file)?;
    let buffers = buffers(&document, blob, folder)?;
    let frames = job["frames"].as_u64().ok_or("no frames")? as usize;
    let rate = job["rate"].as_f64().ok_or("no rate")?;
    let scene = document.default_scene().ok_or("no scene")?;
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    let frames = if document.animations().next().is_some() { frames } else { 1 };
    for frame in 0..frames {
        let time = (frame as f64 / rate) as f32;
        for node in scene.nodes() {
            gather(&node, &IDENTITY, &document, &buffers, time, &mut positions, &mut normals)?;
        }
    }
    let vertices = positions.len() / frames;
    let out = Path::new(job["out"].as_str().ok_or("no folder")?);
    write(&out.join(format!("{number}.f64")), &positions)?;
    let has_normals = normals.len() == positions.len();
    if has_normals {
        write(&out.join(format!("{number}.normals.f64")), &normals)?;
    }
    let mut materials = Vec::new();
    for material in document.materials() {
        let look = material.pbr_metallic_roughness();
        let texture = match look.base_color_texture() {
            Some(info) => Some(size(&image(&info.texture().source(), &buffers, folder)?)?),
            None => None,
        };
        let colour = texture.is_none().then(|| look.base_color_factor()[..3].to_vec());
        materials.push(json!({ "name": material.name(), "colour": colour, "texture": texture }));
    }
    Ok(json!({
        "up": "Y", "frames": frames, "vertices": vertices, "normals": has_normals, "materials": materials,
    }))
}

/// The content of all buffers: the part behind the JSON, or files beside it.
fn buffers(
    document: &gltf::Document,
    mut blob: Option<Vec<u8>>,
    folder: &Path,
) -> Result<Vec<Vec<u8>>, Box<dyn Error>> {
    let content = |buffer: gltf::Buffer<'_>| match buffer.source() {
        gltf::buffer::Source::Bin => blob.take().ok_or_else(|| "no binary part".into()),
        gltf::buffer::Source::Uri(uri) => Ok(std::fs::read(folder.join(uri))?),
    };
    document.buffers().map(content).collect()
}

/// The bytes of an image in a buffer or in a file.
fn image(image: &gltf::Image<'_>, buffers: &[Vec<u8>], folder: &Path) -> Result<Vec<u8>, Box<dyn Error>> {
    Ok(match image.source() {
        gltf::image::Source::View { view, .. } => {
            let buffer = buffers.get(view.buffer().index()).ok_or("an image in no buffer")?;
            buffer
                .get(view.offset()..view.offset() + view.length())
                .ok_or("an image beyond its buffer")?
                .to_vec()
        }
        gltf::image::Source::Uri { uri, .. } => std::fs::read(folder.join(uri))?,
    })
}

/// The width and height of a PNG.
fn size(png: &[u8]) -> Result<[u32; 2], Box<dyn Error>> {
    let reader = png::Decoder::new(std::io::Cursor::new(png)).read_info()?;
    Ok([reader.info().width, reader.info().height])
}

/// Adds the world's positions and normals of a node and of all below it.
fn gather(
    node: &gltf::Node<'_>,
    above: &Matrix,
    document: &gltf::Document,
    buffers: &[Vec<u8>],
    time: f32,
    positions: &mut Vec<Triple>,
    normals: &mut Vec<Triple>,
) -> Result<(), Box<dyn Error>> {
    let pose = pose(node, document, buffers, time)?;
    let (translation, rotation, scale) = node.transform().decomposed();
    let own = gltf::scene::Transform::Decomposed {
        translation: pose.translation.unwrap_or(translation),
        rotation: pose.rotation.unwrap_or(rotation),
        scale,
    };
    let matrix = product(above, &own.matrix());
    if let Some(mesh) = node.mesh() {
        let rest = mesh.weights().map(<[f32]>::to_vec).unwrap_or_default();
        let weights = pose.weights.unwrap_or(rest);
        for primitive in mesh.primitives() {
            let part = part(&primitive, buffers)?;
            positions.extend(part.morphed(0, &weights).map(|at| transformed(&matrix, at, 1.0)));
            // The scale of Rhytid's nodes is the same along all axes.
            normals.extend(part.morphed(1, &weights).map(|at| transformed(&matrix, at, 0.0)));
        }
    }
    for child in node.children() {
        gather(&child, &matrix, document, buffers, time, positions, normals)?;
    }
    Ok(())
}

fn part(primitive: &gltf::Primitive<'_>, buffers: &[Vec<u8>]) -> Result<Part, Box<dyn Error>> {
    let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
    let targets = reader.read_morph_targets().map(|(positions, normals, _)| {
        [
            positions.map(Iterator::collect).unwrap_or_default(),
            normals.map(Iterator::collect).unwrap_or_default(),
        ]
    });
    Ok(Part {
        positions: reader.read_positions().ok_or("no positions")?.collect(),
        normals: reader.read_normals().map(Iterator::collect).unwrap_or_default(),
        targets: targets.collect(),
    })
}

impl Part {
    /// Positions (`which` is 0) or normals (1) with the weighted targets.
    fn morphed<'a>(&'a self, which: usize, weights: &'a [f32]) -> impl Iterator<Item = Triple> + 'a {
        let base = if which == 0 { &self.positions } else { &self.normals };
        base.iter().enumerate().map(move |(v, base)| {
            let mut sum = *base;
            for (target, weight) in self.targets.iter().zip(weights) {
                let offset = target[which].get(v).copied().unwrap_or_default();
                (0..3).for_each(|axis| sum[axis] += weight * offset[axis]);
            }
            sum
        })
    }
}

/// What the animations say of a node at a time. They are linear.
fn pose(
    node: &gltf::Node<'_>,
    document: &gltf::Document,
    buffers: &[Vec<u8>],
    time: f32,
) -> Result<Pose, Box<dyn Error>> {
    let mut pose = Pose::default();
    let channels = document.animations().flat_map(|animation| animation.channels().collect::<Vec<_>>());
    for channel in channels.filter(|channel| channel.target().node().index() == node.index()) {
        let reader = channel.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
        let times: Vec<f32> = reader.read_inputs().ok_or("an animation without times")?.collect();
        match reader.read_outputs().ok_or("an animation without values")? {
            ReadOutputs::Translations(values) => {
                pose.translation = Some(between(&times, &values.collect::<Vec<_>>(), time));
            }
            ReadOutputs::Rotations(values) => {
                let mixed = between(&times, &values.into_f32().collect::<Vec<_>>(), time);
                let length = mixed.iter().map(|x| x * x).sum::<f32>().sqrt();
                pose.rotation = Some(mixed.map(|x| x / length));
            }
            ReadOutputs::MorphTargetWeights(values) => {
                let values: Vec<f32> = values.into_f32().collect();
                let width = values.len() / times.len();
                let weight = |target: usize| {
                    let of_target: Vec<[f32; 1]> = values.chunks(width).map(|row| [row[target]]).collect();
                    between(&times, &of_target, time)[0]
                };
                pose.weights = Some((0..width).map(weight).collect());
            }
            ReadOutputs::Scales(_) => return Err("a scale is animated".into()),
        }
    }
    Ok(pose)
}

/// The value at a time, linear between the two around it.
fn between<const N: usize>(times: &[f32], values: &[[f32; N]], time: f32) -> [f32; N] {
    let next = times.partition_point(|at| *at < time).min(times.len() - 1);
    let last = next.saturating_sub(1);
    let span = times[next] - times[last];
    let part = if span > 0.0 { ((time - times[last]) / span).clamp(0.0, 1.0) } else { 1.0 };
    std::array::from_fn(|i| values[last][i] + part * (values[next][i] - values[last][i]))
}

const IDENTITY: Matrix =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// `a` after `b`; both are columns.
fn product(a: &Matrix, b: &Matrix) -> Matrix {
    b.map(|column| std::array::from_fn(|row| (0..4).map(|k| a[k][row] * column[k]).sum()))
}

fn transformed(matrix: &Matrix, [x, y, z]: Triple, w: f32) -> Triple {
    let [a, b, c, d] = matrix;
    std::array::from_fn(|row| a[row] * x + b[row] * y + c[row] * z + d[row] * w)
}

fn write(path: &Path, triples: &[Triple]) -> std::io::Result<()> {
    std::fs::write(
        path,
        triples.as_flattened().iter().flat_map(|x| f64::from(*x).to_le_bytes()).collect::<Vec<_>>(),
    )
}
