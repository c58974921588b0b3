//! The text of a file of edits to [`Edits`]: keys, types and values are checked, files are not touched.

use super::{Added, Correction, Curve, Ease, Edits, Gain, Hold, Offset, Region};
use crate::document::{File, Section, found, number_of, tables, vector_of};
use rhytid_core::text::quoted;
use rhytid_core::{InputErrorKind, Result};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use toml::de::DeValue;

/// By how much markers' displacements can be multiplied.
const GAINS: RangeInclusive<f64> = 0.0..=10.0;
/// By how much wrinkles can.
const DETAIL_GAINS: RangeInclusive<f64> = 0.0..=2.0;
const AMOUNTS: RangeInclusive<f64> = -10.0..=10.0;
const FRAME: &str = "a frame of the take, counted from 0";
/// The longest movement; a longer one is in another unit.
const LONGEST_OFFSET: f64 = 1_000.0;

/// Checks the text of a file of edits; `name` names the file in errors.
///
/// # Errors
/// [`Error::Input`](rhytid_core::Error::Input): no TOML, an unknown or missing key, a value of the wrong type
/// or out of its range.
pub fn parse(text: &str, name: &str) -> Result<Edits> {
    let document = tables(text, name)?;
    let file = File { text, name };
    let root = Section { file, title: String::new(), offset: 0, table: document.get_ref() };
    root.allow(&["region", "gain", "offset", "add", "hold", "detail", "correction"])?;
    let gains = |key: &str, range: &RangeInclusive<f64>| -> Result<Vec<Gain>> {
        root.sections(key)?.iter().map(|section| gain(section, range)).collect()
    };
    Ok(Edits {
        regions: regions(&root)?,
        gains: gains("gain", &GAINS)?,
        offsets: root.sections("offset")?.iter().map(offset).collect::<Result<_>>()?,
        added: root.sections("add")?.iter().map(added).collect::<Result<_>>()?,
        holds: root.sections("hold")?.iter().map(hold).collect::<Result<_>>()?,
        corrections: root.sections("correction")?.iter().map(correction).collect::<Result<_>>()?,
        details: gains("detail", &DETAIL_GAINS)?,
    })
}

fn regions(root: &Section<'_>) -> Result<BTreeMap<String, Region>> {
    let Some(all) = root.section("region")? else { return Ok(BTreeMap::new()) };
    let region = |name: &str| {
        let expected = format!("a section [region.{name}] with markers, groups or weights");
        match all.entry(name).map(|entry| (entry, entry.get_ref())) {
            Some((entry, DeValue::Table(table))) => {
                region(&all.inner(format!("[region.{name}]"), entry, table))
            }
            other => {
                Err(all.wrong(name, &other.map_or_else(String::new, |(_, value)| found(value)), &expected))
            }
        }
    };
    all.table.keys().map(|name| Ok((name.get_ref().to_string(), region(name.get_ref())?))).collect()
}

fn region(section: &Section<'_>) -> Result<Region> {
    section.allow(&["markers", "groups", "of", "weights", "property"])?;
    let path = |key: &str, expected: &str| match section.get(key) {
        None => Ok(None),
        Some(_) => section.path(key, expected).map(Some),
    };
    let region = Region {
        markers: section.texts("markers", "a list of labels of handles, such as [\"chin\", \"lip_*\"]")?,
        groups: section.texts("groups", "a list of names of groups")?,
        of: path("of", "the .obj with the groups")?,
        weights: path("weights", "the .ply or .usd with painted vertices")?,
        property: section.text("property", "the name of a property of the vertices")?.map(str::to_owned),
    };
    let kinds = [!region.markers.is_empty(), !region.groups.is_empty(), region.weights.is_some()];
    let kinds = kinds.into_iter().filter(|is| *is).count();
    if kinds != 1 {
        let found = if kinds == 0 { "has none" } else { "has several" };
        return Err(section
            .error(&format!("{found} of markers, groups and weights, expected one of them"))
            .of_kind(InputErrorKind::Conflict));
    }
    for (key, is_there, partner, is_partner_there) in [
        ("of", region.of.is_some(), "groups", !region.groups.is_empty()),
        ("property", region.property.is_some(), "weights", region.weights.is_some()),
    ] {
        if is_partner_there && !is_there {
            return Err(section.lacks(key, &format!("one beside {partner}")));
        }
        if is_there && !is_partner_there {
            return Err(section
                .error(&format!("has {key} without {partner}; leave it out"))
                .of_kind(InputErrorKind::Conflict));
        }
    }
    Ok(region)
}

fn gain(section: &Section<'_>, range: &RangeInclusive<f64>) -> Result<Gain> {
    section.allow(&["region", "by", "ease"])?;
    section.required("by", &curves(range))?;
    let ease = ease(section)?;
    Ok(Gain { region: name_of(section)?, by: curve(section, "by", range, ease)?, ease })
}

