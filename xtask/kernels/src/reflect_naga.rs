//! WGSL and SPIR-V as naga sees them.
use crate::reflected::{Buffer, Field, PUSH_CONSTANTS, Reflected, binding_slot};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, ArraySize, Module, Scalar, StorageAccess, Type, TypeInner, VectorSize};

/// Parses and validates WGSL as in WebGPU without optional features. The error is naga's, with the place.
pub(crate) fn wgsl(source: &str) -> Result<Reflected, String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|e| e.emit_to_string(source))?;
    // `unpack2x16float` is a part of every WebGPU.
    Validator::new(ValidationFlags::all(), Capabilities::SHADER_FLOAT16_IN_FLOAT32)
        .validate(&module)
        .map_err(|e| e.emit_to_string(source))?;
    // In WGSL a kernel may also read what it may write.
    Ok(reflect(&module, "write"))
}

/// Parses SPIR-V. `spirv-val` checks its validity.
pub(crate) fn spirv(bytes: &[u8]) -> Result<Reflected, String> {
    let module = naga::front::spv::parse_u8_slice(bytes, &naga::front::spv::Options::default())
        .map_err(|e| format!("naga cannot read it: {e}"))?;
    Ok(reflect(&module, "read and write"))
}

fn reflect(module: &Module, load_and_store: &'static str) -> Reflected {
    let mut buffers = Vec::new();
    let mut params = Vec::new();
    for (_, global) in module.global_variables.iter() {
        let ty = &module.types[global.ty];
        let place = global.binding.map(|at| (at.group as usize, at.binding as usize));
        let slot = place.map_or("no binding".into(), |(group, binding)| binding_slot(group, binding));
        match global.space {
            AddressSpace::Storage { access } => {
                let (name, element) = array(module, global.name.as_deref(), ty);
                let access =
                    match (access.contains(StorageAccess::LOAD), access.contains(StorageAccess::STORE)) {
                        (true, false) => "read",
                        (false, true) => "write",
                        _ => load_and_store,
                    };
                buffers.push((place, Buffer { slot, name, element, access }));
            }
            AddressSpace::Uniform => params.push((slot, fields(module, ty))),
            AddressSpace::Immediate => params.push((PUSH_CONSTANTS.into(), fields(module, ty))),
            // Textures and samplers: no kernel has them, so each one is a difference.
            AddressSpace::Handle => {
                let name = global.name.clone().unwrap_or_default();
                buffers
                    .push((place, Buffer { slot, name, element: format!("{:?}", ty.inner), access: "read" }));
            }
            _ => {}
        }
    }
    buffers.sort_by_key(|(place, _)| *place);
    Reflected {
        entry_points: module.entry_points.iter().map(|entry| entry.name.clone()).collect(),
        workgroup_size: module.entry_points.first().map_or([0; 3], |e| e.workgroup_size.map(|n| n as usize)),
        buffers: buffers.into_iter().map(|(_, buffer)| buffer).collect(),
        params,
    }
}

/// The name and the elements of a buffer. A GLSL array must be in a block. As the block's only member it
/// gives the buffer its name.
fn array(module: &Module, name: Option<&str>, ty: &Type) -> (String, String) {
    match &ty.inner {
        TypeInner::Struct { members, .. } if members.len() == 1 => {
            array(module, members[0].name.as_deref(), &module.types[members[0].ty])
        }
        TypeInner::Array { base, size: ArraySize::Dynamic, stride } => {
            let element = &module.types[*base].inner;
            let packed = element.size(module.to_ctx()) == *stride;
            let shown = if packed { element_name(element) } else { format!("{ty:?}") };
            (name.unwrap_or_default().into(), shown)
        }
        other => (name.unwrap_or_default().into(), format!("{other:?}")),
    }
}

fn fields(module: &Module, ty: &Type) -> Vec<Field> {
    let TypeInner::Struct { members, .. } = &ty.inner else {
        let name = ty.name.clone().unwrap_or_default();
        return vec![Field { name, offset: 0, element: element_name(&ty.inner) }];
    };
    let field = |member: &naga::StructMember| Field {
        name: member.name.clone().unwrap_or_default(),
        offset: member.offset as usize,
        element: element_name(&module.types[member.ty].inner),
    };
    members.iter().map(field).collect()
}

/// The name of a scalar, or of a type of several.
fn element_name(inner: &TypeInner) -> String {
    match *inner {
        TypeInner::Vector { size: VectorSize::Bi, scalar: Scalar::U32 } => "vec2 of u32".into(),
        TypeInner::Vector { size: VectorSize::Quad, scalar: Scalar::F32 } => "vec4 of f32".into(),
        TypeInner::Scalar(Scalar::F32) => "f32".into(),
        TypeInner::Scalar(Scalar::U32) => "u32".into(),
        ref other => format!("{other:?}"),
    }
}
