//! `cargo xtask kernels [--check]`: makes each kernel's SPIR-V from its GLSL, or checks that the kernels of
//! all languages agree with the one table, [`rhytid_kernels::table`].
//!
//! It is a package of its own. It needs a C++ compiler (glslang) and the OpenCL loader, which `cargo xtask
//! setup` installs first.
#![forbid(unsafe_code)]

mod check;
mod compile;
mod folder;
mod reflect_naga;
mod reflect_opencl;
mod reflect_rust;
mod reflected;
#[cfg(test)]
mod tests;

use rhytid_kernels::table::Kernel;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Where the kernels' folders are.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates/kernels/src")
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let outcome = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => write(),
        ["--check"] => check::all(&root()),
        _ => Err("usage: xtask-kernels [--check]".into()),
    };
    match outcome {
        Ok(sentences) if sentences.is_empty() => ExitCode::SUCCESS,
        Ok(sentences) => {
            for sentence in &sentences {
                eprintln!("error: {sentence}");
            }
            eprintln!("error: faults found: {}", sentences.len());
            ExitCode::FAILURE
        }
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

/// Compiles every kernel. Returns a sentence for each that does not compile.
fn write() -> Result<Vec<String>, String> {
    let mut errors = Vec::new();
    for kernel in Kernel::ALL.map(Kernel::entry) {
        let path = root().join(kernel.name).join(format!("{}.spv", kernel.name));
        match compile::compile(kernel.name, kernel.glsl) {
            // An unchanged file is not written, so that nothing is built again.
            Ok(bytes) if bytes == kernel.spirv => {}
            Ok(bytes) => {
                std::fs::write(&path, &bytes).map_err(|e| format!("{}: {e}", path.display()))?;
                println!("{}.spv: {} bytes", kernel.name, bytes.len());
            }
            Err(error) => errors.push(format!("{0}/{0}.comp: {error}", kernel.name)),
        }
    }
    Ok(errors)
}
