//! Turns the text of a project file into a [`Project`]. Keys, types and values are checked; files are not
//! touched.
use super::prior;
use super::sections::{
    Edges, ExampleSection, FineScaleSection, HandlesSection, LargeScaleSection, LearnedSection, MeshSection,
    Method, PinsSection, PriorSection, Project, StrainSection, Units,
};
use crate::document::{File, Section, found, tables, vector_of};
use rhytid_core::text::quoted;
use rhytid_core::{Bind, ContactSettings, InputErrorKind, LearnedSettings, Result, UpAxis, WrinkleStrains};
use rhytid_geometry::Axes;
use rhytid_meshes::{Format, NormalMapConvention, has_shapes};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use toml::de::DeValue;

/// Checks the text of a project file; `name` names the file in errors.
///
/// # Errors
/// [`Error::Input`](rhytid_core::Error::Input): no TOML, a missing section or key, an unknown key, a value of
/// the wrong type or out of its range, two examples of one name.
pub fn parse(text: &str, name: &str) -> Result<Project> {
    let document = tables(text, name)?;
    let file = File { text, name };
    let root = Section { file, title: String::new(), offset: 0, table: document.get_ref() };
    root.allow(&[
        "method",
        "align",
        "mesh",
        "handles",
        "example",
        "prior",
        "pins",
        "contact",
        "large_scale",
        "strain",
        "fine_scale",
        "learned",
    ])?;
    Ok(Project {
        method: method_of(&root)?,
        align: root.truth("align")?.unwrap_or(true),
        mesh: mesh(&root.required_section("mesh", "neutral and units")?)?,
        handles: handles(&root.required_section("handles", "vertices")?)?,
        examples: examples(&root)?,
        prior: root.section("prior")?.map(|s| prior_section(&s)).transpose()?,
        pins: root.section("pins")?.map_or_else(|| Ok(<_>::default()), |s| pins(&s))?,
        contact: root.section("contact")?.map_or_else(|| Ok(<_>::default()), |s| contact(&s))?,
        large_scale: root.section("large_scale")?.map_or_else(|| Ok(<_>::default()), |s| large_scale(&s))?,
        strain: root.section("strain")?.map_or_else(|| Ok(<_>::default()), |s| strain(&s))?,
        fine_scale: root.section("fine_scale")?.map_or_else(|| Ok(<_>::default()), |s| fine_scale(&s))?,
        learned: root.section("learned")?.map_or_else(|| Ok(<_>::default()), |s| learned(&s))?,
    })
}

const METHODS: &str = "\"learned\" or \"chapter\"";

/// The method that the file names, at its top or, as in older files, under `[fine_scale]`.
fn method_of(root: &Section<'_>) -> Result<Method> {
    let above = method(root)?;
    let Some(section) = root.section("fine_scale")? else { return Ok(above.unwrap_or_default()) };
    let below = method(&section)?;
    match (above, below) {
        (Some(above), Some(below)) if above != below => {
            let found = quoted(section.text("method", METHODS)?.unwrap_or_default());
            Err(section.wrong("method", &found, "the one at the top of the file: name it there alone"))
        }
        _ => Ok(above.or(below).unwrap_or_default()),
    }
}

fn method(section: &Section<'_>) -> Result<Option<Method>> {
    match section.text("method", METHODS)? {
        None => Ok(None),
        Some("learned") => Ok(Some(Method::Learned)),
        Some("chapter") => Ok(Some(Method::Chapter)),
        Some(other) => Err(section.wrong("method", &quoted(other), METHODS)),
    }
}

const RIDGE: &str = "a number above 0, at most 1000000";

fn is_ridge(ridge: f64) -> bool {
    ridge > 0.0 && ridge <= LearnedSettings::LARGEST_RIDGE
}

