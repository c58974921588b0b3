//! The values of a crate file, written as they come and each once.
use super::background_writer::BackgroundWriter;
use super::compress::compress_integers;
use super::tables::{Paths, Words};
use super::value_rep::{Type, ValueRep};
use crate::layer::{Fields, Reference, Value};
use crate::write::sample::Sample;
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{self, Write};

/// Arrays of fewer numbers are not compressed.
const COMPRESSED_FROM: usize = 16;

/// Lists that put something before what weaker layers say, and lists that stand alone.
const PREPENDED: u8 = 1 << 5;
const EXPLICIT: u8 = 1 << 0 | 1 << 1;

/// The first part of a crate file.
pub(super) struct Values<W> {
    pub(super) out: BackgroundWriter<W>,
    /// Bytes written.
    pub(super) position: u64,
    pub(super) words: Words,
    pub(super) paths: Paths,
    /// The values that are in the file already, by the hash of their representation and bytes.
    seen: HashMap<[u8; 32], ValueRep>,
}

impl<W: Write + Send + 'static> Values<W> {
    /// Values go to `out`, `position` bytes into the file.
    pub(super) fn new(out: W, position: u64) -> io::Result<Self> {
        let mut words = Words::default();
        // Token 0 is that of the root path, since no property can have it.
        words.token("");
        let out = BackgroundWriter::new(out)?;
        Ok(Self { out, position, words, paths: Paths::new(), seen: HashMap::new() })
    }

    /// The representation of a value. The value is written unless it is in the file already or is its own
    /// representation.
    pub(super) fn value(&mut self, value: &Value) -> io::Result<ValueRep> {
        match value {
            Value::Bool(x) => Ok(ValueRep::inlined(Type::Bool, u32::from(*x))),
            Value::Int(x) => Ok(ValueRep::inlined(Type::Int, *x as u32)),
            Value::Float(x) => Ok(ValueRep::inlined(Type::Float, x.to_bits())),
            Value::Double(x) => match ValueRep::inlined_double(*x) {
                Some(rep) => Ok(rep),
                None => self.store(ValueRep::single(Type::Double), &[&x.to_le_bytes()]),
            },
            Value::String(text) => Ok(ValueRep::inlined(Type::String, self.words.string(text))),
            Value::Token(text) => Ok(self.token(text)),
            Value::Asset(text) => Ok(ValueRep::inlined(Type::Asset, self.words.token(text))),
            Value::Float3(vector) => self.store(ValueRep::single(Type::Vec3f), &[&float_bytes(vector)]),
            Value::Float4(vector) => self.store(ValueRep::single(Type::Vec4f), &[&float_bytes(vector)]),
            Value::Double3(vector) => self.store(ValueRep::single(Type::Vec3d), &[&double_bytes(vector)]),
            // The format has the real part last.
            Value::Quatd([real, i, j, k]) => {
                self.store(ValueRep::single(Type::Quatd), &[&double_bytes(&[*i, *j, *k, *real])])
            }
            Value::Matrix4d(rows) => self.matrix(rows),
            Value::Tokens(tokens) => {
                let numbers: Vec<u32> = tokens.iter().map(|token| self.words.token(token)).collect();
                self.array(ValueRep::array(Type::Token), numbers.len(), &integer_bytes(&numbers))
            }
            Value::Assets(assets) => {
                let numbers: Vec<u32> = assets.iter().map(|asset| self.words.string(asset)).collect();
                self.array(ValueRep::array(Type::Asset), numbers.len(), &integer_bytes(&numbers))
            }
            Value::Ints(numbers) => self.integers(numbers),
            Value::Floats(numbers) => self.floats(numbers),
            Value::Float2s(vectors) => self.sample(Sample::Float2s(vectors)),
            Value::Float3s(vectors) => self.sample(Sample::Float3s(vectors)),
            Value::Float4s(vectors) => {
                let bytes = float_bytes(vectors.as_flattened());
                self.array(ValueRep::array(Type::Vec4f), vectors.len(), &bytes)
            }
            Value::Double2s(vectors) => {
                let bytes = double_bytes(vectors.as_flattened());
                self.array(ValueRep::array(Type::Vec2d), vectors.len(), &bytes)
            }
            Value::Double3s(vectors) => {
                let bytes = double_bytes(vectors.as_flattened());
                self.array(ValueRep::array(Type::Vec3d), vectors.len(), &bytes)
            }
            Value::Matrix4ds(matrices) => {
                let bytes = double_bytes(matrices.as_flattened().as_flattened());
                self.array(ValueRep::array(Type::Matrix4d), matrices.len(), &bytes)
            }
            Value::Dictionary(entries) => self.dictionary(entries),
            Value::PrependedTokens(tokens) => {
                let mut bytes = list_head(PREPENDED, tokens.len());
                for token in tokens {
                    bytes.extend(self.words.token(token).to_le_bytes());
                }
                self.store(ValueRep::single(Type::TokenListOp), &[&bytes])
            }
            Value::PrependedReferences(references) => self.references(references),
        }
    }

    /// The representation of a sample; see [`Values::value`].
    pub(super) fn sample(&mut self, sample: Sample<'_>) -> io::Result<ValueRep> {
        match sample {
            Sample::Float3s(vectors) => {
                let bytes = float_bytes(vectors.as_flattened());
                self.array(ValueRep::array(Type::Vec3f), vectors.len(), &bytes)
            }
            Sample::Float2s(vectors) => {
                let bytes = float_bytes(vectors.as_flattened());
                self.array(ValueRep::array(Type::Vec2f), vectors.len(), &bytes)
            }
            Sample::Floats(numbers) => self.floats(numbers),
            Sample::Matrix4d(rows) => self.matrix(rows),
        }
    }

    /// A token, which always stands for itself.
    pub(super) fn token(&mut self, text: &str) -> ValueRep {
        ValueRep::inlined(Type::Token, self.words.token(text))
    }

    /// A list of names, as prims have of their children and properties.
    pub(super) fn names<'a>(
        &mut self,
        names: impl ExactSizeIterator<Item = &'a str>,
    ) -> io::Result<ValueRep> {
        let mut bytes = (names.len() as u64).to_le_bytes().to_vec();
        for name in names {
            bytes.extend(self.words.token(name).to_le_bytes());
        }
        self.store(ValueRep::single(Type::TokenVector), &[&bytes])
    }

    /// A list of paths that stands alone, as relationships have of their targets.
    pub(super) fn targets(&mut self, targets: &[String]) -> io::Result<ValueRep> {
        let mut bytes = list_head(EXPLICIT, targets.len());
        for target in targets {
            bytes.extend(self.paths.parse(target, &mut self.words).to_le_bytes());
        }
        self.store(ValueRep::single(Type::PathListOp), &[&bytes])
    }

    /// An attribute's samples, given their times and the values' representations.
    pub(super) fn time_samples(&mut self, times: &[f64], values: &[ValueRep]) -> io::Result<ValueRep> {
        let count = (times.len() as u64).to_le_bytes();
        let times = self.store(ValueRep::single(Type::DoubleVector), &[&count, &double_bytes(times)])?;
        let mut bytes = Vec::with_capacity(32 + 8 * values.len());
        bytes.extend(nested(times));
        // As before each nested value: how many bytes on it begins.
        bytes.extend(8_u64.to_le_bytes());
        bytes.extend(count);
        bytes.extend(values.iter().flat_map(|rep| rep.0.to_le_bytes()));
        self.store(ValueRep::single(Type::TimeSamples), &[&bytes])
    }

    fn matrix(&mut self, rows: &[[f64; 4]; 4]) -> io::Result<ValueRep> {
        match ValueRep::inlined_matrix(rows) {
            Some(rep) => Ok(rep),
            None => self.store(ValueRep::single(Type::Matrix4d), &[&double_bytes(rows.as_flattened())]),
        }
    }

    fn integers(&mut self, numbers: &[i32]) -> io::Result<ValueRep> {
        if numbers.len() < COMPRESSED_FROM {
            let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
            return self.array(ValueRep::array(Type::Int), numbers.len(), &bytes);
        }
        let bytes = compress_integers(numbers.iter().copied());
        self.array(ValueRep::compressed_array(Type::Int), numbers.len(), &bytes)
    }

    /// Whole numbers are stored as integers. A few different numbers are stored as a list of them and an
    /// index for each.
    fn floats(&mut self, numbers: &[f32]) -> io::Result<ValueRep> {
        let compressed = ValueRep::compressed_array(Type::Float);
        if numbers.len() >= COMPRESSED_FROM {
            if numbers.iter().all(|&x| (x as i32 as f32).to_bits() == x.to_bits()) {
                let integers = compress_integers(numbers.iter().map(|&x| x as i32));
                return self.array(compressed, numbers.len(), &[b"i", integers.as_slice()].concat());
            }
            let mut number_of = HashMap::new();
            let mut different = Vec::new();
            let indices: Vec<i32> = numbers
                .iter()
                .map(|&x| {
                    *number_of.entry(x.to_bits()).or_insert_with(|| {
                        different.push(x);
                        different.len() as i32 - 1
                    })
                })
                .collect();
            // More would not be worth their list.
            if different.len() < 1024 && different.len() < numbers.len() / 4 {
                let mut bytes = b"t".to_vec();
                bytes.extend((different.len() as u32).to_le_bytes());
                bytes.extend_from_slice(&float_bytes(&different));
                bytes.extend(compress_integers(indices.into_iter()));
                return self.array(compressed, numbers.len(), &bytes);
            }
        }
        self.array(ValueRep::array(Type::Float), numbers.len(), &float_bytes(numbers))
    }

    fn array(&mut self, of: ValueRep, count: usize, bytes: &[u8]) -> io::Result<ValueRep> {
        if count == 0 {
            return Ok(of);
        }
        self.store(of, &[&(count as u64).to_le_bytes(), bytes])
    }

    fn dictionary(&mut self, entries: &Fields) -> io::Result<ValueRep> {
        let mut bytes = (entries.len() as u64).to_le_bytes().to_vec();
        for (key, value) in entries {
            bytes.extend(self.words.string(key).to_le_bytes());
            bytes.extend(nested(self.value(value)?));
        }
        self.store(ValueRep::single(Type::Dictionary), &[&bytes])
    }

    fn references(&mut self, references: &[Reference]) -> io::Result<ValueRep> {
        let mut bytes = list_head(PREPENDED, references.len());
        for reference in references {
            bytes.extend(self.words.string(&reference.asset).to_le_bytes());
            bytes.extend(self.paths.parse(&reference.prim, &mut self.words).to_le_bytes());
            // Time is neither moved nor scaled, and there is no custom data.
            bytes.extend_from_slice(&double_bytes(&[0.0, 1.0]));
            bytes.extend(0_u64.to_le_bytes());
        }
        self.store(ValueRep::single(Type::ReferenceListOp), &[&bytes])
    }

    /// Writes the parts of one value, unless they are in the file already.
    fn store(&mut self, of: ValueRep, parts: &[&[u8]]) -> io::Result<ValueRep> {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&of.0.to_le_bytes());
        for part in parts {
            hasher.update(part);
        }
        let hash = *hasher.finalize().as_bytes();
        if let Some(&rep) = self.seen.get(&hash) {
            return Ok(rep);
        }
        let padding = self.position.next_multiple_of(8) - self.position;
        self.write(&[0; 8][..padding as usize])?;
        let rep = of.at(self.position);
        for part in parts {
            self.write(part)?;
        }
        self.seen.insert(hash, rep);
        Ok(rep)
    }

    pub(super) fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes)?;
        self.position += bytes.len() as u64;
        Ok(())
    }
}

/// A value within another: how many bytes on its representation begins, and that.
fn nested(value: ValueRep) -> Vec<u8> {
    [8_u64.to_le_bytes(), value.0.to_le_bytes()].concat()
}

/// What stands before the items of a list of one kind.
fn list_head(kind: u8, count: usize) -> Vec<u8> {
    [[kind].as_slice(), &(count as u64).to_le_bytes()].concat()
}

fn integer_bytes(numbers: &[u32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Little endian, without a copy where the processor is.
fn float_bytes(numbers: &[f32]) -> Cow<'_, [u8]> {
    if cfg!(target_endian = "little") {
        return Cow::Borrowed(bytemuck::cast_slice(numbers));
    }
    Cow::Owned(numbers.iter().flat_map(|x| x.to_le_bytes()).collect())
}

fn double_bytes(numbers: &[f64]) -> Cow<'_, [u8]> {
    if cfg!(target_endian = "little") {
        return Cow::Borrowed(bytemuck::cast_slice(numbers));
    }
    Cow::Owned(numbers.iter().flat_map(|x| x.to_le_bytes()).collect())
}
