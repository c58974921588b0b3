//! Binary USD, in version 0.8.0 of the crate format. USD itself writes this version by default, and all
//! programs in use read it.
//!
//! A file has a header, the values, six tables and the places of the tables. Values go to the file as they
//! come. For each value, 8 bytes stay in memory. Another 32 bytes identify it, because an equal value is not
//! written a second time.
mod background_writer;
mod compress;
mod tables;
mod value_rep;
mod values;

use super::sample::Sample;
use crate::layer::{Attribute, Fields, Layer, Prim, Property, Relationship, Specifier};
use compress::{compress, compress_integers};
use std::collections::HashMap;
use std::io::{self, Seek, SeekFrom, Write};
use tables::Paths;
use value_rep::{Type, ValueRep};
use values::Values;

const HEADER_SIZE: usize = 88;

/// The numbers of the format for the kinds of objects.
#[derive(Clone, Copy)]
enum SpecKind {
    Attribute = 1,
    Prim = 6,
    Root = 7,
    Relationship = 8,
}

/// A prim or property: its path, and its fields by the number of their name.
struct Spec {
    kind: SpecKind,
    path: u32,
    fields: Vec<(u32, ValueRep)>,
}

/// The samples of one attribute so far.
struct Sampled {
    number: usize,
    /// Which of the specs.
    spec: usize,
    times: Vec<f64>,
    values: Vec<ValueRep>,
}

/// A crate file being written.
pub(crate) struct CrateWriter<W> {
    values: Values<W>,
    specs: Vec<Spec>,
    sampled: Vec<Sampled>,
}