fn learned(section: &Section<'_>) -> Result<LearnedSection> {
    section.allow_with_former(
        &["share", "ridge", "wrinkle_ridge", "marker_noise", "reach", "fade", "wrinkle_strains"],
        &["fold_ridge", "fold_strains"],
    )?;
    let wrinkle_ridge = section.name_of("wrinkle_ridge", "fold_ridge")?;
    let wrinkle_strains = section.name_of("wrinkle_strains", "fold_strains")?;
    let number = |key: &str, expected: &str, is_right: fn(f64) -> bool| match section.get(key) {
        None => Ok(None),
        Some(value) => section
            .number(key)
            .filter(|number| is_right(*number))
            .map(Some)
            .ok_or_else(|| section.wrong(key, &found(value), expected)),
    };
    Ok(LearnedSection {
        share: number("share", "a number from 0 to 1", |s| (0.0..=1.0).contains(&s))?,
        ridge: number("ridge", RIDGE, is_ridge)?,
        wrinkle_ridge: number(wrinkle_ridge, RIDGE, is_ridge)?,
        marker_noise: number("marker_noise", "millimetres, a number from 0 to 1000", |noise| {
            (0.0..=LearnedSettings::LARGEST_NOISE).contains(&noise)
        })?,
        reach: match section.get("reach") {
            Some(DeValue::Float(number)) if matches!(number.as_str(), "inf" | "+inf") => Some(f64::INFINITY),
            _ => number("reach", "a number from 1, inf for no bound", |reach| reach >= 1.0)?,
        },
        fade: section.truth("fade")?,
        wrinkle_strains: match section.text(wrinkle_strains, "\"vectors\" or \"lengths\"")? {
            None => None,
            Some("vectors") => Some(WrinkleStrains::Vectors),
            Some("lengths") => Some(WrinkleStrains::Lengths),
            Some(other) => {
                return Err(section.wrong(
                    wrinkle_strains,
                    &format!("{other:?}"),
                    "\"vectors\" or \"lengths\"",
                ));
            }
        },
    })
}

/// Metres in a mesh unit.
const SIZES: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

fn mesh(section: &Section<'_>) -> Result<MeshSection> {
    section.allow(&["name", "neutral", "prim", "units", "up", "weld", "textures"])?;
    let neutral = section.path("neutral", "the file of the neutral mesh")?;
    let prim = prim(section, &neutral)?;
    let name = section.text("name", "a name")?;
    if let Some(name) = name.filter(|name| name.trim().is_empty()) {
        return Err(section.wrong("name", &quoted(name), "a name that is not empty"));
    }
    let units = units(section, "units")?;
    // Files of the other formats state no unit.
    if units.is_none() && !states_space(&neutral) {
        return Err(section.lacks("units", UNITS));
    }
    let up = match section.text("up", "\"y\" or \"z\"")? {
        None => None,
        Some("y" | "Y") => Some(UpAxis::Y),
        Some("z" | "Z") => Some(UpAxis::Z),
        Some(other) => return Err(section.wrong("up", &quoted(other), "\"y\" or \"z\"")),
    };
    let weld = section.truth("weld")?;
    let textures = section.truth("textures")?;
    Ok(MeshSection { name: name.map(str::to_owned), neutral, prim, units, up, weld, textures })
}

/// Whether the files of this format may state their unit and the axis that points up.
fn states_space(mesh: &Path) -> bool {
    matches!(Format::from_extension(mesh), Ok(Format::Gltf | Format::Usd))
}

/// The prim that a section names in its file, which is `mesh`.
fn prim(section: &Section<'_>, mesh: &Path) -> Result<Option<String>> {
    let expected = "the path of a prim, such as \"/head/face\"";
    let Some(prim) = section.text("prim", expected)? else { return Ok(None) };
    if !prim.starts_with('/') {
        return Err(section.wrong("prim", &quoted(prim), expected));
    }
    of_usd(section, "prim", mesh)?;
    Ok(Some(prim.to_owned()))
}

/// Refuses a key that only USD files have, if `mesh` is none.
fn of_usd(section: &Section<'_>, key: &str, mesh: &Path) -> Result<()> {
    if matches!(Format::from_extension(mesh), Ok(Format::Usd)) {
        return Ok(());
    }
    let what =
        format!("has {key}, which only USD files have; leave it out, or export {} as USD", mesh.display());
    Err(section.error(&what).of_kind(InputErrorKind::Conflict))
}

const UNITS: &str = "\"m\", \"cm\", \"mm\", \"in\" or a number above 0, the metres in one mesh unit";

/// The unit that a key names.
fn units(section: &Section<'_>, key: &str) -> Result<Option<Units>> {
    let Some(value) = section.get(key) else { return Ok(None) };
    Ok(Some(match value {
        DeValue::String(unit) => Units::named(unit).ok_or_else(|| {
            section
                .wrong(key, &quoted(unit), UNITS)
                .of_kind(InputErrorKind::UnknownUnit { found: unit.to_string() })
        })?,
        _ => {
            let metres = section.positive(key, UNITS)?;
            if !SIZES.contains(&metres) {
                let range = "a number of metres from 0.000001 to 1000000, in which heads are neither dust nor planets";
                return Err(section.wrong(key, &format!("{metres:?}"), range));
            }
            Units::MetresPerUnit(metres)
        }
    }))
}

