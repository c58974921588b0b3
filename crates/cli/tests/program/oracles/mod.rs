//! What other programs show of the files that `animate` writes, compared with the library's own evaluation.
//! The programs are Blender, three.js in a browser and two versions of USD. Other tests cover moving
//! pictures.

#[cfg(feature = "film")]
mod animated_image;
mod animation;
mod faces;
mod point_cache;
mod programs;
mod strain;
mod wrinkles;

use animation::{Animation, distance};
use programs::{Frames, Read, Shown};
use rhytid::core::{RigidMotion, Tissue, UpAxis};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A file to export.
struct Export {
    file: &'static str,
    options: &'static str,
    /// The largest distance between a vertex and its place that the file itself may cause, in millimetres.
    error: f64,
}

/// The error of a file with every frame, in millimetres. glTF rounds the offsets from the first frame to
/// float32. Together with the programs' rounding it is below a thousandth.
const EXACT: f64 = 5e-4;

/// The programs' own error, in millimetres: they compute with float32 coordinates.
const ROUNDING: f64 = 1e-4;

/// How far the programs turn a normal. The times of a glTF file are float32 as well, so each frame contains a
/// trace of the next one.
const NORMAL_ROUNDING: f64 = 2e-5;

const EXPORTS: &[Export] = &[
    exact("face.usda", ""),
    exact("face.usd", ""),
    exact("face.usdc", ""),
    exact("face.usdz", ""),
    exact("plain.usda", "--no-normals"),
    exact("plain.usd", "--no-normals"),
    exact("blurred.usda", "--velocities"),
    exact("blurred.usd", "--velocities"),
    exact("face.glb", ""),
    exact("face.gltf", ""),
    exact("plain.glb", "--no-normals"),
    exact("packed.glb", "--meshopt"),
    exact("strained.glb", "--strain"),
    within(0.01, "quantized.glb", "--quantize"),
    within(0.1, "compressed.glb", "--compressed"),
    within(0.02, "fine.gltf", "--compressed --max-error 0.02"),
    within(0.1, "small.glb", "--compressed --quantize --meshopt"),
    within(0.5, "shapes.glb", "--shapes 6 --quantize"),
    within(0.5, "shapes.usd", "--shapes 6"),
];

const HEAD_EXPORTS: &[Export] = &[
    exact("head.usd", ""),
    exact("head.glb", ""),
    within(0.1, "compressed.glb", "--compressed"),
    within(0.1, "small.glb", "--compressed --quantize --meshopt"),
];

const fn exact(file: &'static str, options: &'static str) -> Export {
    within(EXACT, file, options)
}

const fn within(error: f64, file: &'static str, options: &'static str) -> Export {
    Export { file, options, error }
}

impl Export {
    fn is_usd(&self) -> bool {
        self.file.contains(".usd")
    }

    fn is_gltf(&self) -> bool {
        !self.is_usd()
    }

    /// USD with a sample of the points in each frame, rather than weights of shapes.
    fn has_points(&self) -> bool {
        self.is_usd() && !self.options.contains("--shapes")
    }

    fn has_normals(&self) -> bool {
        !self.options.contains("--no-normals")
    }

    /// Blender 5.0 does not know EXT_meshopt_compression.
    fn opens_in_blender(&self) -> bool {
        !self.options.contains("--meshopt")
    }
}

impl std::fmt::Display for Export {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.file, self.options)
    }
}

/// Exports those of `exports` that `chosen` accepts. Returns them and their files.
fn export<'a>(
    animation: &Animation,
    exports: &'a [Export],
    chosen: fn(&Export) -> bool,
) -> (Vec<&'a Export>, Vec<PathBuf>) {
    let chosen: Vec<&Export> = exports.iter().filter(|e| chosen(e)).collect();
    let files = chosen.iter().map(|e| animation.export(e.file, e.options)).collect();
    (chosen, files)
}