impl<W: Write + Seek + Send + 'static> CrateWriter<W> {
    /// Writes everything of `layer` but samples. `out` stands at its beginning.
    pub(crate) fn create(mut out: W, layer: &Layer) -> io::Result<Self> {
        // The header says where the tables are, and comes last.
        out.write_all(&[0; HEADER_SIZE])?;
        let values = Values::new(out, HEADER_SIZE as u64)?;
        let mut writer = Self { values, specs: Vec::new(), sampled: Vec::new() };
        let mut fields = writer.fields(&layer.metadata)?;
        writer.names(&mut fields, "primChildren", layer.prims.iter().map(|prim| prim.name.as_str()))?;
        writer.specs.push(Spec { kind: SpecKind::Root, path: Paths::ROOT, fields });
        for prim in &layer.prims {
            writer.prim(Paths::ROOT, prim)?;
        }
        Ok(writer)
    }

    /// Bytes written so far.
    pub(super) fn position(&self) -> u64 {
        self.values.position
    }

    /// Adds a sample to the attribute that has the number; its times ascend.
    pub(super) fn sample(&mut self, number: usize, time: f64, sample: Sample<'_>) -> io::Result<()> {
        let Some(sampled) = self.sampled.iter_mut().find(|sampled| sampled.number == number) else {
            return Err(io::Error::other(format!("no attribute of the layer has the samples {number}")));
        };
        sampled.times.push(time);
        sampled.values.push(self.values.sample(sample)?);
        Ok(())
    }

    /// Writes the tables, and returns the output and its size in bytes.
    pub(crate) fn finish(mut self) -> io::Result<(W, u64)> {
        for sampled in std::mem::take(&mut self.sampled) {
            let rep = self.values.time_samples(&sampled.times, &sampled.values)?;
            let field = self.field("timeSamples", rep);
            self.specs[sampled.spec].fields.push(field);
        }
        let (fields, sets, set_of_spec) = self.field_tables();
        let mut places = Vec::new();
        for (name, bytes) in [
            ("TOKENS", self.tokens()),
            ("STRINGS", self.strings()),
            ("FIELDS", fields_section(&fields)),
            ("FIELDSETS", counted(sets.len(), [sets])),
            ("PATHS", self.paths()),
            ("SPECS", self.specs(set_of_spec)),
        ] {
            places.push((name, self.values.position, bytes.len()));
            self.values.write(&bytes)?;
        }
        let contents = self.values.position;
        self.values.write(&table_of_contents(&places))?;
        let size = self.values.position;
        let mut out = self.values.out.finish()?;
        out.seek(SeekFrom::Start(0))?;
        out.write_all(b"PXR-USDC")?;
        out.write_all(&[0, 8, 0, 0, 0, 0, 0, 0])?;
        out.write_all(&contents.to_le_bytes())?;
        out.seek(SeekFrom::Start(size))?;
        Ok((out, size))
    }

    fn prim(&mut self, parent: u32, prim: &Prim) -> io::Result<()> {
        let name = self.values.words.token(&prim.name);
        let path = self.values.paths.prim(parent, name);
        let specifier = match prim.specifier {
            Specifier::Def => 0,
            Specifier::Over => 1,
        };
        let mut fields = vec![self.field("specifier", ValueRep::inlined(Type::Specifier, specifier))];
        if !prim.type_name.is_empty() {
            let rep = self.values.token(&prim.type_name);
            fields.push(self.field("typeName", rep));
        }
        fields.extend(self.fields(&prim.metadata)?);
        self.names(&mut fields, "properties", prim.properties.iter().map(Property::name))?;
        self.names(&mut fields, "primChildren", prim.children.iter().map(|child| child.name.as_str()))?;
        self.specs.push(Spec { kind: SpecKind::Prim, path, fields });
        for property in &prim.properties {
            let name = self.values.words.token(property.name());
            let path = self.values.paths.property(path, name);
            let spec = match property {
                Property::Attribute(attribute) => self.attribute(path, attribute)?,
                Property::Relationship(relationship) => self.relationship(path, relationship)?,
            };
            self.specs.push(spec);
        }
        prim.children.iter().try_for_each(|child| self.prim(path, child))
    }

    fn attribute(&mut self, path: u32, attribute: &Attribute) -> io::Result<Spec> {
        let rep = self.values.token(&attribute.type_name);
        let mut fields = vec![self.field("typeName", rep)];
        if attribute.uniform {
            fields.push(self.uniform());
        }
        fields.extend(self.fields(&attribute.metadata)?);
        if let Some(value) = &attribute.default {
            let rep = self.values.value(value)?;
            fields.push(self.field("default", rep));
        }
        if !attribute.connections.is_empty() {
            let rep = self.values.targets(&attribute.connections)?;
            fields.push(self.field("connectionPaths", rep));
        }
        if let Some(number) = attribute.samples {
            let spec = self.specs.len();
            self.sampled.push(Sampled { number, spec, times: Vec::new(), values: Vec::new() });
        }
        Ok(Spec { kind: SpecKind::Attribute, path, fields })
    }

    fn relationship(&mut self, path: u32, relationship: &Relationship) -> io::Result<Spec> {
        let targets = self.values.targets(&relationship.targets)?;
        let fields = vec![self.uniform(), self.field("targetPaths", targets)];
        Ok(Spec { kind: SpecKind::Relationship, path, fields })
    }

    fn uniform(&mut self) -> (u32, ValueRep) {
        self.field("variability", ValueRep::inlined(Type::Variability, 1))
    }

    fn field(&mut self, name: &str, value: ValueRep) -> (u32, ValueRep) {
        (self.values.words.token(name), value)
    }

    fn fields(&mut self, fields: &Fields) -> io::Result<Vec<(u32, ValueRep)>> {
        fields
            .iter()
            .map(|(name, value)| {
                let rep = self.values.value(value)?;
                Ok(self.field(name, rep))
            })
            .collect()
    }

    /// Adds a list of names, if there are any.
    fn names<'a>(
        &mut self,
        fields: &mut Vec<(u32, ValueRep)>,
        field: &str,
        names: impl ExactSizeIterator<Item = &'a str>,
    ) -> io::Result<()> {
        if names.len() > 0 {
            let rep = self.values.names(names)?;
            fields.push(self.field(field, rep));
        }
        Ok(())
    }

    /// All different fields; the specs' sets of them, each ended by -1; and where each spec's set begins.
    fn field_tables(&self) -> (Vec<(u32, ValueRep)>, Vec<i32>, Vec<i32>) {
        let (mut fields, mut sets) = (Vec::new(), Vec::new());
        let (mut number_of_field, mut place_of_set) = (HashMap::new(), HashMap::new());
        let set_of_spec = self.specs.iter().map(|spec| {
            let set: Vec<i32> = spec
                .fields
                .iter()
                .map(|&field| {
                    *number_of_field.entry(field).or_insert_with(|| {
                        fields.push(field);
                        fields.len() as i32 - 1
                    })
                })
                .collect();
            *place_of_set.entry(set).or_insert_with_key(|set| {
                let place = sets.len() as i32;
                sets.extend(set);
                sets.push(-1);
                place
            })
        });
        let set_of_spec = set_of_spec.collect();
        (fields, sets, set_of_spec)
    }

    /// Their number, their size, and the tokens, each ended by a zero and all compressed.
    fn tokens(&self) -> Vec<u8> {
        let tokens = &self.values.words.tokens;
        let text: Vec<u8> = tokens.iter().flat_map(|token| token.bytes().chain([0])).collect();
        let packed = compress(&text);
        let mut bytes = Vec::new();
        for number in [tokens.len(), text.len(), packed.len()] {
            bytes.extend((number as u64).to_le_bytes());
        }
        bytes.extend(packed);
        bytes
    }

    fn strings(&self) -> Vec<u8> {
        let strings = &self.values.words.strings;
        let mut bytes = (strings.len() as u64).to_le_bytes().to_vec();
        bytes.extend(strings.iter().flat_map(|token| token.to_le_bytes()));
        bytes
    }

    fn paths(&self) -> Vec<u8> {
        let tree = self.values.paths.tree();
        let mut bytes = (self.values.paths.len() as u64).to_le_bytes().to_vec();
        bytes.extend(counted(tree.paths.len(), [tree.paths, tree.elements, tree.jumps]));
        bytes
    }

    fn specs(&self, set_of_spec: Vec<i32>) -> Vec<u8> {
        let paths = self.specs.iter().map(|spec| spec.path as i32).collect();
        let kinds = self.specs.iter().map(|spec| spec.kind as i32).collect();
        counted(self.specs.len(), [paths, set_of_spec, kinds])
    }
}

