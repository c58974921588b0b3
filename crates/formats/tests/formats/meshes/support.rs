use rhytid_core::{Error, Mesh};
use rhytid_formats::mesh::{Format, decode};
use rhytid_test_support::Logged;

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
