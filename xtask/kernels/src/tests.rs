//! Tests of the checker: it finds each kind of difference, planted in a copy of a source.
use crate::reflected::Language;
use crate::{check, compile, folder, reflect_naga, reflect_opencl};
use rhytid_kernels::table::{Binding, Entry, Kernel};
use rspirv::binary::Disassemble;
use std::fs;

const STRAIN: &Entry = Kernel::Strain.entry();

/// `text` with `from` replaced by `to`. `from` must be there.
fn plant(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "“{from}” is not in the source");
    text.replace(from, to)
}

/// `text` with `a` and `b` exchanged.
fn swap(text: &str, a: &str, b: &str) -> String {
    plant(&plant(&plant(text, a, "\u{1}"), b, a), "\u{1}", b)
}

fn wgsl(source: &str) -> Vec<String> {
    check::agrees(STRAIN, Language::Wgsl, reflect_naga::wgsl(source))
}

fn glsl(source: &str) -> Vec<String> {
    let spirv = compile::compile("strain", source).unwrap();
    assert_eq!(check::valid(&spirv), Ok(Vec::new()));
    check::agrees(STRAIN, Language::Spirv, reflect_naga::spirv(&spirv))
}

fn opencl(source: &str) -> Vec<String> {
    let compiler = reflect_opencl::Compiler::first().unwrap();
    check::agrees(STRAIN, Language::OpenCl, compiler.reflect(source))
}

/// Asserts that there are as many sentences as `expected`, and that each has all of its words.
#[track_caller]
fn assert_found(sentences: &[String], expected: &[&[&str]]) {
    assert_eq!(sentences.len(), expected.len(), "{sentences:#?}");
    for (sentence, words) in sentences.iter().zip(expected) {
        for word in *words {
            assert!(sentence.contains(word), "“{sentence}” does not say “{word}”");
        }
    }
}

#[test]
fn the_kernels_have_no_fault() {
    assert_eq!(check::all(&crate::root()), Ok(Vec::new()));
}

#[test]
fn compiling_twice_gives_the_same_bytes() {
    for kernel in Kernel::ALL.map(Kernel::entry) {
        assert_eq!(compile::compile(kernel.name, kernel.glsl), compile::compile(kernel.name, kernel.glsl));
    }
}

#[test]
fn spirv_names_no_file_and_no_version_of_a_tool() {
    for kernel in Kernel::ALL.map(Kernel::entry) {
        let module = rspirv::dr::load_bytes(kernel.spirv).unwrap();
        let sources: Vec<String> = module.debug_string_source.iter().map(Disassemble::disassemble).collect();
        assert_eq!(sources, ["OpSource GLSL 450"]);
        assert!(module.debug_module_processed.is_empty());
    }
}

#[test]
fn swapped_bindings_are_found() {
    let expected: &[&[&str]] = &[
        &["buffer 2", "found `rest_lengths`", "expected `strain_edges`"],
        &["buffer 3", "found `strain_edges`"],
    ];
    assert_found(&wgsl(&swap(STRAIN.wgsl, "@binding(2)", "@binding(3)")), expected);
    assert_found(&glsl(&swap(STRAIN.glsl, "binding = 2)", "binding = 3)")), expected);
    let edges = "__global const uint *restrict strain_edges";
    let lengths = "__global const float *restrict rest_lengths";
    assert_found(&opencl(&swap(STRAIN.opencl, edges, lengths)), expected);
}

#[test]
fn a_gap_in_the_bindings_is_found() {
    let expected: &[&[&str]] = &[&["buffer 4", "binding 7 of group 0", "binding 4 of group 0"]];
    assert_found(&wgsl(&plant(STRAIN.wgsl, "@binding(4)", "@binding(7)")), expected);
    assert_found(&glsl(&plant(STRAIN.glsl, "binding = 4)", "binding = 7)")), expected);
}

