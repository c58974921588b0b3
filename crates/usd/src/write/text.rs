//! USD text. In the file, the samples of an attribute stand together, but here the samples of all attributes
//! come by turns. So the text up to the first samples goes to the file. Each further part begins behind the
//! samples of one attribute and ends with those of the next, and goes to a spool. The spools are appended at
//! the end.
use super::numbers::double;
use super::sample::Sample;
use super::text_value::{
    write_float2s, write_float3s, write_floats, write_matrix, write_path_list, write_value,
};
use crate::layer::{Attribute, Fields, Layer, Prim, Property, Relationship, Specifier};
use rhytid_core::{AtomicFile, Error, Result};
use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};

/// A `.usda` file being written.
pub(super) struct TextWriter {
    file: AtomicFile,
    /// The parts behind the first.
    spools: Vec<BufWriter<File>>,
    /// For each part but the last, the number of the attribute whose samples it ends with.
    sampled: Vec<usize>,
}

impl TextWriter {
    /// Writes everything of `layer` but samples.
    pub(super) fn create(file: AtomicFile, layer: &Layer) -> Result<Self> {
        let mut writer = Self { file, spools: Vec::new(), sampled: Vec::new() };
        writer.layer(layer)?;
        Ok(writer)
    }

    /// Adds a sample to the attribute that has the number; its times ascend.
    pub(super) fn sample(&mut self, number: usize, time: f64, sample: Sample<'_>) -> Result<()> {
        let Some(part) = self.sampled.iter().position(|&sampled| sampled == number) else {
            return Err(Error::Internal(format!("no attribute of the layer has the samples {number}")));
        };
        let name_path = self.file.error();
        write_sample(self.part(part), time, sample).map_err(name_path)
    }

    /// Appends the spools, and returns the size in bytes.
    pub(super) fn finish(mut self) -> Result<u64> {
        let name_path = self.file.error();
        let size = self.append_spools().map_err(name_path)?;
        self.file.finish()?;
        Ok(size)
    }

    fn append_spools(&mut self) -> io::Result<u64> {
        for spool in &mut self.spools {
            spool.rewind()?;
            io::copy(spool.get_mut(), &mut self.file)?;
        }
        self.file.stream_position()
    }

    fn part(&mut self, part: usize) -> &mut dyn Write {
        match part {
            0 => &mut self.file,
            _ => &mut self.spools[part - 1],
        }
    }

    /// The place for the text that follows.
    fn last(&mut self) -> &mut dyn Write {
        self.part(self.spools.len())
    }

    fn layer(&mut self, layer: &Layer) -> Result<()> {
        let name_path = self.file.error();
        write!(self.last(), "#usda 1.0")
            .and_then(|()| write_metadata(self.last(), "", &layer.metadata))
            .and_then(|()| writeln!(self.last()))
            .map_err(name_path)?;
        for prim in &layer.prims {
            self.prim("", prim)?;
        }
        Ok(())
    }

    fn prim(&mut self, indent: &str, prim: &Prim) -> Result<()> {
        let name_path = self.file.error();
        self.begin_prim(indent, prim).map_err(name_path)?;
        let inner = format!("{indent}    ");
        for property in &prim.properties {
            match property {
                Property::Attribute(attribute) => self.attribute(&inner, attribute)?,
                Property::Relationship(relationship) => {
                    let name_path = self.file.error();
                    write_relationship(self.last(), &inner, relationship).map_err(name_path)?;
                }
            }
        }
        for child in &prim.children {
            self.prim(&inner, child)?;
        }
        let name_path = self.file.error();
        writeln!(self.last(), "{indent}}}").map_err(name_path)
    }

    fn begin_prim(&mut self, indent: &str, prim: &Prim) -> io::Result<()> {
        let out = self.last();
        let specifier = match prim.specifier {
            Specifier::Def => "def",
            Specifier::Over => "over",
        };
        let separator = if prim.type_name.is_empty() { "" } else { " " };
        write!(out, "\n{indent}{specifier}{separator}{} \"{}\"", prim.type_name, prim.name)?;
        write_metadata(out, indent, &prim.metadata)?;
        writeln!(out, "\n{indent}{{")
    }

    fn attribute(&mut self, indent: &str, attribute: &Attribute) -> Result<()> {
        let name_path = self.file.error();
        write_attribute(self.last(), indent, attribute).map_err(name_path)?;
        let Some(number) = attribute.samples else { return Ok(()) };
        self.sampled.push(number);
        self.spools.push(BufWriter::with_capacity(1 << 20, self.file.spool()?));
        let name_path = self.file.error();
        writeln!(self.last(), "{indent}}}").map_err(name_path)
    }
}

/// All of the attribute up to its samples.
fn write_attribute(out: &mut dyn Write, indent: &str, attribute: &Attribute) -> io::Result<()> {
    let uniform = if attribute.uniform { "uniform " } else { "" };
    let head = format!("{indent}{uniform}{} {}", attribute.type_name, attribute.name);
    write!(out, "{head}")?;
    if let Some(value) = &attribute.default {
        write!(out, " = ")?;
        write_value(out, value, indent)?;
    }
    write_metadata(out, indent, &attribute.metadata)?;
    writeln!(out)?;
    if !attribute.connections.is_empty() {
        write!(out, "{head}.connect = ")?;
        write_path_list(out, &attribute.connections)?;
        writeln!(out)?;
    }
    if attribute.samples.is_some() {
        writeln!(out, "{head}.timeSamples = {{")?;
    }
    Ok(())
}

fn write_sample(out: &mut dyn Write, time: f64, sample: Sample<'_>) -> io::Result<()> {
    write!(out, "            {}: ", double(time))?;
    match sample {
        Sample::Float3s(vectors) => write_float3s(out, vectors)?,
        Sample::Float2s(vectors) => write_float2s(out, vectors)?,
        Sample::Floats(numbers) => write_floats(out, numbers)?,
        Sample::Matrix4d(rows) => write_matrix(out, rows)?,
    }
    out.write_all(b",\n")
}

fn write_relationship(out: &mut dyn Write, indent: &str, relationship: &Relationship) -> io::Result<()> {
    write!(out, "{indent}rel {} = ", relationship.name)?;
    write_path_list(out, &relationship.targets)?;
    writeln!(out)
}

/// ` (…)`, of an object whose line has the indentation `indent`; nothing if there is none.
pub(super) fn write_metadata(out: &mut dyn Write, indent: &str, fields: &Fields) -> io::Result<()> {
    if fields.is_empty() {
        return Ok(());
    }
    // The layer's own stands on a line of its own.
    out.write_all(if indent.is_empty() { b"\n(\n" } else { b" (\n" })?;
    let inner = format!("{indent}    ");
    for (name, value) in fields {
        let prepend = if value.type_name().is_none() { "prepend " } else { "" };
        write!(out, "{inner}{prepend}{name} = ")?;
        write_value(out, value, &inner)?;
        writeln!(out)?;
    }
    write!(out, "{indent})")
}