/// Asserts that every vertex is shown, in every frame, within the error that the file states.
fn assert_shown(program: &str, export: &Export, animation: &Animation, shown: &Shown, up: UpAxis) {
    let what = format!("{program}, {} as {export}", animation.rig.surface().name);
    let allowed = shown.stated.unwrap_or(export.error);
    assert!(allowed <= export.error, "{what}: {allowed} mm are stated, {} were asked for", export.error);
    assert_eq!(
        shown.ids.is_some(),
        export.is_gltf(),
        "{what}: whether the original's vertex numbers are there"
    );
    let vertices = animation.rig.vertices();
    let mut seen = vec![false; vertices];
    let mut worst = (0.0, 0, 0);
    for (frame, positions) in shown.positions.iter().enumerate() {
        let expected = animation.metres(frame, up);
        for (v, position) in original(shown).zip(positions) {
            seen[v] = true;
            let error = 1e3 * distance(*position, expected[v]);
            assert!(error.is_finite(), "{what}: vertex {v} of frame {frame} is at {position:?}");
            if error > worst.0 {
                worst = (error, frame, v);
            }
        }
    }
    let (error, frame, v) = worst;
    eprintln!("{what}: off by {error:.1e} mm at most, {allowed:.1e} allowed");
    assert!(error <= allowed + ROUNDING, "{what}: vertex {v} is off by {error} mm in frame {frame}");
    // A vertex without a face is not in a glTF file.
    let missing = animation.rig.surface().faces.indices.iter().find(|&&v| !seen[v as usize]);
    assert_eq!(missing, None, "{what}: a vertex is not shown");
}

/// The original vertex number of each shown vertex. In a file without numbers they are in the original order.
fn original(shown: &Shown) -> impl Iterator<Item = usize> + '_ {
    (0..shown.positions[0].len()).map(|i| shown.ids.as_ref().map_or(i, |ids| ids[i] as usize))
}

#[test]
fn blender_shows_every_frame() {
    check_blender(faces::demo(), EXPORTS);
    check_blender(faces::other_axes_and_units(), EXPORTS);
}

fn check_blender(animation: &Animation, exports: &[Export]) {
    let (exports, files) = export(animation, exports, Export::opens_in_blender);
    let all = programs::blender(&files, &animation.frames);
    assert_eq!(all.len(), exports.len());
    for (export, shown) in exports.into_iter().zip(&all) {
        assert_shown("Blender", export, animation, shown, UpAxis::Z);
        if export.has_normals() {
            assert_shading(export, animation, shown);
        }
    }
}

/// Asserts that Blender shades every frame with the normals that docs/export.md describes for each format.
/// A USD file has the normals of every frame. A glTF file has those of the mesh without its targets, and
/// Blender turns them with the skin.
fn assert_shading(export: &Export, animation: &Animation, shown: &Shown) {
    let normals = shown.normals.as_ref().expect("Blender's normals");
    let mut off = Vec::new();
    for (frame, normals) in normals.iter().enumerate() {
        let expected = animation.normals(frame, UpAxis::Z);
        for (v, normal) in original(shown).zip(normals) {
            let length = distance(*normal, [0.0; 3]);
            if expected[v] != [0.0; 3] && length > 0.0 {
                let apart = distance(normal.map(|x| x / length), expected[v]);
                off.push(2.0 * (0.5 * apart).min(1.0).asin().to_degrees());
            }
        }
    }
    off.sort_by(f64::total_cmp);
    let at = |part: f64| off[((off.len() - 1) as f64 * part) as usize];
    let (median, most, worst) = (at(0.5), at(0.99), at(1.0));
    eprintln!(
        "Blender, {} as {export}: shading off by {median:.2}° (median), {most:.2}° (99 %), {worst:.1}°",
        animation.rig.surface().name
    );
    let allowed = if export.has_points() { 0.1 } else { 4.0 };
    assert!(most < allowed, "{export}: 1 % of the normals are more than {most}° off");
}

/// The head's file names no materials. Its makers say which vertices are what.
#[test]
fn the_parts_of_the_real_head_are_told_apart() {
    let Some(animation) = faces::real_head() else { return };
    let surface = animation.rig.surface();
    let materials = surface.materials.as_ref().expect("materials by parts");
    let parts = [
        (0..9409, Tissue::Skin),
        (14_062..17_039, Tissue::Mouth),
        (17_039..21_451, Tissue::Teeth),
        (21_451..24_591, Tissue::Eye),
        (24_591..24_999, Tissue::Clear),
        (25_351..26_719, Tissue::Hair),
    ];
    for (vertices, tissue) in parts {
        let mut faces = 0;
        for (face, &material) in surface.faces.iter().zip(&materials.of_face) {
            if vertices.contains(&(face[0] as usize)) {
                let found = &materials.list[material as usize];
                assert_eq!(found.tissue, tissue, "vertex {}: {}", face[0], found.name);
                faces += 1;
            }
        }
        assert!(faces > 0, "{vertices:?}");
    }
}

