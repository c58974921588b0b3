//! Layers as `make.py` writes them.
use rhytid_formats::usd::layer::{Attribute, Fields, Prim, Property, Specifier, Value};
use rhytid_formats::usd::read::{Opened, Samples};
use serde_json::{Map, Value as Json, json};

pub(super) fn layer(opened: &mut Opened) -> Json {
    let Opened { layer, samples, .. } = opened;
    let prims: Map<String, Json> =
        layer.prims.iter().map(|p| (p.name.clone(), prim(p, samples.as_mut()))).collect();
    json!({ "metadata": fields(&layer.metadata), "prims": prims })
}

fn fields(fields: &Fields) -> Json {
    Json::Object(fields.iter().map(|(name, field)| (name.clone(), value(field))).collect())
}

fn prim(found: &Prim, samples: &mut dyn Samples) -> Json {
    let properties: Map<String, Json> =
        found.properties.iter().map(|p| (p.name().to_owned(), property(p, samples))).collect();
    let children: Map<String, Json> =
        found.children.iter().map(|c| (c.name.clone(), prim(c, samples))).collect();
    json!({
        "def": found.specifier == Specifier::Def,
        "type": found.type_name,
        "metadata": fields(&found.metadata),
        "properties": properties,
        "children": children,
    })
}

fn property(found: &Property, samples: &mut dyn Samples) -> Json {
    let found: &Attribute = match found {
        Property::Attribute(attribute) => attribute,
        Property::Relationship(relationship) => return json!({ "targets": relationship.targets }),
    };
    let is_custom = |(name, _): &&(String, Value)| name == "custom";
    let others = found.metadata.iter().filter(|field| !is_custom(field)).cloned().collect();
    let listed: Vec<Json> = found.samples.map_or_else(Vec::new, |n| {
        let times = samples.times(n).to_vec();
        let sample = |(i, time)| json!([value(&Value::Double(time)), value(&samples.read(n, i).unwrap())]);
        times.into_iter().enumerate().map(sample).collect()
    });
    json!({
        "type": found.type_name,
        "uniform": found.uniform,
        "metadata": fields(&others),
        "custom": found.metadata.iter().any(|field| is_custom(&field)),
        "default": found.default.as_ref().map(value),
        "connections": found.connections,
        "samples": listed,
    })
}

fn value(found: &Value) -> Json {
    match found {
        Value::Bool(x) => json!(x),
        Value::Int(x) => json!(x),
        Value::Float(x) => hex(&f64::from(*x).to_le_bytes()),
        Value::Double(x) => hex(&x.to_le_bytes()),
        Value::String(x) | Value::Token(x) => json!({ "text": x }),
        Value::Asset(x) => json!({ "asset": x }),
        Value::Matrix4d(x) => hex(bytemuck::bytes_of(x)),
        Value::Tokens(x) | Value::PrependedTokens(x) => json!({ "tokens": x }),
        Value::Assets(x) => json!({ "assets": x }),
        Value::Ints(x) => json!({ "array": hex(bytemuck::cast_slice(x)) }),
        Value::Floats(x) => json!({ "array": hex(bytemuck::cast_slice(x)) }),
        Value::Float2s(x) => json!({ "array": hex(bytemuck::cast_slice(x)) }),
        Value::Float3s(x) => json!({ "array": hex(bytemuck::cast_slice(x)) }),
        Value::Float4s(x) => json!({ "array": hex(bytemuck::cast_slice(x)) }),
        Value::Float3(x) => hex(bytemuck::bytes_of(x)),
        Value::Float4(x) => hex(bytemuck::bytes_of(x)),
        Value::Double3(x) => hex(bytemuck::bytes_of(x)),
        Value::Quatd(x) => hex(bytemuck::bytes_of(x)),
        Value::Double3s(x) => json!({ "array": hex(bytemuck::cast_slice(x)) }),
        Value::Double2s(x) => json!({ "array": hex(bytemuck::cast_slice(x)) }),
        Value::Matrix4ds(x) => json!({ "array": hex(bytemuck::cast_slice(x)) }),
        Value::Dictionary(x) => json!({ "dictionary": fields(x) }),
        Value::PrependedReferences(x) => {
            json!({ "references": x.iter().map(|r| [&r.asset, &r.prim]).collect::<Vec<_>>() })
        }
    }
}

fn hex(bytes: &[u8]) -> Json {
    Json::String(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