#[test]
fn another_group_is_found() {
    let expected: &[&[&str]] = &[&["buffer 4", "binding 4 of group 1", "binding 4 of group 0"]];
    let planted = plant(STRAIN.wgsl, "@group(0) @binding(4)", "@group(1) @binding(4)");
    assert_found(&wgsl(&planted), expected);
    assert_found(&glsl(&plant(STRAIN.glsl, "binding = 4)", "set = 1, binding = 4)")), expected);
}

#[test]
fn a_renamed_buffer_is_found() {
    let expected: &[&[&str]] = &[&["buffer 3", "found `lengths`", "expected `rest_lengths`"]];
    assert_found(&wgsl(&plant(STRAIN.wgsl, "rest_lengths", "lengths")), expected);
    assert_found(&glsl(&plant(STRAIN.glsl, "rest_lengths", "lengths")), expected);
    assert_found(&opencl(&plant(STRAIN.opencl, "rest_lengths", "lengths")), expected);
}

#[test]
fn a_missing_and_an_additional_buffer_are_found() {
    let missing: &[&[&str]] = &[&["buffer 4", "found none", "expected `features`"]];
    let source = plant(STRAIN.wgsl, "@group(0) @binding(4) var<storage, read_write>", "var<private>");
    assert_found(
        &wgsl(&plant(&source, "array<f32>;\n@group(0) @binding(5)", "array<f32, 9>;\n@group(0) @binding(5)")),
        missing,
    );

    let extra: &[&[&str]] = &[&["buffer 5", "found `more`", "expected none"], &["parameter block"]];
    let argument = "__global float *restrict features,";
    let planted =
        plant(STRAIN.opencl, argument, &format!("{argument}\n    __global const uint *restrict more,"));
    assert_found(&opencl(&planted), extra);
}

#[test]
fn another_element_type_is_found() {
    let expected: &[&[&str]] = &[&["buffer 2", "array of", "expected `strain_edges` (array of u32"]];
    assert_found(&glsl(&plant(STRAIN.glsl, "uint strain_edges[]", "int strain_edges[]")), expected);
    assert_found(&opencl(&plant(STRAIN.opencl, "uint *restrict", "int *restrict")), expected);
    let planted = plant(STRAIN.wgsl, "strain_edges: array<u32>", "strain_edges: array<u32, 100>");
    assert_found(&wgsl(&planted), expected);
}

#[test]
fn a_writable_input_is_found() {
    let expected: &[&[&str]] = &[&["buffer 3", "`rest_lengths` (array of f32, write", "f32, read,"]];
    let planted =
        plant(STRAIN.wgsl, "var<storage, read> rest_lengths", "var<storage, read_write> rest_lengths");
    assert_found(&wgsl(&planted), expected);
    let argument = "__global const float *restrict rest_lengths";
    assert_found(&opencl(&plant(STRAIN.opencl, argument, &argument.replace("const ", ""))), expected);
    let planted = plant(STRAIN.glsl, "readonly buffer RestLengths", "buffer RestLengths");
    assert_found(&glsl(&planted), &[&["buffer 3", "f32, read and write,", "expected"]]);
    let planted = plant(STRAIN.glsl, "writeonly buffer Features", "buffer Features");
    assert_found(&glsl(&planted), &[&["buffer 4", "f32, read and write,", "f32, write,"]]);
}

#[test]
fn another_workgroup_size_is_found() {
    let expected: &[&[&str]] = &[&["workgroup size along axis 0: found 128, expected 64"]];
    assert_found(&wgsl(&plant(STRAIN.wgsl, "@workgroup_size(64)", "@workgroup_size(128)")), expected);
    assert_found(
        &wgsl(&plant(STRAIN.wgsl, "@workgroup_size(64)", "@workgroup_size(64, 2)")),
        &[&["axis 1: found 2, expected 1"]],
    );
    assert_found(&glsl(&plant(STRAIN.glsl, "local_size_x = 64", "local_size_x = 128")), expected);
    assert_found(&opencl(&plant(STRAIN.opencl, "size(64, 1, 1)", "size(128, 1, 1)")), expected);
    // The driver would choose.
    let planted = plant(STRAIN.opencl, "__attribute__((reqd_work_group_size(64, 1, 1)))", "");
    assert_found(&opencl(&planted), &[&["found 0, expected 64"], &["found 0"], &["found 0"]]);
}

