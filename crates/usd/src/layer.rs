//! A USD layer as plain data, for every kind of file. Both writers take one, and both readers return one, so
//! that text and binary cannot differ.
//!
//! Time samples are not part of a layer. An attribute with samples carries a number, under which they are
//! written and read one at a time.

/// A layer: its metadata, and the prims below the root.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layer {
    /// The layer's metadata, such as `defaultPrim`.
    pub metadata: Fields,
    /// The root prims.
    pub prims: Vec<Prim>,
}

/// Named values, each name once.
pub type Fields = Vec<(String, Value)>;

/// How a prim relates to prims of weaker layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Specifier {
    /// It is defined here.
    Def,
    /// It adds to what is defined elsewhere.
    Over,
}

/// A prim with everything below it.
#[derive(Debug, Clone, PartialEq)]
pub struct Prim {
    /// Defined here, or an opinion on another's.
    pub specifier: Specifier,
    /// The schema, such as `Mesh`; empty for none.
    pub type_name: String,
    /// An identifier: ASCII letters, digits and underscores, not beginning with a digit.
    pub name: String,
    /// Such as `kind` and `customData`.
    pub metadata: Fields,
    /// Attributes and relationships, each name once.
    pub properties: Vec<Property>,
    /// The prims below, each name once.
    pub children: Vec<Prim>,
}

/// A property of a prim.
#[derive(Debug, Clone, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "nearly all properties are attributes; where pointers are short it is not so large"
)]
pub enum Property {
    /// Has a value.
    Attribute(Attribute),
    /// Points to other objects.
    Relationship(Relationship),
}

/// An attribute, such as `points`.
#[derive(Debug, Clone, PartialEq)]
pub struct Attribute {
    /// The name with its namespaces, such as `primvars:st`.
    pub name: String,
    /// USD's name of the type, such as `point3f[]`.
    pub type_name: String,
    /// Whether it may not have time samples.
    pub uniform: bool,
    /// Such as `interpolation`.
    pub metadata: Fields,
    /// The value without a time.
    pub default: Option<Value>,
    /// The attributes that this one is connected to, as absolute paths; for a material, the source of its
    /// surface.
    pub connections: Vec<String>,
    /// The number under which its time samples are kept, different for each attribute of the layer; `None`
    /// without samples.
    pub samples: Option<usize>,
}

/// A relationship, such as `material:binding`.
#[derive(Debug, Clone, PartialEq)]
pub struct Relationship {
    /// The name with its namespaces.
    pub name: String,
    /// Absolute paths.
    pub targets: Vec<String>,
}

/// A reference to a prim of another layer, or to its default prim.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The other file, relative to this one.
    pub asset: String,
    /// An absolute path; empty for the default prim.
    pub prim: String,
}

/// A value of any of the types that are used here.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// `bool`
    Bool(bool),
    /// `int`
    Int(i32),
    /// `float`
    Float(f32),
    /// `double`
    Double(f64),
    /// `string`
    String(String),
    /// `token`
    Token(String),
    /// `asset`
    Asset(String),
    /// `float3` and its roles, such as `color3f`
    Float3([f32; 3]),
    /// `float4` and its roles, such as `color4f`
    Float4([f32; 4]),
    /// `double3` and its roles, such as `vector3d`
    Double3([f64; 3]),
    /// `quatd`: the real part, then the imaginary ones; also read from `quatf` and `quath`
    Quatd([f64; 4]),
    /// `matrix4d`, row by row; USD's vectors are rows, so that the last row is the translation.
    Matrix4d([[f64; 4]; 4]),
    /// `token[]`
    Tokens(Vec<String>),
    /// `asset[]`
    Assets(Vec<String>),
    /// `int[]`
    Ints(Vec<i32>),
    /// `float[]`
    Floats(Vec<f32>),
    /// `float2[]` and its roles, such as `texCoord2f[]`
    Float2s(Vec<[f32; 2]>),
    /// `float3[]` and its roles, such as `point3f[]`
    Float3s(Vec<[f32; 3]>),
    /// `float4[]` and `color4f[]`
    Float4s(Vec<[f32; 4]>),
    /// `double2[]`
    Double2s(Vec<[f64; 2]>),
    /// `double3[]` and its roles, such as `point3d[]`
    Double3s(Vec<[f64; 3]>),
    /// `matrix4d[]`
    Matrix4ds(Vec<[[f64; 4]; 4]>),
    /// `dictionary`
    Dictionary(Fields),
    /// A list of tokens that are put before those of weaker layers, such as `apiSchemas`.
    PrependedTokens(Vec<String>),
    /// References that are put before those of weaker layers.
    PrependedReferences(Vec<Reference>),
}

impl Property {
    /// The name with its namespaces.
    pub fn name(&self) -> &str {
        match self {
            Self::Attribute(attribute) => &attribute.name,
            Self::Relationship(relationship) => &relationship.name,
        }
    }
}

impl Value {
    /// USD's name of the type; `None` for lists that are put before others, which have no name.
    pub fn type_name(&self) -> Option<&'static str> {
        Some(match self {
            Self::Bool(_) => "bool",
            Self::Int(_) => "int",
            Self::Float(_) => "float",
            Self::Double(_) => "double",
            Self::String(_) => "string",
            Self::Token(_) => "token",
            Self::Asset(_) => "asset",
            Self::Float3(_) => "float3",
            Self::Float4(_) => "float4",
            Self::Double3(_) => "double3",
            Self::Quatd(_) => "quatd",
            Self::Matrix4d(_) => "matrix4d",
            Self::Tokens(_) => "token[]",
            Self::Assets(_) => "asset[]",
            Self::Ints(_) => "int[]",
            Self::Floats(_) => "float[]",
            Self::Float2s(_) => "float2[]",
            Self::Float3s(_) => "float3[]",
            Self::Float4s(_) => "float4[]",
            Self::Double2s(_) => "double2[]",
            Self::Double3s(_) => "double3[]",
            Self::Matrix4ds(_) => "matrix4d[]",
            Self::Dictionary(_) => "dictionary",
            Self::PrependedTokens(_) | Self::PrependedReferences(_) => return None,
        })
    }
}
