//! The checks. Each is a list with one sentence for each fault.
use crate::reflected::{Language, Reflected, compare, differences, parameters};
use crate::{compile, folder, reflect_naga, reflect_opencl, reflect_rust};
use rhytid_kernels::table::{Entry, Kernel};
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::process::{Command, Stdio};

/// Checks all kernels. `root` holds a folder for each. The error says what the check itself lacks.
pub(crate) fn all(root: &Path) -> Result<Vec<String>, String> {
    let opencl = reflect_opencl::Compiler::first()?;
    let mut all = folder::files(root);
    for kernel in Kernel::ALL.map(Kernel::entry) {
        let readme = fs::read_to_string(root.join(kernel.name).join("README.md")).unwrap_or_default();
        let mut add = |file: String, found: Vec<String>| {
            all.extend(found.into_iter().map(|sentence| format!("{}/{file}: {sentence}", kernel.name)));
        };
        add("README.md".into(), folder::readme(kernel, &readme));
        add("mod.rs".into(), rust(kernel));
        add(format!("{}.spv", kernel.name), fresh(kernel.name, kernel.glsl, kernel.spirv));
        add(format!("{}.spv", kernel.name), valid(kernel.spirv)?);
        for language in Language::ALL {
            let reflected = match language {
                Language::Spirv => reflect_naga::spirv(kernel.spirv),
                Language::Wgsl => reflect_naga::wgsl(kernel.wgsl),
                Language::OpenCl => opencl.reflect(kernel.opencl),
            };
            add(format!("{}.{}", kernel.name, language.extension()), agrees(kernel, language, reflected));
        }
    }
    Ok(all)
}

/// A source that does not compile is a difference too.
pub(crate) fn agrees(
    kernel: &Entry,
    language: Language,
    reflected: Result<Reflected, String>,
) -> Vec<String> {
    match reflected {
        Ok(reflected) => differences(kernel, language, &reflected),
        Err(error) => vec![error],
    }
}

/// Checks that the committed SPIR-V equals the result of the GLSL, byte for byte.
pub(crate) fn fresh(name: &str, glsl: &str, spirv: &[u8]) -> Vec<String> {
    match compile::compile(name, glsl) {
        Ok(bytes) if bytes == spirv => Vec::new(),
        Ok(_) => vec![format!("not what {name}.comp gives: run `cargo xtask kernels`")],
        Err(error) => vec![format!("{name}.comp does not compile: {error}")],
    }
}

/// The messages of `spirv-val`.
pub(crate) fn valid(spirv: &[u8]) -> Result<Vec<String>, String> {
    let cannot = |e: std::io::Error| match e.kind() {
        ErrorKind::NotFound => {
            "spirv-val is not installed: run `cargo xtask setup`, or install spirv-tools".into()
        }
        _ => format!("spirv-val cannot be run: {e}"),
    };
    let mut validator = Command::new("spirv-val");
    validator.args(["--target-env", "vulkan1.1", "-"]);
    validator.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = validator.spawn().map_err(cannot)?;
    let written = child.stdin.take().map_or(Ok(()), |mut stdin| stdin.write_all(spirv));
    let output = child.wait_with_output().map_err(cannot)?;
    if output.status.success() {
        return written.map(|()| Vec::new()).map_err(cannot);
    }
    let message = [output.stdout, output.stderr].concat();
    Ok(vec![format!("spirv-val: {}", String::from_utf8_lossy(&message).trim())])
}

/// The differences of the parameter block that the host fills in.
fn rust(kernel: &Entry) -> Vec<String> {
    match reflect_rust::fields(kernel.name) {
        Some(fields) => compare("parameter", &fields, &parameters(kernel)),
        None => {
            vec!["its Params are not checked: add the kernel to xtask/kernels/src/reflect_rust.rs".into()]
        }
    }
}