/// The axes that a key names.
fn axes(section: &Section<'_>) -> Result<Option<Axes>> {
    let expected = "the mesh's axes that are the neutral's x, y and z, such as \"+x-z+y\" for a mesh with y up \
                    beside a neutral with z up";
    let Some(text) = section.text("axes", expected)? else { return Ok(None) };
    text.parse().map(Some).map_err(|_| section.wrong("axes", &quoted(text), expected))
}

fn handles(section: &Section<'_>) -> Result<HandlesSection> {
    section.allow(&["vertices"])?;
    let vertices = section.path("vertices", "a CSV file with the header label,vertex")?;
    Ok(HandlesSection { vertices })
}

fn examples(root: &Section<'_>) -> Result<Vec<ExampleSection>> {
    let mut examples = Vec::new();
    let mut seen = HashMap::new();
    let sections = root.sections("example")?;
    for section in &sections {
        section.allow(&[
            "name",
            "mesh",
            "prim",
            "time",
            "shape",
            "shapes",
            "weight",
            "unit",
            "scale",
            "axes",
            "mirror",
            "noise",
            "take",
            "frame",
            "displacement",
            "millimetres",
            "normal_map",
            "green",
            "strength",
        ])?;
        let name = example_name(section)?;
        if let Some(name) = name
            && let Some(first) = seen.insert(name, section)
        {
            let line = first.line("name");
            let expected = format!("{EXAMPLE_NAME}, but line {line} has it too");
            return Err(section.wrong("name", &quoted(name), &expected));
        }
        examples.push(example(section, name)?);
    }
    Ok(examples)
}

const EXAMPLE_NAME: &str = "a name that no other example has";

fn example_name<'a>(section: &Section<'a>) -> Result<Option<&'a str>> {
    match section.text("name", EXAMPLE_NAME)? {
        None => Ok(None),
        Some(name) if name.trim().is_empty() => {
            Err(section.wrong("name", &quoted(name), "a name that is not empty"))
        }
        Some(name) => Ok(Some(name)),
    }
}

fn example(section: &Section<'_>, name: Option<&str>) -> Result<ExampleSection> {
    let mesh = section.path("mesh", "the file of the example's mesh")?;
    let prim = prim(section, &mesh)?;
    let time = match section.get("time") {
        None => None,
        Some(value) => {
            of_usd(section, "time", &mesh)?;
            let time = section.number("time");
            Some(time.ok_or_else(|| section.wrong("time", &found(value), "a time code of the file"))?)
        }
    };
    let shape = names(section, "shape", "the name of a shape, or a list of shapes that are added up")?;
    let shapes = names(section, "shapes", "\"*\" for all shapes, or a list of names and patterns")?;
    let weight = match section.get("weight") {
        None => None,
        Some(value) => {
            if shape.is_empty() && shapes.is_empty() {
                needs(section, "weight", "shape")?;
            }
            let weight = section.number("weight").filter(|weight| *weight != 0.0 && weight.abs() <= 100.0);
            let expected = "what shapes are multiplied by, a number from -100 to 100 that is not 0";
            Some(weight.ok_or_else(|| section.wrong("weight", &found(value), expected))?)
        }
    };
    let unit = units(section, "unit")?;
    let scale = positive(section, "scale", "what the mesh is multiplied by, a number above 0", 1e6)?;
    let axes = axes(section)?;
    let mirror = section.truth("mirror")?.unwrap_or(false);
    let millimetres_of_noise = "millimetres, a number from 0 to 1000";
    let noise = match section.get("noise") {
        None => None,
        Some(value) => Some(
            section
                .number("noise")
                .filter(|noise| (0.0..=LearnedSettings::LARGEST_NOISE).contains(noise))
                .ok_or_else(|| section.wrong("noise", &found(value), millimetres_of_noise))?,
        ),
    };
    let take = file(section, "take", "the take's CSV that the mesh is a frame of")?;
    let displacement = file(section, "displacement", "a displacement map, a PNG")?;
    let normal_map = file(section, "normal_map", "a tangent-space normal map, a PNG")?;
    if displacement.is_some() && normal_map.is_some() {
        return Err(section
            .error("has displacement and normal_map; leave one of them out")
            .of_kind(InputErrorKind::Conflict));
    }
    for key in ["green", "strength"] {
        needs(section, key, "normal_map")?;
    }
    let green = green(section)?;
    let strength =
        positive(section, "strength", "what heights are multiplied by, a number above 0, at most 1000", 1e3)?;
    for (key, partner) in [("frame", "take"), ("millimetres", "displacement")] {
        needs(section, key, partner)?;
        if section.get(partner).is_some() && section.get(key).is_none() {
            return Err(section.lacks(key, &format!("one beside {partner}")));
        }
    }
    let millimetres = positive(
        section,
        "millimetres",
        "how far white moves a vertex, a number above 0, at most 1000",
        1e3,
    )?;
    let frame = section.whole("frame", "a frame of the take, counted from 0")?;
    let example = ExampleSection {
        name: name.map(str::to_owned),
        mesh,
        prim,
        time,
        shape,
        shapes,
        weight,
        unit,
        scale,
        axes,
        mirror,
        noise,
        take,
        frame,
        displacement,
        millimetres,
        normal_map,
        green,
        strength,
    };
    check_number(section, &example)?;
    Ok(example)
}