#[test]
fn blender_makes_alembic_of_usd() {
    for animation in [faces::demo(), faces::other_axes_and_units()] {
        let name = &animation.rig.surface().name;
        let alembic = programs::blender_alembic(&animation.export("alembic.usd", ""), animation.frames.rate);
        let shown = &programs::blender(&[alembic], &animation.frames)[0];
        for (frame, positions) in shown.positions.iter().enumerate() {
            let expected = animation.metres(frame, UpAxis::Z);
            assert_eq!(positions.len(), expected.len(), "{name}");
            for (v, (position, expected)) in positions.iter().zip(expected).enumerate() {
                let error = 1e3 * distance(*position, expected);
                assert!(error <= EXACT, "{name}: vertex {v} is off by {error} mm in frame {frame}");
            }
        }
        assert_shading(&exact("alembic.usd", ""), animation, shown);
    }
}

#[test]
fn three_js_shows_every_frame() {
    check_three(faces::demo(), EXPORTS);
    check_three(faces::other_axes_and_units(), EXPORTS);
}

#[test]
fn both_show_the_real_head() {
    if let Some(animation) = faces::real_head() {
        check_blender(animation, HEAD_EXPORTS);
        check_three(animation, HEAD_EXPORTS);
    }
}

fn check_three(animation: &Animation, exports: &[Export]) {
    let (exports, files) = export(animation, exports, Export::is_gltf);
    let all = programs::three(&files, &animation.frames);
    assert_eq!(all.len(), exports.len());
    for (export, shown) in exports.into_iter().zip(&all) {
        assert_shown("three.js", export, animation, shown, UpAxis::Y);
        assert!(shown.stated.is_some(), "{export} states no error");
        if export.error == EXACT && export.has_normals() {
            assert_normals(export, animation, shown);
        }
        let picture = format!("{}-{}.png", animation.rig.surface().name, export.file);
        assert_picture(&picture, shown.picture.as_deref().expect("three.js took a picture"));
    }
}

/// Asserts that the normals of every frame point where the library's do.
fn assert_normals(export: &Export, animation: &Animation, shown: &Shown) {
    let normals = shown.normals.as_ref().unwrap_or_else(|| panic!("{} has no normals", export.file));
    let mut worst = 0.0f64;
    for (frame, normals) in normals.iter().enumerate() {
        let expected = animation.normals(frame, UpAxis::Y);
        for (v, normal) in original(shown).zip(normals) {
            // A vertex without a normal has a meaningless one in a glTF file.
            if expected[v] != [0.0; 3] {
                let length = distance(*normal, [0.0; 3]);
                let error = distance(normal.map(|x| x / length), expected[v]);
                assert!(
                    error <= NORMAL_ROUNDING,
                    "{}: the normal {v} of frame {frame} is off by {error}",
                    export.file
                );
                worst = worst.max(error);
            }
        }
    }
    eprintln!("three.js: {}: normals off by {worst:.1e} at most", export.file);
}

/// Asserts that something stands in front of the background, in many shades. Leaves the picture for people to
/// see.
fn assert_picture(name: &str, png: &[u8]) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("three.js");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, png).unwrap();
    eprintln!("three.js: drew {}", path.display());

    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let pixels: Vec<&[u8]> = bytes.chunks_exact(info.color_type.samples()).collect();
    let background = pixels[0];
    let drawn: Vec<&&[u8]> = pixels.iter().filter(|pixel| **pixel != background).collect();
    let share = drawn.len() as f64 / pixels.len() as f64;
    assert!((0.2..0.8).contains(&share), "{}: {share} of the picture is drawn on", path.display());
    let shades: std::collections::HashSet<_> = drawn.iter().collect();
    assert!(shades.len() >= 50, "{}: {} shades", path.display(), shades.len());
}

