//! Meshes as GLB.
use rhytid_core::Mesh;

/// The mesh as a GLB of triangles, with its vertices in their order. Polygons are cut from their first
/// corner.
pub fn glb(mesh: &Mesh) -> Vec<u8> {
    let mut positions: Vec<u8> = Vec::new();
    for x in mesh.positions.as_flattened() {
        positions.extend((*x as f32).to_le_bytes());
    }
    let mut indices: Vec<u8> = Vec::new();
    for face in mesh.faces.iter() {
        for pair in face[1..].windows(2) {
            [face[0], pair[0], pair[1]].into_iter().for_each(|v| indices.extend(v.to_le_bytes()));
        }
    }
    let (vertices, corners) = (mesh.positions.len(), indices.len() / 4);
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":{vertices},"type":"VEC3"}},
{{"bufferView":1,"componentType":5125,"count":{corners},"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteLength":{0}}},{{"buffer":0,"byteOffset":{0},"byteLength":{1}}}],
"buffers":[{{"byteLength":{2}}}]}}"#,
        positions.len(),
        indices.len(),
        positions.len() + indices.len()
    );
    while json.len() % 4 != 0 {
        json.push(' ');
    }
    let binary = [positions, indices].concat();
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let word = |number: usize| (number as u32).to_le_bytes();
    let mut glb = b"glTF".to_vec();
    [2, length, json.len()].into_iter().for_each(|number| glb.extend(word(number)));
    glb.extend(b"JSON");
    glb.extend(json.as_bytes());
    glb.extend(word(binary.len()));
    glb.extend(b"BIN\0");
    glb.extend(binary);
    glb
}
