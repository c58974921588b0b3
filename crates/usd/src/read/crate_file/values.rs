//! Values of the types that [`Value`] has.

use super::super::budget::Budget;
use super::super::source::Source;
use super::cursor::Cursor;
use super::structure::Structure;
use super::value_rep::{ValueRep, kind};
use crate::layer::{Fields, Reference, Value};
use half::f16;
use rhytid_core::{Error, Result};
use std::sync::Arc;

/// How deep dictionaries may be within dictionaries.
const MOST_NESTED: usize = 32;
/// Integer arrays shorter than this are never compressed.
const SHORTEST_COMPRESSED: u64 = 16;
/// What a small value is counted as, in bytes.
const SMALL: u64 = 64;

/// A crate file whose sections were read.
pub(super) struct Reader {
    pub(super) source: Source,
    pub(super) structure: Structure,
    pub(super) budget: Budget,
}

/// The time samples of an attribute.
pub(super) struct Track {
    pub(super) times: Arc<[f64]>,
    pub(super) values: Vec<ValueRep>,
}

impl Reader {
    /// The file is not as it should be.
    pub(super) fn damaged(&self, fault: impl std::fmt::Display) -> Error {
        self.source.wrong(format_args!("{fault}; the file is damaged, export it again"))
    }

    /// Counts `bytes` that are going to be allocated.
    pub(super) fn spend(&mut self, bytes: u64) -> Result<()> {
        if self.budget.take(bytes) {
            return Ok(());
        }
        Err(self.damaged("its values are far larger together than a file of its size can hold"))
    }

    pub(super) fn token(&self, index: u32) -> Result<&str> {
        let tokens = &self.structure.tokens;
        let token = tokens.get(index as usize).map(String::as_str);
        token.ok_or_else(|| self.damaged(format_args!("token {index} is not one of its {}", tokens.len())))
    }

    fn string(&self, index: u32) -> Result<&str> {
        let strings = &self.structure.strings;
        let Some(&token) = strings.get(index as usize) else {
            return Err(self.damaged(format_args!("string {index} is not one of its {}", strings.len())));
        };
        self.token(token)
    }

    /// A copy of a token, counted.
    pub(super) fn owned_token(&mut self, index: u32) -> Result<String> {
        let token = self.token(index)?.to_owned();
        self.spend(SMALL + token.len() as u64)?;
        Ok(token)
    }

    fn owned_string(&mut self, index: u32) -> Result<String> {
        let string = self.string(index)?.to_owned();
        self.spend(SMALL + string.len() as u64)?;
        Ok(string)
    }

