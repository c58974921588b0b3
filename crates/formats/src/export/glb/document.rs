//! The JSON chunk. Its length is the same for all frames' bounds: they are padded to a fixed width.
use super::super::Scene;
use super::super::text::shortest;
use super::surface::Surface;
use rhytid_core::UpAxis;
use serde_json::{Value, json};
use std::f64::consts::FRAC_1_SQRT_2;
use std::io::{self, Write};

/// Smallest and largest coordinates.
pub(super) type Bounds = [[f32; 3]; 2];

/// glTF's numbers for what a buffer view is for and what an element is made of.
const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;
const U32: u32 = 5125;
const F32: u32 = 5126;

/// The buffer views, in the order of the binary chunk. Texture coordinates have none where there are none,
/// which shifts those after it.
const VIEW_INDICES: usize = 0;
const VIEW_BASE: usize = 1;
const VIEW_UVS: usize = 2;

/// The accessors; the targets' follow: positions, normals, positions, …
const INDICES: usize = 0;
const POSITIONS: usize = 1;
const NORMALS: usize = 2;
const TIMES: usize = 3;
const WEIGHTS: usize = 4;
const UVS: usize = 5;

/// All that the JSON says, but for the frames' bounds.
#[derive(Clone)]
pub(super) struct Document {
    name: String,
    /// W: vertices of the surface.
    vertices: usize,
    /// Three times the triangles.
    indices: usize,
    has_uvs: bool,
    base_bounds: Bounds,
    metres_per_unit: f64,
    up_axis: UpAxis,
    rate: f64,
    first_time_code: f64,
    /// Number of frames and of targets.
    pub frames: usize,
}

/// When a frame is shown, in seconds.
pub(super) fn time(frame: usize, rate: f64) -> f32 {
    (frame as f64 / rate) as f32
}

/// Smallest and largest coordinates of `vectors`, of which there is at least one.
pub(super) fn bounds(vectors: &[[f32; 3]]) -> Bounds {
    vectors.iter().fold([[f32::MAX; 3], [f32::MIN; 3]], |[low, high], v| {
        [std::array::from_fn(|i| low[i].min(v[i])), std::array::from_fn(|i| high[i].max(v[i]))]
    })
}

impl Document {
    pub fn new(scene: &Scene<'_>, surface: &Surface) -> Self {
        Self {
            name: scene.name.to_owned(),
            vertices: surface.positions.len(),
            indices: surface.indices.len(),
            has_uvs: surface.uvs.is_some(),
            base_bounds: bounds(&surface.positions),
            metres_per_unit: scene.metres_per_unit,
            up_axis: scene.up_axis,
            rate: scene.rate,
            first_time_code: scene.first_time_code,
            frames: scene.frames,
        }
    }

    /// The same animation with another number of frames.
    pub fn with_frames(&self, frames: usize) -> Self {
        Self { frames, ..self.clone() }
    }

    /// The binary chunk's length in bytes.
    pub fn binary_size(&self) -> u64 {
        self.views().iter().map(|view| view.bytes).sum()
    }

    /// Writes the JSON. Frames without `bounds` get zeros.
    pub fn write(&self, out: &mut impl Write, bounds: &[Bounds]) -> io::Result<()> {
        let head = self.head().to_string();
        let name = json!(self.name);
        let first_target = if self.has_uvs { UVS + 1 } else { UVS };
        let mut attributes = json!({ "POSITION": POSITIONS, "NORMAL": NORMALS });
        if self.has_uvs {
            attributes["TEXCOORD_0"] = UVS.into();
        }
        write!(out, "{}", head.strip_suffix('}').unwrap_or(&head))?;
        write!(
            out,
            ",\"meshes\":[{{\"name\":{name},\"primitives\":[{{\"attributes\":{attributes},\
             \"indices\":{INDICES},\"material\":0,\"targets\":["
        )?;
        for frame in 0..self.frames {
            let position = first_target + 2 * frame;
            write!(out, "{}{{\"POSITION\":{position},\"NORMAL\":{}}}", comma(frame), position + 1)?;
        }
        write!(out, "]}}],\"extras\":{{\"targetNames\":[")?;
        for frame in 0..self.frames {
            let time_code = self.first_time_code + frame as f64;
            write!(out, "{}\"frame {time_code:04}\"", comma(frame))?;
        }
        write!(out, "]}}}}],\"accessors\":[")?;
        for (i, accessor) in self.static_accessors().iter().enumerate() {
            write!(out, "{}{accessor}", comma(i))?;
        }
        let vectors = self.vertices as u64 * 12;
        let view = self.views().len() - 1;
        for frame in 0..self.frames {
            let [low, high] = bounds.get(frame).copied().unwrap_or_default().map(fixed_width);
            let offset = frame as u64 * 2 * vectors;
            let element = format!("\"componentType\":{F32},\"count\":{},\"type\":\"VEC3\"", self.vertices);
            write!(
                out,
                ",{{\"bufferView\":{view},\"byteOffset\":{offset},{element},\"min\":{low},\"max\":{high}}}\
                 ,{{\"bufferView\":{view},\"byteOffset\":{},{element}}}",
                offset + vectors
            )?;
        }
        write!(out, "]}}")
    }

