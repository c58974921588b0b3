//! The text of a project file to a [`Project`]: keys, types and values are checked, files are not touched.
use super::sections::{
    Edges, ExampleSection, FineScaleSection, HandlesSection, LargeScaleSection, LearnedSection, MeshSection,
    Method, Project, StrainSection, Units,
};
use crate::tables::text::{did_you_mean, line_of, quoted};
use rhytid_core::{Bind, Error, FoldStrains, Result, UpAxis};
use std::collections::HashMap;
use std::path::PathBuf;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Checks the text of a project file; `name` names the file in errors.
///
/// # Errors
/// [`Error::Input`]: no TOML, a missing section or key, an unknown key, a value of the wrong type or out of
/// its range, two examples of one name.
pub fn parse(text: &str, name: &str) -> Result<Project> {
    let file = File { text, name };
    let document = DeTable::parse(text).map_err(|e| {
        let reason = e.message().replace('\n', ", ");
        file.error(e.span().map_or(0, |span| span.start), &format!("not TOML: {reason}"))
    })?;
    let root = Section { file, title: String::new(), offset: 0, table: document.get_ref() };
    root.allow(&["method", "mesh", "handles", "example", "large_scale", "strain", "fine_scale", "learned"])?;
    Ok(Project {
        method: method_of(&root)?,
        mesh: mesh(&root.required_section("mesh", "neutral and units")?)?,
        handles: handles(&root.required_section("handles", "vertices")?)?,
        examples: examples(&root)?,
        large_scale: root.section("large_scale")?.map_or_else(|| Ok(<_>::default()), |s| large_scale(&s))?,
        strain: root.section("strain")?.map_or_else(|| Ok(<_>::default()), |s| strain(&s))?,
        fine_scale: root.section("fine_scale")?.map_or_else(|| Ok(<_>::default()), |s| fine_scale(&s))?,
        learned: root.section("learned")?.map_or_else(|| Ok(<_>::default()), |s| learned(&s))?,
    })
}

const METHODS: &str = "\"learned\" or \"chapter\"";

/// The method that the file names, at its top or, as it once was, under `[fine_scale]`.
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

fn learned(section: &Section<'_>) -> Result<LearnedSection> {
    section.allow(&["share", "ridge", "fold_ridge", "marker_noise", "reach", "fold_strains"])?;
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
        ridge: number("ridge", "a number above 0", |ridge| ridge > 0.0)?,
        fold_ridge: number("fold_ridge", "a number above 0", |ridge| ridge > 0.0)?,
        marker_noise: number("marker_noise", "millimetres, a number from 0", |noise| noise >= 0.0)?,
        reach: match section.get("reach") {
            Some(DeValue::Float(number)) if matches!(number.as_str(), "inf" | "+inf") => Some(f64::INFINITY),
            _ => number("reach", "a number from 1, inf for no bound", |reach| reach >= 1.0)?,
        },
        fold_strains: match section.text("fold_strains", "\"vectors\" or \"lengths\"")? {
            None => None,
            Some("vectors") => Some(FoldStrains::Vectors),
            Some("lengths") => Some(FoldStrains::Lengths),
            Some(other) => {
                return Err(section.wrong(
                    "fold_strains",
                    &format!("{other:?}"),
                    "\"vectors\" or \"lengths\"",
                ));
            }
        },
    })
}

fn mesh(section: &Section<'_>) -> Result<MeshSection> {
    section.allow(&["name", "neutral", "units", "up"])?;
    let neutral = section.path("neutral", "the file of the neutral mesh")?;
    let name = section.text("name", "a name")?;
    if let Some(name) = name.filter(|name| name.trim().is_empty()) {
        return Err(section.wrong("name", &quoted(name), "a name that is not empty"));
    }
    let expected = "\"m\", \"cm\", \"mm\", \"in\" or a number above 0, the metres in one mesh unit";
    let units = match section.required("units", expected)? {
        DeValue::String(unit) => match unit.as_ref() {
            "m" => Units::Metres,
            "cm" => Units::Centimetres,
            "mm" => Units::Millimetres,
            "in" => Units::Inches,
            _ => return Err(section.wrong("units", &quoted(unit), expected)),
        },
        _ => Units::MetresPerUnit(section.positive("units", expected)?),
    };
    let up = match section.text("up", "\"y\" or \"z\"")? {
        None => UpAxis::default(),
        Some("y" | "Y") => UpAxis::Y,
        Some("z" | "Z") => UpAxis::Z,
        Some(other) => return Err(section.wrong("up", &quoted(other), "\"y\" or \"z\"")),
    };
    Ok(MeshSection { name: name.map(str::to_owned), neutral, units, up })
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
        section.allow(&["name", "mesh", "mirror"])?;
        let expected = "a name that no other example has";
        let name = match section.text("name", expected)? {
            None => return Err(section.lacks("name", expected)),
            Some(name) if name.trim().is_empty() => {
                return Err(section.wrong("name", &quoted(name), "a name that is not empty"));
            }
            Some(name) => name,
        };
        if let Some(first) = seen.insert(name, section) {
            let line = first.line("name");
            return Err(section.wrong("name", &quoted(name), &format!("{expected}, but see line {line}")));
        }
        let mesh = section.path("mesh", "the file of the example's mesh")?;
        let mirror = match section.get("mirror") {
            None => false,
            Some(DeValue::Boolean(mirror)) => *mirror,
            Some(other) => return Err(section.wrong("mirror", &found(other), "true or false")),
        };
        examples.push(ExampleSection { name: name.to_owned(), mesh, mirror });
    }
    Ok(examples)
}

