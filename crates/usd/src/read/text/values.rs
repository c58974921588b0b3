//! Values in text, by USD's names of their types.

use super::lexer::{Lexer, Next};
use crate::layer::{Fields, Reference, Value};
use half::f16;
use rhytid_core::Result;

/// How deep dictionaries may be within dictionaries.
const MOST_NESTED: usize = 32;

/// A value of the type that USD calls `type_name`; `None` if [`Value`] has no such type, or the value is
/// `None`.
pub(super) fn value(lexer: &mut Lexer, type_name: &str) -> Result<Option<Value>> {
    nested_value(lexer, type_name, 0)
}

fn nested_value(lexer: &mut Lexer, type_name: &str, depth: usize) -> Result<Option<Value>> {
    // A blocked value.
    if lexer.at_word("None")? {
        lexer.skip_value()?;
        return Ok(None);
    }
    Ok(Some(match type_name {
        "bool" => Value::Bool(boolean(lexer)?),
        "int" => Value::Int(lexer.integer()?),
        "float" => Value::Float(float(lexer)?),
        "double" => Value::Double(lexer.number()?),
        "string" => Value::String(lexer.quoted()?),
        "token" => Value::Token(lexer.quoted()?),
        "asset" => Value::Asset(lexer.asset()?),
        "half" => Value::Float(half(lexer)?),
        "float3" | "point3f" | "normal3f" | "vector3f" | "color3f" => Value::Float3(tuple(lexer, float)?),
        "float4" | "color4f" => Value::Float4(tuple(lexer, float)?),
        "half4" | "color4h" => Value::Float4(tuple(lexer, half)?),
        "half3" | "point3h" | "normal3h" | "vector3h" | "color3h" => Value::Float3(tuple(lexer, half)?),
        "double3" | "point3d" | "normal3d" | "vector3d" | "color3d" => {
            Value::Double3(tuple(lexer, Lexer::number)?)
        }
        "quatd" => Value::Quatd(tuple(lexer, Lexer::number)?),
        "quatf" => Value::Quatd(tuple(lexer, float)?.map(f64::from)),
        "quath" => Value::Quatd(tuple(lexer, half)?.map(f64::from)),
        "matrix4d" => Value::Matrix4d(matrix(lexer)?),
        "token[]" => Value::Tokens(list(lexer, Lexer::quoted)?),
        "asset[]" => Value::Assets(list(lexer, Lexer::asset)?),
        "int[]" => Value::Ints(list(lexer, Lexer::integer)?),
        "half[]" => Value::Floats(list(lexer, half)?),
        "float[]" => Value::Floats(list(lexer, float)?),
        "half2[]" | "texCoord2h[]" => Value::Float2s(list(lexer, |lexer| tuple(lexer, half))?),
        "float2[]" | "texCoord2f[]" => Value::Float2s(list(lexer, |lexer| tuple(lexer, float))?),
        "half3[]" | "point3h[]" | "normal3h[]" | "vector3h[]" => {
            Value::Float3s(list(lexer, |lexer| tuple(lexer, half))?)
        }
        "float3[]" | "point3f[]" | "normal3f[]" | "vector3f[]" | "color3f[]" | "texCoord3f[]" => {
            Value::Float3s(list(lexer, |lexer| tuple(lexer, float))?)
        }
        "float4[]" | "color4f[]" => Value::Float4s(list(lexer, |lexer| tuple(lexer, float))?),
        "double2[]" | "texCoord2d[]" => Value::Double2s(list(lexer, |lexer| tuple(lexer, Lexer::number))?),
        "double3[]" | "point3d[]" | "normal3d[]" | "vector3d[]" => {
            Value::Double3s(list(lexer, |lexer| tuple(lexer, Lexer::number))?)
        }
        "matrix4d[]" | "frame4d[]" => Value::Matrix4ds(list(lexer, matrix)?),
        "frame4d" => Value::Matrix4d(matrix(lexer)?),
        "dictionary" => Value::Dictionary(dictionary(lexer, depth)?),
        _ => {
            lexer.skip_value()?;
            return Ok(None);
        }
    }))
}

/// Metadata, whose type the text does not state: USD knows it by the name. Known names give the type, and all
/// others are read by the form of the value. A value of no known form is left out.
pub(super) fn metadata(lexer: &mut Lexer, name: &str) -> Result<Option<Value>> {
    let type_name = match name {
        "defaultPrim" | "upAxis" | "kind" | "interpolation" | "colorSpace" => "token",
        "metersPerUnit" | "timeCodesPerSecond" | "framesPerSecond" | "startTimeCode" | "endTimeCode" => {
            "double"
        }
        "elementSize" | "unauthoredValuesIndex" => "int",
        _ => match lexer.next()? {
            Next::Quoted => "string",
            Next::Asset => "asset",
            Next::Mark(b'{') => "dictionary",
            Next::Word if lexer.at_word("true")? || lexer.at_word("false")? => "bool",
            _ => "",
        },
    };
    value(lexer, type_name)
}