#[test]
fn usd_26_11_reads_every_bit() {
    usd_reads_every_bit("venv", [0, 26, 11]);
}

#[test]
fn usd_24_3_reads_every_bit() {
    usd_reads_every_bit("venv-usd-24.3", [0, 24, 3]);
}

fn usd_reads_every_bit(environment: &str, version: [u64; 3]) {
    let made = [faces::demo(), faces::other_axes_and_units()].map(|animation| (animation, EXPORTS));
    let real = faces::real_head().map(|animation| (animation, HEAD_EXPORTS));
    for (animation, exports) in made.into_iter().chain(real) {
        let (exports, files) = export(animation, exports, Export::has_points);
        let all = programs::usd(environment, version, &files);
        assert_eq!(all.len(), exports.len());
        for (export, read) in exports.iter().zip(&all) {
            assert_samples(export, animation, read);
            let other = exports.iter().position(|e| e.options == export.options).unwrap();
            let same = all[other].flattened == read.flattened;
            assert!(same, "{} and {export} are not the same scene", exports[other]);
        }
    }
}

/// Asserts that animated attributes have the bits that the library computes, at the frames' numbers.
fn assert_samples(export: &Export, animation: &Animation, read: &Read) {
    let Frames { first, count, .. } = animation.frames;
    let codes: Vec<f64> = (first..first + count).map(|code| code as f64).collect();
    let frame = 3 * animation.rig.vertices();
    let extents: Vec<f32> = animation.positions.chunks(frame).flat_map(extent).collect();
    let mut expected = BTreeMap::from([("extent", bytes(&extents)), ("points", bytes(&animation.positions))]);
    if export.has_normals() {
        expected.insert("normals", bytes(&animation.normals));
    }
    if let Some(head) = &animation.head {
        expected.insert("xformOp:transform", head.iter().flat_map(usd_matrix).collect());
    }
    let mut samples = read.samples.clone();
    if export.options.contains("--velocities") {
        let (found_codes, found) = samples.remove("velocities").expect("velocities");
        assert_eq!(found_codes, codes, "{export}: time codes of velocities");
        assert_velocities(export, animation, &found);
    }
    assert!(samples.keys().eq(expected.keys()), "{export}: {:?} are animated", samples.keys());
    for (name, (found_codes, found)) in samples {
        assert_eq!(found_codes, codes, "{export}: time codes of {name}");
        assert!(found == expected[name.as_str()], "{export}: {name} has other bits than were computed");
    }
}

/// Asserts that velocities lead from the frame before to the frame after. The first and the last frame are
/// left out.
fn assert_velocities(export: &Export, animation: &Animation, found: &[u8]) {
    let found: Vec<f64> = found.as_chunks().0.iter().map(|x| f32::from_le_bytes(*x).into()).collect();
    let size = 3 * animation.rig.vertices();
    let positions: Vec<&[f32]> = animation.positions.chunks(size).collect();
    assert_eq!(found.len(), animation.positions.len(), "{export}: velocities");
    for (frame, around) in positions.windows(3).enumerate() {
        for i in 0..size {
            let expected = (f64::from(around[2][i]) - f64::from(around[0][i])) * animation.frames.rate / 2.0;
            let error = (found[(frame + 1) * size + i] - expected).abs();
            let what = format!("{export}: velocity {i} of frame {}", frame + 1);
            assert!(error <= 1e-6 * expected.abs(), "{what} is off by {error} from {expected}");
        }
    }
}

fn bytes(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// The bytes of a motion as a USD matrix, which multiplies row vectors: the translation is the last row.
fn usd_matrix(motion: &RigidMotion) -> Vec<u8> {
    let columns = motion.matrix();
    (0..4).flat_map(|row| columns.map(|column| column[row])).flat_map(f64::to_le_bytes).collect()
}

/// The smallest and the largest coordinates of points.
fn extent(points: &[f32]) -> [f32; 6] {
    let along = |axis: usize| points.iter().skip(axis).step_by(3).copied();
    let least = [0, 1, 2].map(|axis| along(axis).fold(f32::INFINITY, f32::min));
    let most = [0, 1, 2].map(|axis| along(axis).fold(f32::NEG_INFINITY, f32::max));
    [least[0], least[1], least[2], most[0], most[1], most[2]]
}
