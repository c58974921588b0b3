//! The faces and takes that the pages of these tests open.
use flate2::Compression;
use flate2::write::GzEncoder;
use rhytid_core::rig_file::{self, Packing, Step};
use rhytid_core::{
    Face, Material, Materials, Method, NoProgress, Rig, RigidMotion, StatedLook, Take, Texture, Uvs,
};
use rhytid_formats::take;
use std::io::Write;
use std::path::Path;

/// About how many vertices each face has.
const VERTICES: usize = 1_500;

/// What lies beside the pages.
pub(super) struct Files {
    /// `learned.safetensors`, `learned.safetensors.gz`: the demo's face as it is.
    pub(super) learned: Rig,
    /// `packed.safetensors`, as it is read.
    pub(super) packed: Rig,
    /// `chapter.safetensors`: by the chapter's method, so with the kernels of the tangent frames.
    pub(super) chapter: Rig,
    /// `turning.safetensors`: its handles turn.
    pub(super) turning: Rig,
    /// `seams.safetensors`: with a seam of the texture, and with materials.
    pub(super) seams: Rig,
    /// `take.csv`: the demo's performance.
    pub(super) take: Take,
    /// `head.csv`: the same with the head's motion.
    pub(super) head: Take,
}

impl Files {
    pub(super) fn write(folder: &Path) -> Self {
        let face = rhytid_demo::face(VERTICES);
        let learned = solved(&face);
        let with = |change: &dyn Fn(&mut Face)| {
            let mut face = face.clone();
            change(&mut face);
            solved(&face)
        };
        let chapter = with(&|face| face.settings.method = Method::Chapter);
        let turning = with(&|face| face.settings.rotations = true);
        let seams = with_seams(&learned);
        let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
        for (name, rig) in
            [("learned", &learned), ("chapter", &chapter), ("turning", &turning), ("seams", &seams)]
        {
            write(&format!("{name}.safetensors"), &rig_file::encode(rig).unwrap());
        }
        let plain = rig_file::encode(&learned).unwrap();
        let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
        packed.write_all(&plain).unwrap();
        let gzip = packed.finish().unwrap();
        write("learned.safetensors.gz", &gzip);
        write("cut.gz", &gzip[..gzip.len() / 2]);
        write("cut.safetensors", &plain[..plain.len() / 2]);
        let mut spoiled = plain.clone();
        let last = spoiled.len() - 40;
        spoiled[last..].fill(0xff);
        write("spoiled.safetensors", &spoiled);
        let small = solved(&rhytid_test_support::sheet::face());
        write("small.safetensors", &rig_file::encode(&small).unwrap());
        write("small.csv", waves(&small).as_bytes());
        let packed = packed_file(&learned);
        write("packed.safetensors", &packed);
        let packed = rig_file::decode(&packed, "packed").unwrap();
        let performance = rhytid_demo::performance(&face).slice(0..60);
        let turns = |frame: usize| {
            let half = 0.1 * (frame as f64 / 10.0).sin();
            RigidMotion { rotation: [0.0, half.sin(), 0.0, half.cos()], translation: [0.5, 0.0, 0.1] }
        };
        let head = Take { head: Some((0..60).map(turns).collect()), ..performance.clone() };
        for (name, take) in [("take.csv", &performance), ("head.csv", &head)] {
            let _ = std::fs::remove_file(folder.join(name));
            take::write(&folder.join(name), take).unwrap();
        }
        let text = std::fs::read_to_string(folder.join("take.csv")).unwrap();
        let (header, rows) = text.split_once('\n').unwrap();
        write("gap.csv", with_gap(header, rows).as_bytes());
        write("cut.csv", &text.as_bytes()[..text.len() / 2]);
        write("no-time.csv", format!("{}\n{rows}", header.replace("time", "clock")).as_bytes());
        let mut far = performance.clone();
        far.positions.iter_mut().flatten().for_each(|x| *x *= 10.0);
        let _ = std::fs::remove_file(folder.join("far.csv"));
        take::write(&folder.join("far.csv"), &far).unwrap();
        Self { learned, packed, chapter, turning, seams, take: performance, head }
    }