/// The fields' names, and their representations, both compressed.
fn fields_section(fields: &[(u32, ValueRep)]) -> Vec<u8> {
    let mut bytes = counted(fields.len(), [fields.iter().map(|&(name, _)| name as i32).collect()]);
    let reps: Vec<u8> = fields.iter().flat_map(|(_, rep)| rep.0.to_le_bytes()).collect();
    let packed = compress(&reps);
    bytes.extend((packed.len() as u64).to_le_bytes());
    bytes.extend(packed);
    bytes
}

/// A count, and columns of that many integers, each compressed.
fn counted<const N: usize>(count: usize, columns: [Vec<i32>; N]) -> Vec<u8> {
    let mut bytes = (count as u64).to_le_bytes().to_vec();
    bytes.extend(columns.into_iter().flat_map(|column| compress_integers(column.into_iter())));
    bytes
}

/// Each section's name in 16 bytes, where it begins, and its size.
fn table_of_contents(places: &[(&str, u64, usize)]) -> Vec<u8> {
    let mut bytes = (places.len() as u64).to_le_bytes().to_vec();
    for (name, start, size) in places {
        let mut padded = [0; 16];
        padded[..name.len()].copy_from_slice(name.as_bytes());
        bytes.extend(padded);
        bytes.extend(start.to_le_bytes());
        bytes.extend((*size as u64).to_le_bytes());
    }
    bytes
}