/// Checks that the keys fit a section of one example, or of many.
fn check_number(section: &Section<'_>, example: &ExampleSection) -> Result<()> {
    let is_one = example.name.is_some() || !example.shape.is_empty();
    let is_many = !example.shapes.is_empty() || example.names_files();
    if !is_one && !is_many {
        return Err(section.lacks("name", EXAMPLE_NAME));
    }
    if example.shapes.is_empty() && !is_many {
        return Ok(());
    }
    for key in ["name", "shape", "take", "displacement", "normal_map"] {
        if section.get(key).is_some() {
            let many = if example.shapes.is_empty() { "a pattern of files" } else { "shapes" };
            let what = format!("has {key}, which is of one example, and {many}; leave one of them out");
            return Err(section.error(&what).of_kind(InputErrorKind::Conflict));
        }
    }
    Ok(())
}

/// A name or a list of names; none where the key is not there.
fn names(section: &Section<'_>, key: &str, expected: &str) -> Result<Vec<String>> {
    match section.get(key) {
        Some(DeValue::String(name)) if !name.is_empty() => Ok(vec![name.to_string()]),
        Some(DeValue::Array(items)) if items.is_empty() => Err(section.wrong(key, "an empty list", expected)),
        _ => section.texts(key, expected),
    }
}

/// A file that need not be named.
fn file(section: &Section<'_>, key: &str, expected: &str) -> Result<Option<PathBuf>> {
    match section.get(key) {
        None => Ok(None),
        Some(_) => section.path(key, expected).map(Some),
    }
}

/// A number above 0, and at most `most`, that need not be there.
fn positive(section: &Section<'_>, key: &str, expected: &str, most: f64) -> Result<Option<f64>> {
    let Some(value) = section.get(key) else { return Ok(None) };
    match section.positive(key, expected)? {
        number if number <= most => Ok(Some(number)),
        _ => Err(section.wrong(key, &found(value), expected)),
    }
}

/// A key that is of no use without its partner.
fn needs(section: &Section<'_>, key: &str, partner: &str) -> Result<()> {
    if section.get(key).is_some() && section.get(partner).is_none() {
        return Err(section
            .error(&format!("has {key} without {partner}; name that too, or leave it out"))
            .of_kind(InputErrorKind::Conflict));
    }
    Ok(())
}

fn green(section: &Section<'_>) -> Result<Option<NormalMapConvention>> {
    let expected = "\"up\" (OpenGL) or \"down\" (DirectX)";
    match section.text("green", expected)? {
        None => Ok(None),
        Some("up") => Ok(Some(NormalMapConvention::Up)),
        Some("down") => Ok(Some(NormalMapConvention::Down)),
        Some(other) => Err(section.wrong("green", &quoted(other), expected)),
    }
}

