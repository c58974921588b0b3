//! A renderer's own Vulkan device: drawn with, and lost.
use crate::support::{FILES, GCC, GXX, command, has, own, said};
use rhytid::core::Backend;
use rhytid::devices::vulkan::Vulkan;
use rhytid_test_support::skip;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What these tests need of Vulkan beyond a device.
const NEEDED: [&str; 2] =
    ["/usr/include/vulkan/vulkan.h", "/usr/share/vulkan/explicit_layer.d/VkLayer_khronos_validation.json"];

/// Whether a device, Vulkan's headers and its validation layer are here.
#[track_caller]
fn has_vulkan() -> bool {
    let has_device = Vulkan::devices().is_ok_and(|devices| !devices.is_empty());
    if has_device && NEEDED.iter().all(|file| Path::new(file).is_file()) {
        return true;
    }
    skip(
        "a Vulkan device, its headers or its validation layer is missing: `cargo xtask setup` installs them",
    );
    false
}

/// The pixels of a picture: rows of RGB.
fn pixels(path: &Path) -> Vec<[u8; 3]> {
    let bytes = std::fs::read(path).unwrap();
    let header = b"P6\n768 768\n255\n";
    assert!(bytes.starts_with(header));
    let pixels = bytes[header.len()..].chunks_exact(3).map(|rgb| rgb.try_into().unwrap()).collect::<Vec<_>>();
    assert_eq!(pixels.len(), 768 * 768);
    pixels
}

#[test]
fn the_example_draws_with_the_buffers() {
    if !has_vulkan() || !has(&["glslangValidator"]) {
        return;
    }
    let folder = FILES.folder.path();
    for shader in ["face.vert", "face.frag"] {
        let name = shader.replace('.', "_");
        let mut compile = Command::new("glslangValidator");
        compile.args(["-V", "--quiet", "--vn", &name, "-o"]).arg(folder.join(format!("{name}.h")));
        said(compile.arg(own().join("examples").join(shader)));
    }
    let include = format!("-I{}", folder.display());
    // Vulkan's constants make comparisons and conversions that these warnings are about.
    let flags = [&include, "-Wno-missing-field-initializers", "-Wno-conversion", "-lvulkan"];
    let Some(program) = GXX.build("examples/draw_take.cpp", &flags) else { return };
    let draw = |frame: &str| {
        let picture = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("draw_take_{frame}.ppm"));
        let mut draw = command(&program);
        draw.env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation");
        // The layer writes its messages to standard output.
        let said = said(draw.args([&FILES.rig_file, &FILES.take_file]).arg(frame).arg(&picture));
        assert_eq!(said.lines().count(), 1, "{said}");
        pixels(&picture)
    };
    let (first, later) = (draw("0"), draw("19"));
    let background = first[0];
    let face = first.iter().filter(|pixel| **pixel != background).count();
    // The face fills most of the picture, stands in its middle, and moves.
    assert!((768 * 768 * 2 / 10..768 * 768 * 9 / 10).contains(&face), "{face} pixels");
    assert_ne!(first[768 * 384 + 384], background);
    let moved = first.iter().zip(&later).filter(|(a, b)| a != b).count();
    assert!(moved > 1_000 && moved < face, "{moved} pixels differ");
    // Lit from the upper left: the forehead's left is brighter than its right.
    let light = |x: usize| (150..250).map(|y| u32::from(first[768 * y + x][0])).sum::<u32>();
    assert!(light(300) > light(468), "{} and {}", light(300), light(468));
}

/// Vulkan's validation layer sees two threads in the same queue, and all else that is wrong.
#[test]
fn two_threads_share_a_queue() {
    if !has_vulkan() {
        return;
    }
    let Some(program) = GCC.build("tests/capi/programs/queue.c", &["-lvulkan", "-Wno-pedantic"]) else {
        return;
    };
    let mut play = command(program);
    play.env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation");
    // The layer writes its messages to standard output.
    let said = said(play.args([&FILES.rig_file, &FILES.take_file]));
    assert_eq!(said.trim(), "the queue is shared");
}

#[test]
fn a_lost_device_is_an_error_and_the_program_goes_on() {
    if !has_vulkan() {
        return;
    }
    let Some(program) = GCC.build("tests/capi/programs/lost.c", &["-lvulkan", "-Wno-pedantic"]) else {
        return;
    };
    assert_eq!(said(command(program).arg(&FILES.rig_file)).trim(), "a lost device is an error");
}
