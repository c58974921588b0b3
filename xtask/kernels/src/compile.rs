//! GLSL to SPIR-V, by the pinned glslang.
use glslang::{Compiler, CompilerOptions, Shader, ShaderInput, ShaderMessage, ShaderSource, ShaderStage};
use glslang::{SourceLanguage, SpirvVersion, Target, VulkanVersion};
use rspirv::binary::Assemble;
use rspirv::dr::{Module, Operand, load_words};

/// The SPIR-V 1.3 module of a compute shader, in little-endian bytes, for Vulkan 1.1. Its entry point `main`
/// is renamed to `name`. The module keeps the names of variables and members, which `--check` reads. It has
/// no other debug information, so that the same source gives the same bytes on every machine.
///
/// The error is glslang's message.
pub(crate) fn compile(name: &str, glsl: &str) -> Result<Vec<u8>, String> {
    let compiler = Compiler::acquire().ok_or("glslang could not be started")?;
    let options = CompilerOptions {
        source_language: SourceLanguage::GLSL,
        target: Target::Vulkan { version: VulkanVersion::Vulkan1_1, spirv_version: SpirvVersion::SPIRV1_3 },
        version_profile: None,
        messages: ShaderMessage::DEFAULT | ShaderMessage::VULKAN_RULES | ShaderMessage::SPV_RULES,
    };
    let source = ShaderSource::from(glsl);
    let no_defines = None::<&[(&str, Option<&str>)]>;
    let words = ShaderInput::new(&source, ShaderStage::Compute, &options, no_defines, None)
        .and_then(|input| Shader::new(compiler, input).parse())
        .and_then(|shader| shader.compile())
        .map_err(|e| in_one_line(&e.to_string()))?;
    let mut module = load_words(words).map_err(|e| format!("glslang's SPIR-V cannot be read: {e}"))?;
    rename_entry_point(&mut module, name);
    Ok(module.assemble().into_iter().flat_map(u32::to_le_bytes).collect())
}

/// The C interface of glslang has a renaming of its own, but forgets the new name when it preprocesses.
fn rename_entry_point(module: &mut Module, name: &str) {
    let names = module.debug_names.iter_mut().chain(&mut module.entry_points);
    for operand in names.flat_map(|instruction| &mut instruction.operands) {
        if *operand == Operand::LiteralString("main".into()) {
            *operand = Operand::LiteralString(name.into());
        }
    }
}

/// glslang's log without its headings.
fn in_one_line(log: &str) -> String {
    let lines = log.lines().map(str::trim).filter(|l| !l.is_empty() && *l != "Log:" && *l != "DebugLog:");
    lines.collect::<Vec<_>>().join("; ")
}
