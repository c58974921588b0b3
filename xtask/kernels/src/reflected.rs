//! A kernel's description in words that all languages share, and its differences from the table.
use rhytid_kernels::table::{Access, Binding, Element, Entry, WORKGROUP_SIZE};
use std::fmt::{self, Display, Formatter};

/// A language of the kernels that can be reflected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Language {
    Spirv,
    Wgsl,
    OpenCl,
}

impl Language {
    pub(crate) const ALL: [Self; 3] = [Self::Spirv, Self::Wgsl, Self::OpenCl];

    /// The ending of the language's files.
    pub(crate) fn extension(self) -> &'static str {
        match self {
            Self::Spirv => "spv",
            Self::Wgsl => "wgsl",
            Self::OpenCl => "cl",
        }
    }

    /// The place of the table's buffer `index`.
    fn slot(self, index: usize) -> String {
        match self {
            Self::Spirv | Self::Wgsl => binding_slot(0, index),
            Self::OpenCl => argument_slot(index),
        }
    }

    /// The type of an array's elements. OpenCL has pointers to scalars, and reads several at once by casts.
    fn element(self, element: Element) -> &'static str {
        match element {
            Element::F32 => "f32",
            Element::U32 => "u32",
            Element::U32x2 if self == Self::OpenCl => "u32",
            Element::F32x4 if self == Self::OpenCl => "f32",
            Element::U32x2 => "vec2 of u32",
            Element::F32x4 => "vec4 of f32",
        }
    }

    /// The place of the parameter block after `buffers` buffers.
    fn params_slot(self, buffers: usize) -> String {
        match self {
            Self::Spirv => PUSH_CONSTANTS.into(),
            Self::Wgsl | Self::OpenCl => self.slot(buffers),
        }
    }
}

pub(crate) const PUSH_CONSTANTS: &str = "push constants";

pub(crate) fn binding_slot(group: usize, binding: usize) -> String {
    format!("binding {binding} of group {group}")
}

pub(crate) fn argument_slot(index: usize) -> String {
    format!("argument {index}")
}

/// A kernel as a compiler sees it.
#[derive(Debug)]
pub(crate) struct Reflected {
    /// All entry points of the source.
    pub entry_points: Vec<String>,
    /// The workgroup size of the first entry point.
    pub workgroup_size: [usize; 3],
    /// The buffers in the order of their bindings.
    pub buffers: Vec<Buffer>,
    /// The place of each parameter block and its fields. One block is expected.
    pub params: Vec<(String, Vec<Field>)>,
}

/// A buffer as a compiler sees it.
#[derive(Debug)]
pub(crate) struct Buffer {
    pub slot: String,
    pub name: String,
    /// `f32`, `u32`, or the name of another type.
    pub element: String,
    /// `read`, `write` or `read and write`.
    pub access: &'static str,
}

/// A field of a parameter block.
#[derive(Debug)]
pub(crate) struct Field {
    pub name: String,
    pub offset: usize,
    pub element: String,
}

impl Display for Buffer {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "`{}` (array of {}, {}, {})", self.name, self.element, self.access, self.slot)
    }
}

impl Display for Field {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "`{}` ({} at byte {})", self.name, self.element, self.offset)
    }
}

/// One sentence for each difference from the table.
pub(crate) fn differences(kernel: &Entry, language: Language, found: &Reflected) -> Vec<String> {
    let buffer = |(index, binding): (usize, &Binding)| Buffer {
        slot: language.slot(index),
        name: binding.buffer.name().into(),
        element: language.element(binding.element).into(),
        access: access(binding.access, language),
    };
    let buffers: Vec<Buffer> = kernel.bindings.iter().enumerate().map(buffer).collect();
    let (slots, fields): (Vec<String>, Vec<&Vec<Field>>) =
        found.params.iter().map(|(slot, fields)| (slot.clone(), fields)).unzip();
    [
        compare("entry point", &found.entry_points, &[kernel.name.to_owned()]),
        compare("workgroup size along axis", &found.workgroup_size, &[WORKGROUP_SIZE as usize, 1, 1]),
        compare("buffer", &found.buffers, &buffers),
        compare("parameter block", &slots, &[language.params_slot(buffers.len())]),
        compare("parameter", &fields.into_iter().flatten().collect::<Vec<_>>(), &parameters(kernel)),
    ]
    .concat()
}

/// One sentence for each position at which `found` differs from `expected`.
pub(crate) fn compare<F: Display, E: Display>(what: &str, found: &[F], expected: &[E]) -> Vec<String> {
    let shown = |item: Option<String>| item.unwrap_or("none".into());
    let at = |index| {
        let found = shown(found.get(index).map(F::to_string));
        let expected = shown(expected.get(index).map(E::to_string));
        (found != expected).then(|| format!("{what} {index}: found {found}, expected {expected}"))
    };
    (0..found.len().max(expected.len())).filter_map(at).collect()
}

/// The parameter block that the table describes: each field a `u32`, without gaps.
pub(crate) fn parameters(kernel: &Entry) -> Vec<Field> {
    let field = |(index, name): (usize, &&str)| Field {
        name: (*name).into(),
        offset: 4 * index,
        element: "u32".into(),
    };
    kernel.params.iter().enumerate().map(field).collect()
}

/// WGSL and OpenCL cannot say that a buffer is only written.
fn access(access: Access, language: Language) -> &'static str {
    match (access, language) {
        (Access::Read, _) => "read",
        (Access::ReadWrite, Language::Spirv) => "read and write",
        (Access::Write | Access::ReadWrite, _) => "write",
    }
}