    fn cursor(&mut self, rep: ValueRep) -> Cursor<'_> {
        Cursor::new(&mut self.source, rep.payload(), "a value")
    }

    /// A value; `None` if it is of a type that [`Value`] does not have.
    pub(super) fn value(&mut self, rep: ValueRep) -> Result<Option<Value>> {
        self.nested_value(rep, 0)
    }

    fn nested_value(&mut self, rep: ValueRep, depth: usize) -> Result<Option<Value>> {
        self.spend(SMALL)?;
        if rep.is_array() {
            return self.array(rep);
        }
        let inlined = rep.inlined();
        Ok(Some(match rep.kind() {
            kind::BOOL => Value::Bool(inlined & 0xff != 0),
            kind::INT => Value::Int(inlined as i32),
            kind::FLOAT => Value::Float(f32::from_bits(inlined)),
            kind::HALF => Value::Float(f16::from_bits(inlined as u16).to_f32()),
            // Small whole numbers stand for themselves.
            kind::FLOAT3 | kind::HALF3 if rep.is_inlined() => Value::Float3(small_numbers(inlined)),
            kind::FLOAT4 | kind::HALF4 if rep.is_inlined() => Value::Float4(small_numbers(inlined)),
            kind::DOUBLE3 if rep.is_inlined() => Value::Double3(small_numbers::<3>(inlined).map(f64::from)),
            kind::FLOAT3 => Value::Float3(floats(self.cursor(rep).array::<12>()?)),
            kind::HALF3 => Value::Float3(halves(self.cursor(rep).array::<6>()?)),
            kind::FLOAT4 => Value::Float4(floats(self.cursor(rep).array::<16>()?)),
            kind::HALF4 => Value::Float4(halves(self.cursor(rep).array::<8>()?)),
            kind::DOUBLE3 => Value::Double3(doubles(self.cursor(rep).array::<24>()?)),
            kind::QUATF => Value::Quatd(real_first(floats(self.cursor(rep).array::<16>()?).map(f64::from))),
            kind::QUATH => Value::Quatd(real_first(halves(self.cursor(rep).array::<8>()?).map(f64::from))),
            kind::QUATD => Value::Quatd(real_first(doubles(self.cursor(rep).array::<32>()?))),
            kind::DOUBLE if rep.is_inlined() => Value::Double(f32::from_bits(inlined).into()),
            kind::DOUBLE => Value::Double(f64::from_le_bytes(self.cursor(rep).array()?)),
            kind::STRING => Value::String(self.owned_string(inlined)?),
            kind::TOKEN => Value::Token(self.owned_token(inlined)?),
            kind::ASSET => Value::Asset(self.owned_token(inlined)?),
            kind::MATRIX4D => Value::Matrix4d(self.matrix(rep)?),
            kind::DICTIONARY => Value::Dictionary(self.dictionary(rep, depth)?),
            kind::TOKEN_LIST_OP => {
                let tokens = self.list_op(rep)?;
                Value::PrependedTokens(self.owned_tokens(tokens)?)
            }
            kind::REFERENCE_LIST_OP => Value::PrependedReferences(self.references(rep)?),
            _ => return Ok(None),
        }))
    }

    fn matrix(&mut self, rep: ValueRep) -> Result<[[f64; 4]; 4]> {
        if !rep.is_inlined() {
            return Ok(matrix(self.cursor(rep).array()?));
        }
        // A diagonal of small whole numbers.
        let mut matrix = [[0.0; 4]; 4];
        for (i, byte) in rep.inlined().to_le_bytes().into_iter().enumerate() {
            matrix[i][i] = f64::from(byte as i8);
        }
        Ok(matrix)
    }

    fn dictionary(&mut self, rep: ValueRep, depth: usize) -> Result<Fields> {
        if rep.is_inlined() || rep.payload() == 0 {
            return Ok(Vec::new());
        }
        if depth == MOST_NESTED {
            return Err(self.damaged(format_args!("it has dictionaries more than {MOST_NESTED} deep")));
        }
        let mut cursor = self.cursor(rep);
        let count = cursor.u64()?;
        let mut at = cursor.at();
        let mut fields = Vec::new();
        for _ in 0..count {
            let mut cursor = Cursor::new(&mut self.source, at, "a dictionary");
            let name = cursor.u32()?;
            cursor.jump()?;
            let value = ValueRep(cursor.u64()?);
            at = cursor.at();
            let name = self.owned_string(name)?;
            fields.extend(self.nested_value(value, depth + 1)?.map(|value| (name, value)));
        }
        Ok(fields)
    }

    /// The items that a list operation puts in: its explicit, added, prepended and appended items, all of
    /// them numbers of four bytes.
    pub(super) fn list_op(&mut self, rep: ValueRep) -> Result<Vec<u32>> {
        let mut cursor = self.cursor(rep);
        let [parts] = cursor.array()?;
        let mut at = cursor.at();
        let mut items: Vec<[u8; 4]> = Vec::new();
        for part in LIST_OP_PARTS.into_iter().filter(|part| parts & part != 0) {
            let mut cursor = Cursor::new(&mut self.source, at, "a list operation");
            let count = cursor.u64()?;
            at = cursor.at();
            // Lists that are only skipped count too, because many fields may name one list.
            self.spend(count.saturating_mul(4))?;
            let mut cursor = Cursor::new(&mut self.source, at, "a list operation");
            let listed = cursor.elements(count)?;
            at = cursor.at();
            if LIST_OP_PUTS_IN & part != 0 {
                items.extend(listed);
            }
        }
        Ok(items.into_iter().map(u32::from_le_bytes).collect())
    }

    fn references(&mut self, rep: ValueRep) -> Result<Vec<Reference>> {
        let mut cursor = self.cursor(rep);
        let [parts] = cursor.array()?;
        let mut at = cursor.at();
        let mut references = Vec::new();
        for part in LIST_OP_PARTS.into_iter().filter(|part| parts & part != 0) {
            let mut cursor = Cursor::new(&mut self.source, at, "a list of references");
            let count = cursor.u64()?;
            at = cursor.at();
            for _ in 0..count {
                self.spend(SMALL)?;
                let mut cursor = Cursor::new(&mut self.source, at, "a reference");
                let (asset, prim) = (cursor.u32()?, cursor.u32()?);
                // Offset and scale of time, then custom data, of which there is none.
                let _offset: [u8; 16] = cursor.array()?;
                let extra = cursor.u64()?;
                if extra != 0 {
                    return Err(cursor.damaged("it has custom data, expected none"));
                }
                at = cursor.at();
                let reference = Reference { asset: self.owned_string(asset)?, prim: self.path(prim)? };
                if LIST_OP_PUTS_IN & part != 0 {
                    references.push(reference);
                }
            }
        }
        Ok(references)
    }

    /// A path as text; empty for none.
    pub(super) fn path(&mut self, index: u32) -> Result<String> {
        let mut elements = Vec::new();
        let mut next = Some(index);
        while let Some(index) = next {
            self.spend(SMALL)?;
            let node = self.structure.paths.get(index as usize).copied().flatten();
            // USD's empty path has a number and no place in the tree.
            let Some(node) = node else { return Ok(String::new()) };
            if node.parent.is_some() {
                elements.push(self.token(node.name)?.to_owned());
                elements.push(if node.is_property { "." } else { "/" }.to_owned());
            }
            next = node.parent;
        }
        elements.reverse();
        let path = if elements.is_empty() { "/".to_owned() } else { elements.concat() };
        self.spend(path.len() as u64)?;
        Ok(path)
    }

    fn array(&mut self, rep: ValueRep) -> Result<Option<Value>> {
        Ok(Some(match rep.kind() {
            kind::INT => Value::Ints(self.ints(rep)?),
            kind::FLOAT => Value::Floats(match rep.is_compressed() {
                true => self.compressed_floats(rep)?,
                false => self.elements(rep, f32::from_le_bytes)?,
            }),
            kind::FLOAT2 => Value::Float2s(self.elements(rep, floats::<8, 2>)?),
            kind::FLOAT3 => Value::Float3s(self.elements(rep, floats::<12, 3>)?),
            kind::FLOAT4 => Value::Float4s(self.elements(rep, floats::<16, 4>)?),
            kind::HALF => {
                let numbers = self.elements(rep, f16::from_le_bytes)?;
                Value::Floats(numbers.into_iter().map(f16::to_f32).collect())
            }
            kind::HALF2 => Value::Float2s(self.elements(rep, halves::<4, 2>)?),
            kind::HALF3 => Value::Float3s(self.elements(rep, halves::<6, 3>)?),
            kind::DOUBLE2 => Value::Double2s(self.elements(rep, doubles::<16, 2>)?),
            kind::DOUBLE3 => Value::Double3s(self.elements(rep, doubles::<24, 3>)?),
            kind::MATRIX4D => Value::Matrix4ds(self.elements(rep, matrix)?),
            kind::TOKEN => {
                let tokens = self.elements(rep, u32::from_le_bytes)?;
                Value::Tokens(self.owned_tokens(tokens)?)
            }
            kind::ASSET => {
                let strings = self.elements(rep, u32::from_le_bytes)?;
                Value::Assets(strings.into_iter().map(|i| self.owned_string(i)).collect::<Result<_>>()?)
            }
            _ => return Ok(None),
        }))
    }

    /// A list of names, as numbers of tokens.
    pub(super) fn token_vector(&mut self, rep: ValueRep) -> Result<Vec<u32>> {
        let mut cursor = self.cursor(rep);
        let count = cursor.u64()?;
        let tokens = cursor.elements(count)?;
        self.spend(count.saturating_mul(4))?;
        Ok(tokens.into_iter().map(u32::from_le_bytes).collect())
    }

    pub(super) fn owned_tokens(&mut self, tokens: Vec<u32>) -> Result<Vec<String>> {
        tokens.into_iter().map(|token| self.owned_token(token)).collect()
    }

    /// Where the elements of an array begin, and their number.
    fn array_head(&mut self, rep: ValueRep) -> Result<(Cursor<'_>, u64)> {
        let minor = self.structure.minor;
        let mut cursor = Cursor::new(&mut self.source, rep.payload(), "an array");
        if rep.payload() == 0 {
            return Ok((cursor, 0));
        }
        // An array's rank, once.
        if minor < 5 {
            cursor.u32()?;
        }
        let count = if minor < 7 { cursor.u32()?.into() } else { cursor.u64()? };
        Ok((cursor, count))
    }

    /// The elements of an array that is not compressed.
    fn elements<const N: usize, T>(&mut self, rep: ValueRep, element: fn([u8; N]) -> T) -> Result<Vec<T>> {
        if rep.is_compressed() {
            return Err(self.damaged("it has a compressed array of a type that is never compressed"));
        }
        let (mut cursor, count) = self.array_head(rep)?;
        let bytes = cursor.bytes(count.saturating_mul(N as u64))?;
        let values = bytes.as_chunks().0.iter().map(|bytes| element(*bytes)).collect();
        self.spend(bytes.len() as u64)?;
        Ok(values)
    }

    fn ints(&mut self, rep: ValueRep) -> Result<Vec<i32>> {
        if !rep.is_compressed() {
            return self.elements(rep, i32::from_le_bytes);
        }
        let (mut cursor, count) = self.array_head(rep)?;
        if count < SHORTEST_COMPRESSED {
            return Ok(cursor.elements(count)?.into_iter().map(i32::from_le_bytes).collect());
        }
        let at = cursor.at();
        self.compressed_ints(at, count).map(|(ints, _)| ints)
    }

    /// `count` compressed integers from `at` on, and where they end.
    fn compressed_ints(&mut self, at: u64, count: u64) -> Result<(Vec<i32>, u64)> {
        self.spend(count.saturating_mul(8))?;
        let mut cursor = Cursor::new(&mut self.source, at, "an array");
        let count = usize::try_from(count).map_err(|_| cursor.damaged("too long for this machine"))?;
        let ints = cursor.integers(count)?;
        Ok((ints, cursor.at()))
    }

    /// Floats that are whole numbers, or come from a small table.
    fn compressed_floats(&mut self, rep: ValueRep) -> Result<Vec<f32>> {
        let (mut cursor, count) = self.array_head(rep)?;
        if count < SHORTEST_COMPRESSED {
            return Ok(cursor.elements(count)?.into_iter().map(f32::from_le_bytes).collect());
        }
        let [code] = cursor.array()?;
        match code {
            b'i' => {
                let at = cursor.at();
                Ok(self.compressed_ints(at, count)?.0.into_iter().map(|i| i as f32).collect())
            }
            b't' => {
                let entries = cursor.u32()?;
                let table = cursor.elements(entries.into())?;
                let at = cursor.at();
                let indices = self.compressed_ints(at, count)?.0;
                let entry = |i: i32| table.get(i as u32 as usize).map(|bytes| f32::from_le_bytes(*bytes));
                let floats: Option<Vec<f32>> = indices.into_iter().map(entry).collect();
                floats.ok_or_else(|| self.damaged("it has an array with numbers beyond its table"))
            }
            _ => Err(cursor.damaged(format_args!("{code} is no way to compress floats"))),
        }
    }

    /// The times of time samples, and where their values are.
    pub(super) fn track(&mut self, rep: ValueRep) -> Result<Track> {
        let mut cursor = Cursor::new(&mut self.source, rep.payload(), "time samples");
        cursor.jump()?;
        let times = ValueRep(cursor.u64()?);
        cursor.jump()?;
        let count = cursor.u64()?;
        let values = cursor.elements(count)?;
        self.spend(count.saturating_mul(16))?;
        let mut cursor = Cursor::new(&mut self.source, times.payload(), "time codes");
        if times.kind() != kind::DOUBLE_VECTOR || times.is_array() {
            return Err(
                cursor.damaged(format_args!("are of type {}, expected a list of doubles", times.kind()))
            );
        }
        let listed = cursor.u64()?;
        if listed != count {
            return Err(cursor.damaged(format_args!("{listed} time codes for {count} samples")));
        }
        let times: Arc<[f64]> = cursor.elements(listed)?.into_iter().map(f64::from_le_bytes).collect();
        if let Some(i) = times
            .iter()
            .zip(&times[1.min(times.len())..])
            .position(|(a, b)| a.partial_cmp(b).is_none_or(std::cmp::Ordering::is_ge))
        {
            return Err(cursor.damaged(format_args!("time code {} (from 0) does not ascend", i + 1)));
        }
        let values = values.into_iter().map(|bytes| ValueRep(u64::from_le_bytes(bytes))).collect();
        Ok(Track { times, values })
    }
}