#[test]
fn a_renamed_entry_point_is_found() {
    let expected: &[&[&str]] = &[&["entry point 0", "found strains", "expected strain"]];
    assert_found(&wgsl(&plant(STRAIN.wgsl, "fn strain(", "fn strains(")), expected);
    assert_found(&opencl(&plant(STRAIN.opencl, "void strain(", "void strains(")), expected);
    let spirv = compile::compile("strains", STRAIN.glsl).unwrap();
    assert_found(&check::agrees(STRAIN, Language::Spirv, reflect_naga::spirv(&spirv)), expected);
}

#[test]
fn a_second_entry_point_is_found() {
    let second = "\n@compute @workgroup_size(64) fn other() {}\n";
    assert_found(
        &wgsl(&format!("{}{second}", STRAIN.wgsl)),
        &[&["entry point 1", "found other, expected none"]],
    );
}

#[test]
fn another_order_of_fields_is_found() {
    let expected: &[&[&str]] = &[
        &["parameter 0", "found `handles` (u32 at byte 0)", "expected `frames`"],
        &["parameter 1", "found `frames`"],
    ];
    assert_found(&wgsl(&swap(STRAIN.wgsl, "    frames: u32", "    handles: u32")), expected);
    assert_found(&glsl(&swap(STRAIN.glsl, "    uint frames;", "    uint handles;")), expected);
    assert_found(&opencl(&swap(STRAIN.opencl, "    uint frames;", "    uint handles;")), expected);
}

#[test]
fn another_type_or_name_of_a_field_is_found() {
    assert_found(
        &wgsl(&plant(STRAIN.wgsl, "    frames: u32", "    frames: i32")),
        &[&["parameter 0: found `frames`", "(u32 at byte 0)"]],
    );
    assert_found(
        &wgsl(&plant(STRAIN.wgsl, "    frames: u32", "    images: u32")),
        &[&["parameter 0: found `images` (u32 at byte 0)"]],
    );
    assert_found(
        &glsl(&plant(STRAIN.glsl, "    uint frames;", "    int frames;")),
        &[&["parameter 0: found `frames`", "(u32 at byte 0)"]],
    );
    let gap = plant(STRAIN.glsl, "    uint handles;", "    layout(offset = 16) uint handles;");
    assert_found(
        &glsl(&gap),
        &[&["found `handles` (u32 at byte 16), expected `handles` (u32 at byte 4)"], &["byte 20"]],
    );
    let planted = plant(STRAIN.opencl, "    uint frames;", "    ulong frames;");
    assert_found(&opencl(&planted), &[&["in Params", "ulong frames", "uint NAME;"]]);
    let planted = plant(STRAIN.opencl, "    uint frames;", "    uint images;");
    assert_found(&opencl(&planted), &[&["parameter 0: found `images` (u32 at byte 0)"]]);
}

#[test]
fn a_parameter_block_elsewhere_is_found() {
    let planted = plant(STRAIN.glsl, "layout(push_constant, std430)", "layout(binding = 5, std140)");
    assert_found(&glsl(&planted), &[&["found binding 5 of group 0", "expected push constants"]]);
    let planted = plant(STRAIN.wgsl, "@binding(5)", "@binding(6)");
    assert_found(&wgsl(&planted), &[&["found binding 6 of group 0", "expected binding 5 of group 0"]]);
}

