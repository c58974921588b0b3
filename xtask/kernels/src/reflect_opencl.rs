//! OpenCL C as a driver sees it. A compiler tells everything except the fields of the parameter block, which
//! OpenCL cannot query. They are read from the text.
use crate::reflected::{Buffer, Field, Reflected, argument_slot};
use ocl::core::{
    Context, DeviceId, Kernel, KernelArgAddressQualifier, KernelArgInfo, KernelArgInfoResult,
    KernelArgTypeQualifier, KernelInfo, KernelInfoResult, KernelWorkGroupInfo, KernelWorkGroupInfoResult,
    ProgramBuildInfo, ProgramInfo, ProgramInfoResult,
};
use std::ffi::CString;
use std::sync::{Mutex, PoisonError};

/// A warning is an error. Drivers keep the names of arguments only on request.
const BUILD_OPTIONS: &str = "-cl-std=CL1.2 -cl-kernel-arg-info -Werror";

/// The OpenCL device that kernels are compiled for.
pub(crate) struct Compiler {
    device: DeviceId,
    context: Context,
}

impl Compiler {
    /// The first device of the first platform that has one.
    pub(crate) fn first() -> Result<Self, String> {
        // The ICD loader fails if two threads ask for the first time at once.
        static FIRST: Mutex<()> = Mutex::new(());
        let _turn = FIRST.lock().unwrap_or_else(PoisonError::into_inner);
        let platforms = ocl::core::get_platform_ids().unwrap_or_default();
        let devices = |platform| ocl::core::get_device_ids(platform, Some(ocl::flags::DEVICE_TYPE_ALL), None);
        let device = platforms.iter().find_map(|platform| devices(platform).ok()?.first().copied()).ok_or(
            "there is no OpenCL device to compile the kernels for: run `cargo xtask setup`, or install pocl-opencl-icd",
        )?;
        let context = ocl::core::create_context(None, &[device], None, None)
            .map_err(|e| format!("no OpenCL context can be made: {e}"))?;
        Ok(Self { device, context })
    }

    /// Compiles and reflects a source. The error is the compiler's.
    pub(crate) fn reflect(&self, source: &str) -> Result<Reflected, String> {
        let text = CString::new(source).map_err(|_| "a zero byte in the source")?;
        let program =
            ocl::core::create_program_with_source(&self.context, &[text]).map_err(|e| e.to_string())?;
        let options = CString::new(BUILD_OPTIONS).map_err(|e| e.to_string())?;
        if let Err(error) = ocl::core::build_program(&program, Some(&[self.device]), &options, None, None) {
            let log = ocl::core::get_program_build_info(&program, self.device, ProgramBuildInfo::BuildLog);
            return Err(log.map_or(error.to_string(), |log| log.to_string()));
        }
        let names = match ocl::core::get_program_info(&program, ProgramInfo::KernelNames) {
            Ok(ProgramInfoResult::KernelNames(names)) => names,
            other => return Err(format!("the driver does not say what kernels there are: {other:?}")),
        };
        let entry_points: Vec<String> =
            names.split(';').filter(|name| !name.is_empty()).map(Into::into).collect();
        let first = entry_points.first().ok_or("no kernel")?;
        let kernel = ocl::core::create_kernel(&program, first).map_err(|e| e.to_string())?;
        let (buffers, params) = arguments(&kernel, source)?;
        Ok(Reflected { workgroup_size: self.workgroup_size(&kernel)?, entry_points, buffers, params })
    }

    fn workgroup_size(&self, kernel: &Kernel) -> Result<[usize; 3], String> {
        let request = KernelWorkGroupInfo::CompileWorkGroupSize;
        match ocl::core::get_kernel_work_group_info(kernel, self.device, request) {
            Ok(KernelWorkGroupInfoResult::CompileWorkGroupSize(size)) => Ok(size),
            other => Err(format!("the driver does not say the workgroup size: {other:?}")),
        }
    }
}

type Arguments = (Vec<Buffer>, Vec<(String, Vec<Field>)>);

fn arguments(kernel: &Kernel, source: &str) -> Result<Arguments, String> {
    let count = match ocl::core::get_kernel_info(kernel, KernelInfo::NumArgs) {
        Ok(KernelInfoResult::NumArgs(count)) => count,
        other => return Err(format!("the driver does not say how many arguments there are: {other:?}")),
    };
    let (mut buffers, mut params) = (Vec::new(), Vec::new());
    for index in 0..count {
        let slot = argument_slot(index as usize);
        let ask = |request| {
            ocl::core::get_kernel_arg_info(kernel, index, request, None)
                .map_err(|e| format!("the driver says nothing about {slot}: {e}"))
        };
        let (name, ty) = (ask(KernelArgInfo::Name)?.to_string(), ask(KernelArgInfo::TypeName)?.to_string());
        let private = matches!(
            ask(KernelArgInfo::AddressQualifier)?,
            KernelArgInfoResult::AddressQualifier(KernelArgAddressQualifier::Private)
        );
        let constant = matches!(
            ask(KernelArgInfo::TypeQualifier)?,
            KernelArgInfoResult::TypeQualifier(q) if q.contains(KernelArgTypeQualifier::CONST)
        );
        if private && ty == "Params" {
            params.push((slot, fields(source)?));
            continue;
        }
        let element = match ty.as_str() {
            "float*" => "f32".into(),
            "uint*" => "u32".into(),
            _ => ty,
        };
        buffers.push(Buffer { slot, name, element, access: if constant { "read" } else { "write" } });
    }
    Ok((buffers, params))
}

/// The fields of `Params`. They must be written in this plain form: `typedef struct {`, a line ` uint NAME;`
/// each, `} Params;`.
fn fields(source: &str) -> Result<Vec<Field>, String> {
    let mut parts = source.split("typedef struct {\n");
    let text = match (parts.next(), parts.next(), parts.next()) {
        (Some(before), Some(after), None) if before.is_empty() || before.ends_with('\n') => after,
        _ => return Err("expected `typedef struct {` once, on a line of its own".into()),
    };
    let (text, _) = text.split_once("\n} Params;\n").ok_or("the struct does not end in `} Params;`")?;
    let field = |(index, line): (usize, &str)| {
        let name = line.strip_prefix("    uint ").and_then(|line| line.strip_suffix(';'));
        let name = name.filter(|name| name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_'));
        let name = name.ok_or_else(|| format!("in Params: found “{line}”, expected `    uint NAME;`"))?;
        Ok(Field { name: name.into(), offset: 4 * index, element: "u32".into() })
    };
    text.lines().enumerate().map(field).collect()
}