/// The parts of a list operation in their order in the file: explicit, added, prepended, appended, deleted,
/// ordered.
const LIST_OP_PARTS: [u8; 6] = [1 << 1, 1 << 2, 1 << 5, 1 << 6, 1 << 3, 1 << 4];
/// Explicit, added, prepended and appended.
const LIST_OP_PUTS_IN: u8 = 1 << 1 | 1 << 2 | 1 << 5 | 1 << 6;

fn floats<const B: usize, const N: usize>(bytes: [u8; B]) -> [f32; N] {
    let (numbers, _) = bytes.as_chunks();
    std::array::from_fn(|i| f32::from_le_bytes(numbers[i]))
}

fn doubles<const B: usize, const N: usize>(bytes: [u8; B]) -> [f64; N] {
    let (numbers, _) = bytes.as_chunks();
    std::array::from_fn(|i| f64::from_le_bytes(numbers[i]))
}

fn halves<const B: usize, const N: usize>(bytes: [u8; B]) -> [f32; N] {
    let (numbers, _) = bytes.as_chunks();
    std::array::from_fn(|i| f16::from_le_bytes(numbers[i]).to_f32())
}

/// The numbers, at most 4, of a vector that has a byte for each.
fn small_numbers<const N: usize>(inlined: u32) -> [f32; N] {
    let bytes = inlined.to_le_bytes();
    std::array::from_fn(|i| f32::from(bytes[i] as i8))
}

/// The format has a quaternion's real part last.
fn real_first([i, j, k, real]: [f64; 4]) -> [f64; 4] {
    [real, i, j, k]
}

fn matrix(bytes: [u8; 128]) -> [[f64; 4]; 4] {
    let (numbers, _) = bytes.as_chunks();
    std::array::from_fn(|row| std::array::from_fn(|column| f64::from_le_bytes(numbers[row * 4 + column])))
}