fn offset(section: &Section<'_>) -> Result<Offset> {
    section.allow(&["region", "millimetres", "markers", "amount", "ease"])?;
    let expected = format!("[x, y, z] along the mesh's axes, at most {LONGEST_OFFSET} mm");
    let is_short = |x: &[f64; 3]| x.iter().all(|x| x.abs() <= LONGEST_OFFSET);
    let millimetres = section.vector("millimetres", &expected)?;
    if let Some(long) = millimetres.filter(|x| !is_short(x)) {
        return Err(section.wrong("millimetres", &format!("{long:?}"), &expected));
    }
    let of_each = "a table of labels and millimetres, { chin = [0, -2, 0] }";
    let markers = match section.get("markers") {
        None => BTreeMap::new(),
        Some(DeValue::Table(table)) => table
            .iter()
            .map(|(label, value)| {
                let by = vector_of(value.get_ref()).filter(is_short);
                let what = || format!("{} for {}", found(value.get_ref()), quoted(label.get_ref()));
                by.map(|by| (label.get_ref().to_string(), by))
                    .ok_or_else(|| section.wrong("markers", &what(), &expected))
            })
            .collect::<Result<_>>()?,
        Some(other) => return Err(section.wrong("markers", &found(other), of_each)),
    };
    if millimetres.is_some() != markers.is_empty() {
        return Err(section.error(
            "needs one of two: millimetres = [x, y, z] for all of its region, or markers = { chin = [x, y, z] } for each",
        ).of_kind(InputErrorKind::Conflict));
    }
    let region = name_of(section)?;
    if region.is_some() && millimetres.is_none() {
        return Err(section
            .error("names a region and its markers, too; leave the region out")
            .of_kind(InputErrorKind::Conflict));
    }
    let ease = ease(section)?;
    Ok(Offset { region, millimetres, markers, amount: curve(section, "amount", &AMOUNTS, ease)?, ease })
}

fn added(section: &Section<'_>) -> Result<Added> {
    section.allow(&["take", "frame", "region", "amount", "ease"])?;
    let take: PathBuf = section.path("take", "the file of another take")?;
    let frame = match section.get("frame") {
        None => 0.0,
        Some(value) => section
            .number("frame")
            .ok_or_else(|| section.wrong("frame", &found(value), "a frame of this take"))?,
    };
    let ease = ease(section)?;
    let amount = curve(section, "amount", &AMOUNTS, ease)?;
    Ok(Added { take, frame, region: name_of(section)?, amount, ease })
}

fn hold(section: &Section<'_>) -> Result<Hold> {
    section.allow(&["region", "frames", "at", "ease"])?;
    let expected = "\"A..B\", frames counted from 0, B not included";
    let text = section.text("frames", expected)?.ok_or_else(|| section.lacks("frames", expected))?;
    let number = |text: &str| text.trim().parse::<usize>().ok();
    let frames = text.split_once("..").and_then(|(a, b)| number(a).zip(number(b))).filter(|(a, b)| a < b);
    let (start, end) = frames.ok_or_else(|| section.wrong("frames", &quoted(text), expected))?;
    Ok(Hold {
        region: name_of(section)?,
        frames: start..end,
        at: section.whole("at", FRAME)?,
        ease: section.whole("ease", "a whole number of frames")?.unwrap_or_default(),
    })
}

fn correction(section: &Section<'_>) -> Result<Correction> {
    section.allow(&["mesh", "frame", "region", "amount", "ease", "reach"])?;
    let ease = ease(section)?;
    let expected = "a number above 0: strains farther away change nothing";
    Ok(Correction {
        mesh: section.path("mesh", "the file of the sculpted mesh")?,
        frame: section
            .whole("frame", FRAME)?
            .ok_or_else(|| section.lacks("frame", "the one that was sculpted"))?,
        region: name_of(section)?,
        amount: curve(section, "amount", &AMOUNTS, ease)?,
        ease,
        reach: match section.get("reach") {
            None => None,
            Some(_) => Some(section.positive("reach", expected)?),
        },
    })
}

fn name_of(section: &Section<'_>) -> Result<Option<String>> {
    Ok(section.text("region", "the name of a region, or of a handle")?.map(str::to_owned))
}

fn ease(section: &Section<'_>) -> Result<Ease> {
    let expected = "\"smooth\", \"linear\" or \"step\"";
    match section.text("ease", expected)? {
        None => Ok(Ease::default()),
        Some("smooth") => Ok(Ease::Smooth),
        Some("linear") => Ok(Ease::Linear),
        Some("step") => Ok(Ease::Step),
        Some(other) => Err(section.wrong("ease", &quoted(other), expected)),
    }
}

/// The value of a key; 1 if the key is missing.
fn curve(section: &Section<'_>, key: &str, range: &RangeInclusive<f64>, ease: Ease) -> Result<Curve> {
    let Some(value) = section.get(key) else { return Ok(Curve::constant(1.0)) };
    let wrong = |what: &str| section.wrong(key, what, &curves(range));
    let is_right = |x: &f64| range.contains(x);
    if let Some(number) = number_of(value) {
        return match is_right(&number) {
            // The easing of a constant curve is kept, because it is in the file.
            true => Ok(Curve { keys: vec![(0.0, number)], ease }),
            false => Err(wrong(&found(value))),
        };
    }
    let DeValue::Array(items) = value else { return Err(wrong(&found(value))) };
    let pair = |item: &DeValue<'_>| match item {
        DeValue::Array(pair) => match &pair[..] {
            [frame, value] => number_of(frame.get_ref()).zip(number_of(value.get_ref()).filter(is_right)),
            _ => None,
        },
        _ => None,
    };
    let mut keys: Vec<(f64, f64)> = Vec::with_capacity(items.len());
    for (i, item) in items.iter().enumerate() {
        let key = pair(item.get_ref())
            .ok_or_else(|| wrong(&format!("a list whose entry {} is not [frame, number]", i + 1)))?;
        if let Some(before) = keys.last().filter(|before| before.0 >= key.0) {
            return Err(wrong(&format!("a list in which frame {} comes behind frame {}", key.0, before.0)));
        }
        keys.push(key);
    }
    if keys.is_empty() { Err(wrong("an empty list")) } else { Ok(Curve { keys, ease }) }
}

fn curves(range: &RangeInclusive<f64>) -> String {
    let (low, high) = (range.start(), range.end());
    format!("a number from {low} to {high}, or keys, [[frame, number], …] with rising frames")
}