fn large_scale(section: &Section<'_>) -> Result<LargeScaleSection> {
    section.allow(&["bending_length", "bind"])?;
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
    Ok(LargeScaleSection { bending_length, bind })
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

#[derive(Clone, Copy)]
struct File<'a> {
    text: &'a str,
    name: &'a str,
}

impl File<'_> {
    fn line(&self, offset: usize) -> usize {
        line_of(self.text.as_bytes(), offset)
    }

    fn error(&self, offset: usize, message: &str) -> Error {
        Error::input(format!("{}, line {}: {message}", self.name, self.line(offset)))
    }
}

/// One table of the document.
struct Section<'a> {
    file: File<'a>,
    /// As users write it, `[mesh]`; empty for the document itself.
    title: String,
    offset: usize,
    table: &'a DeTable<'a>,
}

impl<'a> Section<'a> {
    /// Fails at the first key that is not among `known`.
    fn allow(&self, known: &[&str]) -> Result<()> {
        let unknown = self.table.keys().filter(|key| !known.contains(&key.get_ref().as_ref()));
        let Some(key) = unknown.min_by_key(|key| key.span().start) else { return Ok(()) };
        let place = if self.title.is_empty() { "" } else { " in " };
        Err(self.file.error(
            key.span().start,
            &format!(
                "unknown key {}{place}{}{}, expected {}",
                quoted(key.get_ref()),
                self.title,
                did_you_mean(key.get_ref(), known.iter().copied()),
                known.join(", ")
            ),
        ))
    }

    fn entry(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.table.get(key)
    }

    fn get(&self, key: &str) -> Option<&'a DeValue<'a>> {
        self.entry(key).map(Spanned::get_ref)
    }

    fn required(&self, key: &str, expected: &str) -> Result<&'a DeValue<'a>> {
        self.get(key).ok_or_else(|| self.lacks(key, expected))
    }

    fn text(&self, key: &str, expected: &str) -> Result<Option<&'a str>> {
        match self.get(key) {
            None => Ok(None),
            Some(DeValue::String(text)) => Ok(Some(text)),
            Some(other) => Err(self.wrong(key, &found(other), expected)),
        }
    }

    fn path(&self, key: &str, expected: &str) -> Result<PathBuf> {
        match self.text(key, expected)? {
            None => Err(self.lacks(key, expected)),
            Some("") => Err(self.wrong(key, "empty", expected)),
            Some(path) => Ok(PathBuf::from(path)),
        }
    }

    fn positive(&self, key: &str, expected: &str) -> Result<f64> {
        let value = self.required(key, expected)?;
        self.number(key)
            .filter(|number| *number > 0.0)
            .ok_or_else(|| self.wrong(key, &found(value), expected))
    }

    /// A finite number, if that is what the key has.
    fn number(&self, key: &str) -> Option<f64> {
        match self.get(key)? {
            DeValue::Float(number) => number.as_str().parse().ok(),
            DeValue::Integer(n) => i64::from_str_radix(n.as_str(), n.radix()).ok().map(|n| n as f64),
            _ => None,
        }
        .filter(|number: &f64| number.is_finite())
    }

    fn section(&self, key: &str) -> Result<Option<Section<'a>>> {
        let Some(entry) = self.entry(key) else { return Ok(None) };
        match entry.get_ref() {
            DeValue::Table(table) => Ok(Some(self.inner(format!("[{key}]"), entry, table))),
            other => Err(self.wrong(key, &found(other), &format!("a section [{key}]"))),
        }
    }

    fn required_section(&self, key: &str, keys: &str) -> Result<Section<'a>> {
        self.section(key)?.ok_or_else(|| {
            Error::input(format!("{}: has no section [{key}], expected one with {keys}", self.file.name))
        })
    }

    fn sections(&self, key: &str) -> Result<Vec<Section<'a>>> {
        let wrong = |entry: &Spanned<DeValue<'a>>| {
            let expected = format!("[[{key}]] in double brackets, once for each");
            self.file.error(
                entry.span().start,
                &format!("{key} is {}, expected {expected}", found(entry.get_ref())),
            )
        };
        let Some(entry) = self.entry(key) else { return Ok(Vec::new()) };
        let DeValue::Array(items) = entry.get_ref() else { return Err(wrong(entry)) };
        let section = |item: &'a Spanned<DeValue<'a>>| match item.get_ref() {
            DeValue::Table(table) => Ok(self.inner(format!("[[{key}]]"), item, table)),
            _ => Err(wrong(item)),
        };
        items.iter().map(section).collect()
    }

    fn inner(&self, title: String, entry: &Spanned<DeValue<'_>>, table: &'a DeTable<'a>) -> Section<'a> {
        Section { file: self.file, title, offset: entry.span().start, table }
    }

    /// The line of a key's value, or of the section where it lacks the key.
    fn line(&self, key: &str) -> usize {
        self.file.line(self.entry(key).map_or(self.offset, |entry| entry.span().start))
    }

    fn lacks(&self, key: &str, expected: &str) -> Error {
        self.file.error(self.offset, &format!("{} lacks the key {key}, expected {expected}", self.title))
    }

    fn wrong(&self, key: &str, found: &str, expected: &str) -> Error {
        let place = if self.title.is_empty() { String::new() } else { format!("{} ", self.title) };
        let offset = self.entry(key).map_or(self.offset, |entry| entry.span().start);
        self.file.error(offset, &format!("{place}{key} is {found}, expected {expected}"))
    }
}

fn found(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => quoted(text),
        DeValue::Integer(number) => number.to_string(),
        DeValue::Float(number) => number.to_string(),
        DeValue::Boolean(value) => value.to_string(),
        DeValue::Datetime(date) => format!("the date {date}"),
        DeValue::Array(_) => "an array".to_owned(),
        DeValue::Table(_) => "a section".to_owned(),
    }
}
