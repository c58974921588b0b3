//! USD text. An attribute's samples stand together in the file while frames come one by one: the samples of
//! `points` go straight to the file, those of `normals` and `extent` to spools which are appended at the end.
use super::text::shortest;
use super::{Exporter, Scene};
use rhytid_core::{Result, UpAxis, WriteBeside};
use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

/// A `.usda` file being written.
pub(super) struct Usda {
    file: WriteBeside,
    normals: BufWriter<File>,
    extents: BufWriter<File>,
    first_time_code: f64,
    done: usize,
}

impl Usda {
    pub(super) fn create(path: &Path, scene: &Scene<'_>) -> Result<Self> {
        let mut file = WriteBeside::create(path)?;
        write_head(&mut file, scene).map_err(file.error())?;
        let normals = BufWriter::with_capacity(1 << 20, file.spool()?);
        let extents = BufWriter::new(file.spool()?);
        let mut usda = Self { file, normals, extents, first_time_code: scene.first_time_code, done: 0 };
        usda.begin(scene).map_err(usda.file.error())?;
        Ok(usda)
    }

    /// Opens the three animated attributes, with the rest pose as their default values.
    fn begin(&mut self, scene: &Scene<'_>) -> io::Result<()> {
        let rest = scene.rest.as_flattened();
        write!(self.file, "        point3f[] points = ")?;
        write_vectors::<3>(&mut self.file, rest)?;
        writeln!(self.file, "\n        point3f[] points.timeSamples = {{")?;

        write!(self.normals, "        normal3f[] normals = ")?;
        write_vectors::<3>(&mut self.normals, scene.rest_normals.as_flattened())?;
        writeln!(self.normals, " (\n            interpolation = \"vertex\"\n        )")?;
        writeln!(self.normals, "        normal3f[] normals.timeSamples = {{")?;

        write!(self.extents, "        float3[] extent = ")?;
        write_vectors::<3>(&mut self.extents, &extent(rest))?;
        writeln!(self.extents, "\n        float3[] extent.timeSamples = {{")
    }

    fn write_frame(&mut self, positions: &[f32], normals: &[f32]) -> io::Result<()> {
        let time = number(self.first_time_code + self.done as f64);
        write_sample(&mut self.file, &time, positions)?;
        write_sample(&mut self.normals, &time, normals)?;
        write_sample(&mut self.extents, &time, &extent(positions))
    }

    fn write_tail(&mut self) -> io::Result<()> {
        for spool in [&mut self.normals, &mut self.extents] {
            writeln!(self.file, "        }}")?;
            spool.rewind()?;
            io::copy(spool.get_mut(), &mut self.file)?;
        }
        writeln!(self.file, "        }}\n    }}\n}}")
    }
}

impl Exporter for Usda {
    fn frame(&mut self, positions: &[f32], normals: &[f32]) -> Result<()> {
        self.write_frame(positions, normals).map_err(self.file.error())?;
        self.done += 1;
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<()> {
        self.write_tail().map_err(self.file.error())?;
        self.file.finish()
    }
}

/// The layer's metadata, the Xform, and everything of the Mesh that does not move.
fn write_head(out: &mut impl Write, scene: &Scene<'_>) -> io::Result<()> {
    let name = identifier(scene.name);
    let rate = number(scene.rate);
    let up_axis = match scene.up_axis {
        UpAxis::Y => "Y",
        UpAxis::Z => "Z",
    };
    write!(
        out,
        "#usda 1.0
(
    defaultPrim = \"{name}\"
    endTimeCode = {end}
    framesPerSecond = {rate}
    metersPerUnit = {metres}
    startTimeCode = {start}
    timeCodesPerSecond = {rate}
    upAxis = \"{up_axis}\"
)

def Xform \"{name}\" (
    kind = \"component\"
)
{{
    def Mesh \"{name}_mesh\"
    {{
        uniform bool doubleSided = 1
        uniform token subdivisionScheme = \"none\"
        int[] faceVertexCounts = ",
        start = number(scene.first_time_code),
        end = number(scene.first_time_code + (scene.frames - 1) as f64),
        metres = number(scene.metres_per_unit),
    )?;
    write_integers(out, &scene.faces.counts)?;
    write!(out, "\n        int[] faceVertexIndices = ")?;
    write_integers(out, &scene.faces.indices)?;
    writeln!(out)?;
    if let Some(uvs) = scene.uvs {
        let interpolation = if uvs.corners.is_some() { "faceVarying" } else { "vertex" };
        write!(out, "        texCoord2f[] primvars:st = ")?;
        write_vectors::<2>(out, uvs.values.as_flattened())?;
        writeln!(out, " (\n            interpolation = \"{interpolation}\"\n        )")?;
        if let Some(corners) = &uvs.corners {
            write!(out, "        int[] primvars:st:indices = ")?;
            write_integers(out, corners)?;
            writeln!(out)?;
        }
    }
    Ok(())
}

fn write_sample(out: &mut impl Write, time: &str, numbers: &[f32]) -> io::Result<()> {
    write!(out, "            {time}: ")?;
    write_vectors::<3>(out, numbers)?;
    out.write_all(b",\n")
}

/// `[(x, y, z), …]`, a few vectors a line.
fn write_vectors<const N: usize>(out: &mut impl Write, numbers: &[f32]) -> io::Result<()> {
    let mut digits = ryu::Buffer::new();
    let mut text = Vec::with_capacity(512);
    out.write_all(b"[")?;
    for (i, line) in numbers.chunks(8 * N).enumerate() {
        text.clear();
        text.extend_from_slice(if i == 0 { b"" } else { b",\n" });
        for (j, vector) in line.chunks_exact(N).enumerate() {
            text.extend_from_slice(if j == 0 { b"(" } else { b", (" });
            for (k, &x) in vector.iter().enumerate() {
                text.extend_from_slice(if k == 0 { b"" } else { b", " });
                text.extend_from_slice(shortest(&mut digits, x).as_bytes());
            }
            text.push(b')');
        }
        out.write_all(&text)?;
    }
    out.write_all(b"]")
}

/// `[1, 2, …]`, a few numbers a line.
fn write_integers(out: &mut impl Write, numbers: &[u32]) -> io::Result<()> {
    out.write_all(b"[")?;
    for (i, x) in numbers.iter().enumerate() {
        let separator = match i {
            0 => "",
            _ if i % 24 == 0 => ",\n",
            _ => ", ",
        };
        write!(out, "{separator}{x}")?;
    }
    out.write_all(b"]")
}

/// The shortest text that reads back as the same `f64`; whole numbers without a point.
fn number(x: f64) -> String {
    let mut digits = ryu::Buffer::new();
    let text = digits.format_finite(x);
    text.strip_suffix(".0").unwrap_or(text).to_owned()
}

/// Smallest and largest coordinates of V×3 `positions`.
fn extent(positions: &[f32]) -> [f32; 6] {
    let mut extent = [f32::MAX, f32::MAX, f32::MAX, f32::MIN, f32::MIN, f32::MIN];
    for position in positions.chunks_exact(3) {
        for (axis, &x) in position.iter().enumerate() {
            extent[axis] = extent[axis].min(x);
            extent[axis + 3] = extent[axis + 3].max(x);
        }
    }
    extent
}

/// `name` as a prim may be called in every version of USD: ASCII letters, digits and underscores, not
/// beginning with a digit.
fn identifier(name: &str) -> String {
    let mut identifier: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if identifier.chars().next().is_none_or(|c| c.is_ascii_digit()) {
        identifier.insert(0, '_');
    }
    identifier
}
