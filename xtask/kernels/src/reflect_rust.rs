//! The parameter blocks of the Rust references, which the host fills in, with their fields in memory order.
use crate::reflected::Field;
use bytemuck::Pod;
use rhytid_kernels::{
    bands, beyond, clusters, detail, differences, fine_scale, large_scale, normals, strain,
    vector_differences,
};
use std::fmt::Debug;

/// The fields of a kernel's `Params`; `None` for a kernel that is not listed here.
pub(crate) fn fields(kernel: &str) -> Option<Vec<Field>> {
    Some(match kernel {
        "strain" => fields_of::<strain::Params>(),
        "large_scale" => fields_of::<large_scale::Params>(),
        "vector_differences" => fields_of::<vector_differences::Params>(),
        "bands" => fields_of::<bands::Params>(),
        "beyond" => fields_of::<beyond::Params>(),
        "clusters" => fields_of::<clusters::Params>(),
        "normals" => fields_of::<normals::Params>(),
        "differences" => fields_of::<differences::Params>(),
        "detail" => fields_of::<detail::Params>(),
        "fine_scale" => fields_of::<fine_scale::Params>(),
        _ => return None,
    })
}

/// Fills the block with the offsets 0, 4, 8, … and parses its debug text: `Params { frames: 0, vertices: 4, …
/// }`.
fn fields_of<P: Pod + Debug>() -> Vec<Field> {
    let offsets: Vec<u8> = (0..size_of::<P>() as u32).step_by(4).flat_map(u32::to_le_bytes).collect();
    let shown = format!("{:?}", bytemuck::pod_read_unaligned::<P>(&offsets));
    let inside = shown.trim_start_matches("Params {").trim_end_matches('}');
    let field = |text: &str| {
        let (name, offset) = text.split_once(": ")?;
        let offset = offset.trim().parse().ok()?;
        Some(Field { name: name.trim().into(), offset, element: "u32".into() })
    };
    inside.split(", ").filter_map(field).collect()
}