/// A list of names behind `prepend apiSchemas =` and the like.
pub(super) fn tokens(lexer: &mut Lexer) -> Result<Vec<String>> {
    one_or_list(lexer, Lexer::quoted)
}

/// References: each a file, a prim or both, perhaps with an offset in time, which is left out.
pub(super) fn references(lexer: &mut Lexer) -> Result<Vec<Reference>> {
    one_or_list(lexer, |lexer| {
        let asset = if lexer.next()? == Next::Asset { lexer.asset()? } else { String::new() };
        let named = asset.is_empty() || lexer.next()? == Next::Path;
        let prim = if named { lexer.path()? } else { String::new() };
        if lexer.next()? == Next::Mark(b'(') {
            lexer.skip_value()?;
        }
        Ok(Reference { asset, prim })
    })
}

/// Paths to prims and properties.
pub(super) fn paths(lexer: &mut Lexer) -> Result<Vec<String>> {
    one_or_list(lexer, Lexer::path)
}

fn one_or_list<T>(lexer: &mut Lexer, item: fn(&mut Lexer) -> Result<T>) -> Result<Vec<T>> {
    match lexer.next()? {
        Next::Word if lexer.at_word("None")? => lexer.skip_value().map(|()| Vec::new()),
        Next::Mark(b'[') => list(lexer, item),
        _ => Ok(vec![item(lexer)?]),
    }
}

fn boolean(lexer: &mut Lexer) -> Result<bool> {
    let word = lexer.word("true or false")?;
    match word.as_str() {
        "true" | "1" => Ok(true),
        "false" | "0" => Ok(false),
        _ => Err(lexer.wrong(format_args!("found “{word}”, expected true or false; the file is damaged"))),
    }
}

fn float(lexer: &mut Lexer) -> Result<f32> {
    Ok(lexer.number()? as f32)
}

/// A number of 16 bits, which a float holds exactly.
fn half(lexer: &mut Lexer) -> Result<f32> {
    Ok(f16::from_f64(lexer.number()?).to_f32())
}

fn matrix(lexer: &mut Lexer) -> Result<[[f64; 4]; 4]> {
    tuple(lexer, |lexer| tuple(lexer, Lexer::number))
}

/// `(a, b, …)`.
fn tuple<T: Copy + Default, const N: usize>(
    lexer: &mut Lexer,
    mut element: impl FnMut(&mut Lexer) -> Result<T>,
) -> Result<[T; N]> {
    let mut elements = [T::default(); N];
    for (i, place) in elements.iter_mut().enumerate() {
        lexer.expect(if i == 0 { b'(' } else { b',' })?;
        *place = element(lexer)?;
    }
    lexer.expect(b')')?;
    Ok(elements)
}

/// `[a, b, …]`, with or without a comma behind the last.
fn list<T>(lexer: &mut Lexer, mut element: impl FnMut(&mut Lexer) -> Result<T>) -> Result<Vec<T>> {
    lexer.expect(b'[')?;
    let mut elements = Vec::new();
    while !lexer.accept(b']')? {
        if !elements.is_empty() {
            lexer.expect(b',')?;
            if lexer.accept(b']')? {
                break;
            }
        }
        elements.push(element(lexer)?);
    }
    Ok(elements)
}

/// `{ type name = value … }`.
fn dictionary(lexer: &mut Lexer, depth: usize) -> Result<Fields> {
    if depth == MOST_NESTED {
        return Err(
            lexer.wrong(format_args!("dictionaries are more than {MOST_NESTED} deep; the file is damaged"))
        );
    }
    lexer.expect(b'{')?;
    let mut fields = Vec::new();
    while !lexer.accept(b'}')? {
        let type_name = type_name(lexer)?;
        let name = match lexer.next()? {
            Next::Quoted => lexer.quoted()?,
            _ => lexer.word("the name of an entry")?,
        };
        lexer.expect(b'=')?;
        fields.extend(nested_value(lexer, &type_name, depth + 1)?.map(|value| (name, value)));
        while lexer.accept(b';')? {}
    }
    Ok(fields)
}

/// A type, with `[]` behind it for arrays.
pub(super) fn type_name(lexer: &mut Lexer) -> Result<String> {
    let mut name = lexer.word("a type")?;
    if lexer.accept(b'[')? {
        lexer.expect(b']')?;
        name.push_str("[]");
    }
    Ok(name)
}
