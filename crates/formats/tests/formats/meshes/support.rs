use base64::Engine;
use rhytid_core::{Error, Mesh};
use rhytid_formats::mesh::{Format, decode};
use rhytid_test_support::Logged;
use serde_json::{Value, json};

/// The message of an input error.
pub(super) fn refused(bytes: &[u8], format: Format) -> String {
    message(decode(bytes, format, "face").map(|_| ()))
}

/// The message of an input error, which is one sentence on one line.
pub(super) fn message(result: rhytid_core::Result<()>) -> String {
    match result {
        Err(Error::Input(message)) => {
            assert!(!message.sentence().contains('\n'), "{message}");
            message.to_string()
        }
        Err(other) => panic!("expected an input error, found {other:?}"),
        Ok(()) => panic!("expected an error"),
    }
}

/// Polygons as lists.
pub(super) fn polygons(mesh: &Mesh) -> Vec<Vec<u32>> {
    mesh.faces.iter().map(<[u32]>::to_vec).collect()
}

/// The texture coordinates of every corner, whichever way they are stored.
pub(super) fn corner_uvs(mesh: &Mesh) -> Vec<[f32; 2]> {
    let uvs = mesh.uvs.as_ref().expect("has texture coordinates");
    let of_corner = uvs.corners.as_ref().unwrap_or(&mesh.faces.indices);
    of_corner.iter().map(|&i| uvs.values[i as usize]).collect()
}

/// The warnings while `bytes` were read.
pub(super) fn decode_with_warnings(bytes: &[u8], format: Format, name: &str) -> (Mesh, Vec<String>) {
    let logged = Logged::start();
    let mesh = decode(bytes, format, name).unwrap();
    let warnings =
        logged.lines().iter().filter_map(|line| line.strip_prefix("WARN ").map(str::to_owned)).collect();
    (mesh, warnings)
}

/// A glTF document with its numbers in one buffer.
#[derive(Default)]
pub(super) struct Document {
    /// All but accessors, buffer views and the buffer.
    pub json: Value,
    pub accessors: Vec<Value>,
    pub views: Vec<Value>,
    data: Vec<u8>,
}

impl Document {
    /// Adds a buffer view, and gives its index.
    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        self.views.push(json!({"buffer": 0, "byteOffset": self.data.len(), "byteLength": bytes.len()}));
        self.data.extend(bytes);
        self.views.len() - 1
    }

    /// Adds an accessor, and gives its index.
    pub(super) fn accessor(&mut self, of: &str, component: u32, count: usize, bytes: Vec<u8>) -> usize {
        let view = self.view(&bytes);
        self.accessors
            .push(json!({"bufferView": view, "componentType": component, "count": count, "type": of}));
        self.accessors.len() - 1
    }

    /// Adds an accessor of floats, and gives its index.
    pub(super) fn floats(&mut self, of: &str, numbers: &[f32]) -> usize {
        let width = match of {
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.accessor(of, 5126, numbers.len() / width, numbers.iter().flat_map(|x| x.to_le_bytes()).collect())
    }

    /// As JSON, with the buffer in it.
    pub(super) fn text(&self) -> String {
        let mut json = self.json.clone();
        json["accessors"] = self.accessors.clone().into();
        json["bufferViews"] = self.views.clone().into();
        let uri = format!("data:;base64,{}", base64::prelude::BASE64_STANDARD.encode(&self.data));
        json["buffers"] = json!([{"byteLength": self.data.len(), "uri": uri}]);
        json.to_string()
    }
}

/// A GLB of JSON and a binary part.
pub(super) fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string();
    text.extend(std::iter::repeat_n(' ', text.len().next_multiple_of(4) - text.len()));
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(((28 + text.len() + binary.len()) as u32).to_le_bytes());
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(text.as_bytes());
    out.extend((binary.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(binary);
    out
}