    /// Everything but the mesh and the accessors.
    fn head(&self) -> Value {
        let mut node = json!({ "name": self.name, "mesh": 0 });
        if self.metres_per_unit != 1.0 {
            node["scale"] = json!(vec![self.metres_per_unit; 3]);
        }
        if self.up_axis == UpAxis::Z {
            node["rotation"] = json!([-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2]);
        }
        let mut start = 0;
        let views: Vec<Value> = self
            .views()
            .iter()
            .map(|view| {
                let mut value = json!({ "buffer": 0, "byteOffset": start, "byteLength": view.bytes });
                start += view.bytes;
                if let Some(stride) = view.stride {
                    value["byteStride"] = stride.into();
                }
                if let Some(target) = view.target {
                    value["target"] = target.into();
                }
                value
            })
            .collect();
        json!({
            "asset": { "version": "2.0", "generator": concat!("Rhytid ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{
                "nodes": [0],
                "extras": { "framesPerSecond": self.rate, "firstTimeCode": self.first_time_code },
            }],
            "nodes": [node],
            // Without one, viewers take bare metal, seen from the front alone.
            "materials": [{
                "name": "skin",
                "doubleSided": true,
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.8, 0.8, 0.8, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.6,
                },
            }],
            "animations": [{
                "name": self.name,
                "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
                "samplers": [{ "input": TIMES, "output": WEIGHTS, "interpolation": "LINEAR" }],
            }],
            "buffers": [{ "byteLength": start }],
            "bufferViews": views,
        })
    }

    /// The accessors that are known before the first frame.
    fn static_accessors(&self) -> Vec<Value> {
        let frames = self.frames;
        let [low, high] = self.base_bounds.map(|v| v.map(f64::from));
        let times = VIEW_UVS + usize::from(self.has_uvs);
        let last_time = f64::from(time(frames.saturating_sub(1), self.rate));
        let vectors = self.vertices * 12;
        let mut accessors = vec![
            json!({
                "bufferView": VIEW_INDICES, "componentType": U32, "count": self.indices, "type": "SCALAR",
            }),
            json!({
                "bufferView": VIEW_BASE, "componentType": F32, "count": self.vertices, "type": "VEC3",
                "min": low, "max": high,
            }),
            json!({
                "bufferView": VIEW_BASE, "byteOffset": vectors, "componentType": F32, "count": self.vertices,
                "type": "VEC3",
            }),
            json!({
                "bufferView": times, "componentType": F32, "count": frames, "type": "SCALAR",
                "min": [0.0], "max": [last_time],
            }),
            // frames × frames zeros but for the diagonal.
            json!({
                "componentType": F32, "count": frames * frames, "type": "SCALAR",
                "sparse": {
                    "count": frames,
                    "indices": { "bufferView": times + 1, "componentType": U32 },
                    "values": { "bufferView": times + 2 },
                },
            }),
        ];
        if self.has_uvs {
            accessors.push(json!({
                "bufferView": VIEW_UVS, "componentType": F32, "count": self.vertices, "type": "VEC2",
            }));
        }
        accessors
    }

    /// The parts of the binary chunk: indices; base positions and normals; texture coordinates; times; where
    /// the weights are 1, and the ones; each target's positions and normals.
    fn views(&self) -> Vec<View> {
        let (vertices, frames) = (self.vertices as u64, self.frames as u64);
        let vectors = |bytes| View { bytes, stride: Some(12), target: Some(ARRAY_BUFFER) };
        let plain = View { bytes: 4 * frames, stride: None, target: None };
        let indices =
            View { bytes: 4 * self.indices as u64, stride: None, target: Some(ELEMENT_ARRAY_BUFFER) };
        let uvs = View { bytes: 8 * vertices, stride: None, target: Some(ARRAY_BUFFER) };
        [indices, vectors(24 * vertices)]
            .into_iter()
            .chain(self.has_uvs.then_some(uvs))
            .chain([plain, plain, plain, vectors(24 * vertices * frames)])
            .collect()
    }
}

#[derive(Clone, Copy)]
struct View {
    bytes: u64,
    stride: Option<u32>,
    target: Option<u32>,
}

/// A JSON array whose length is the same for all finite vectors.
fn fixed_width(vector: [f32; 3]) -> String {
    let [x, y, z] = vector.map(|x| format!("{:>16}", shortest(&mut ryu::Buffer::new(), x)));
    format!("[{x},{y},{z}]")
}

fn comma(i: usize) -> &'static str {
    if i == 0 { "" } else { "," }
}