#[test]
fn a_source_that_does_not_compile_is_found() {
    assert_found(&wgsl("fn"), &[&["expected"]]);
    assert_found(&opencl(&plant(STRAIN.opencl, "uint frame =", "uint frame == ")), &[&["error"]]);
    // A warning is enough; the words are clang's.
    assert_found(
        &opencl(&plant(STRAIN.opencl, "float3 e = p_a - p_b;", "float3 e = p_a - p_b; if (e.x = 1) {}")),
        &[&["assignment as a condition"]],
    );
    assert_found(&check::fresh("strain", "void", STRAIN.spirv), &[&["strain.comp does not compile"]]);
}

#[test]
fn stale_spirv_is_found() {
    let expected: &[&[&str]] = &[&["run `cargo xtask kernels`"]];
    let planted = plant(STRAIN.glsl, "e.x * e.x + e.y * e.y", "e.y * e.y + e.x * e.x");
    assert_found(&check::fresh("strain", &planted, STRAIN.spirv), expected);
    let mut flipped = STRAIN.spirv.to_vec();
    *flipped.last_mut().unwrap() ^= 1;
    assert_found(&check::fresh("strain", STRAIN.glsl, &flipped), expected);
    assert_found(&check::fresh("strain", STRAIN.glsl, &[]), expected);
}

#[test]
fn invalid_spirv_is_found() {
    let half = &STRAIN.spirv[..STRAIN.spirv.len() / 8 * 4];
    assert_found(&check::valid(half).unwrap(), &[&["spirv-val: "]]);
    assert!(!check::agrees(STRAIN, Language::Spirv, reflect_naga::spirv(half)).is_empty());
}

#[test]
fn a_readme_that_disagrees_is_found() {
    let text = fs::read_to_string(crate::root().join("strain/README.md")).unwrap();
    assert_eq!(folder::readme(STRAIN, &text), Vec::<String>::new());
    for (from, to) in [
        ("| `rest_lengths` |", "| `lengths` |"),
        ("| in, indices of handles |", "| out, indices of handles |"),
        ("| in, indices of handles |", "| in, indices of handles; tiled |"),
        ("| `features` | frames × F | out, a ratio: 0 at rest, 0.1 where stretched by a tenth |\n", ""),
    ] {
        assert_found(&folder::readme(STRAIN, &plant(&text, from, to)), &[&["row "]]);
    }
    static TILED: [Binding; 1] = [Binding { tiled: true, ..STRAIN.bindings[0] }];
    let tiled = Entry { bindings: &TILED, ..*STRAIN };
    let row = "| `handle_positions` | frames × H × 3 | in, mesh units |\n";
    assert_found(&folder::readme(&tiled, row), &[&["(in)", "(in, tiled)"]]);
}

#[test]
fn files_that_are_missing_or_unread_are_found() {
    let root = tempfile::tempdir().unwrap();
    for kernel in Kernel::ALL.map(Kernel::entry) {
        fs::create_dir(root.path().join(kernel.name)).unwrap();
        fs::write(root.path().join(kernel.name).join("README.md"), "").unwrap();
        for extension in ["cl", "comp", "spv", "wgsl"] {
            fs::write(root.path().join(format!("{0}/{0}.{extension}", kernel.name)), "").unwrap();
        }
    }
    fs::write(root.path().join("strain/mod.rs"), "").unwrap();
    assert_eq!(folder::files(root.path()), Vec::<String>::new());

    fs::remove_file(root.path().join("strain/strain.spv")).unwrap();
    assert_found(&folder::files(root.path()), &[&["strain/strain.spv: missing"]]);
    fs::write(root.path().join("strain/strian.spv"), "").unwrap();
    fs::create_dir(root.path().join("old")).unwrap();
    fs::write(root.path().join("old/old.cl"), "").unwrap();
    assert_found(
        &folder::files(root.path()),
        &[
            &["strain/strain.spv: missing"],
            &["old/old.cl: nobody reads"],
            &["strain/strian.spv: nobody reads"],
        ],
    );
}