    /// H×3 handle positions of a frame of the take.
    pub(super) fn frame(&self, frame: usize) -> Vec<f32> {
        let labels = &self.learned.handles().labels;
        let all = self.take.handle_positions(labels).unwrap();
        all[frame * labels.len() * 3..][..labels.len() * 3].to_vec()
    }
}

/// A take of two seconds, in which the handles of a rig go up and down.
fn waves(rig: &Rig) -> String {
    let handles = rig.handles();
    let columns = handles.labels.iter().map(|label| format!(",{label}_x,{label}_y,{label}_z"));
    let mut text = format!("time{}\n", columns.collect::<String>());
    for frame in 0..60 {
        text += &format!("{}", f64::from(frame) / 30.0);
        for (h, [x, y, z]) in handles.rest.iter().enumerate() {
            let wave = (0.2 * f64::from(frame) + h as f64).sin();
            text += &format!(",{x},{y},{}", f64::from(*z) + 0.5 * wave);
        }
        text.push('\n');
    }
    text
}

/// The frame of `gap.csv` without the first marker.
pub(super) const GAP: usize = 40;

/// The rows without the first marker in one frame.
fn with_gap(header: &str, rows: &str) -> String {
    let mut rows: Vec<String> = rows.lines().map(str::to_owned).collect();
    let mut cells: Vec<&str> = rows[GAP].split(',').collect();
    cells[1..4].fill("");
    rows[GAP] = cells.join(",");
    format!("{header}\n{}\n", rows.join("\n"))
}

fn solved(face: &Face) -> Rig {
    rhytid_solve::solve(face, &NoProgress).unwrap().rounded().unwrap()
}

fn packed_file(rig: &Rig) -> Vec<u8> {
    let packing = Packing {
        worst: 0.0,
        rms: 0.0,
        normals: 0.0,
        finished: 0.0,
        finished_beyond: 0,
        poses: 1,
        rig: rig_file::hash_of(rig).unwrap(),
    };
    let steps = [Step { array: "basis", size: 1e-3 }];
    rig_file::pack(rig, &steps, &packing).unwrap()
}

/// The face with a seam from its chin to its brow. Its right half has a checked material, and its left half
/// none.
fn with_seams(rig: &Rig) -> Rig {
    let mut parts = rig.clone().into_parts();
    let surface = &mut parts.surface;
    let uvs = surface.uvs.take().unwrap().values;
    let vertices = surface.rest.len() as u32;
    let is_left: Vec<bool> =
        surface.faces.iter().map(|face| face.iter().all(|&v| surface.rest[v as usize][0] >= -1e-4)).collect();
    let mut corners = Vec::new();
    for (face, &is_left) in surface.faces.iter().zip(&is_left) {
        corners.extend(face.iter().map(|v| if is_left { v + vertices } else { *v }));
    }
    let shifted = uvs.iter().map(|uv| [uv[0] + 0.5, uv[1]]);
    let values = uvs.iter().copied().chain(shifted).collect();
    surface.uvs = Some(Uvs { values, corners: Some(corners) });
    let stated = StatedLook { texture: Some(0), ..StatedLook::default() };
    surface.materials = Some(Materials {
        list: vec![Material { stated, ..Material::new("checks") }],
        textures: vec![Texture { name: "checks.png".into(), path: None, bytes: checks().into() }],
        of_face: is_left.iter().map(|&is_left| if is_left { Materials::NONE } else { 0 }).collect(),
    });
    Rig::new(parts).unwrap()
}

/// A picture of 32 × 32 squares, brown and pale. Its lowest row is blue.
fn checks() -> Vec<u8> {
    const SIDE: usize = 128;
    let mut pixels = Vec::new();
    for y in 0..SIDE {
        for x in 0..SIDE {
            pixels.extend(match (y > SIDE - 5, (x / 4 + y / 4) % 2 == 0) {
                (true, _) => [20_u8, 40, 220],
                (_, true) => [190, 110, 80],
                (_, false) => [240, 205, 180],
            });
        }
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, SIDE as u32, SIDE as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    file
}