fn prior_section(section: &Section<'_>) -> Result<PriorSection> {
    section.allow(&["from", "neutral", "landmarks", "weight"])?;
    let from =
        section.path("from", "a folder of meshes, a mesh with shapes (.glb), or a rig (.safetensors)")?;
    let neutral =
        file(section, "neutral", "the mesh at rest that the meshes of the folder are expressions of")?;
    let landmarks = file(section, "landmarks", "a CSV file with pairs of handles, those of the rig first")?;
    let (is_rig, has_shapes) = (prior::is_rig(&from), has_shapes(&from));
    for (key, fits, of) in [("neutral", !is_rig && !has_shapes, "a folder"), ("landmarks", is_rig, "a rig")] {
        if section.get(key).is_some() && !fits {
            return Err(section
                .error(&format!("has {key}, which is of use only where from is {of}; leave it out"))
                .of_kind(InputErrorKind::Conflict));
        }
    }
    let expected = "\"auto\" or a number from 0 to 1";
    let weight = match section.get("weight") {
        None => None,
        Some(DeValue::String(text)) if text == "auto" => None,
        Some(value) => Some(
            section
                .number("weight")
                .filter(|weight| (0.0..=1.0).contains(weight))
                .ok_or_else(|| section.wrong("weight", &found(value), expected))?,
        ),
    };
    Ok(PriorSection { from, neutral, landmarks, weight })
}

fn pins(section: &Section<'_>) -> Result<PinsSection> {
    section.allow(&["auto", "vertices", "box", "groups"])?;
    let corners = "two corners, [[x, y, z], [x, y, z]] in mesh units";
    let bounds = match section.get("box") {
        None => None,
        Some(value) => {
            let bounds = corners_of(value).ok_or_else(|| section.wrong("box", &found(value), corners))?;
            Some([0, 1].map(|end: usize| {
                [0, 1, 2].map(|c| {
                    if end == 0 { bounds[0][c].min(bounds[1][c]) } else { bounds[0][c].max(bounds[1][c]) }
                })
            }))
        }
    };
    let names = "a list of names of the neutral's groups";
    let groups = section.texts("groups", names)?;
    let vertices = match section.get("vertices") {
        None => None,
        Some(_) => Some(section.path("vertices", "a CSV file with the header vertex")?),
    };
    Ok(PinsSection { auto: section.truth("auto")?, vertices, bounds, groups })
}

/// Two corners of a box, if that is what the value is.
fn corners_of(value: &DeValue<'_>) -> Option<[[f64; 3]; 2]> {
    let DeValue::Array(items) = value else { return None };
    let corners: Option<Vec<[f64; 3]>> = items.iter().map(|corner| vector_of(corner.get_ref())).collect();
    corners?.try_into().ok()
}

fn large_scale(section: &Section<'_>) -> Result<LargeScaleSection> {
    section.allow(&["bending_length", "bind", "rotations"])?;
    let bending_length = match section.get("bending_length") {
        None => None,
        Some(_) => Some(section.positive("bending_length", "a length in mesh units, a number above 0")?),
    };
    let binds = "\"auto\", \"rigid\" or \"nearest\"";
    let bind = match section.text("bind", binds)? {
        None | Some("auto") => Bind::Auto,
        Some("rigid") => Bind::Rigid,
        Some("nearest") => Bind::Nearest,
        Some(other) => return Err(section.wrong("bind", &quoted(other), binds)),
    };
    let rotations = section.truth("rotations")?.unwrap_or_default();
    Ok(LargeScaleSection { bending_length, bind, rotations })
}

fn contact(section: &Section<'_>) -> Result<ContactSettings> {
    section.allow(&["eyes", "openings"])?;
    let default = ContactSettings::default();
    Ok(ContactSettings {
        eyes: section.truth("eyes")?.unwrap_or(default.eyes),
        openings: section.truth("openings")?.unwrap_or(default.openings),
    })
}

fn strain(section: &Section<'_>) -> Result<StrainSection> {
    section.allow(&["edges"])?;
    let edges = match section.get("edges") {
        None => Edges::default(),
        Some(_) => {
            let path = section.path("edges", "\"auto\" or a CSV file with the header a,b")?;
            if path.as_os_str() == "auto" { Edges::Auto } else { Edges::File(path) }
        }
    };
    Ok(StrainSection { edges })
}

fn fine_scale(section: &Section<'_>) -> Result<FineScaleSection> {
    section.allow(&["method", "max_influences"])?;
    let mut fine_scale = FineScaleSection::default();
    if let Some(value) = section.get("max_influences") {
        fine_scale.max_influences = match value {
            DeValue::Integer(n) => u32::from_str_radix(n.as_str(), n.radix()).ok().filter(|&n| n >= 1),
            _ => None,
        }
        .map(|n| n as usize)
        .ok_or_else(|| section.wrong("max_influences", &found(value), "a whole number from 1"))?;
    }
    Ok(fine_scale)
}
