//! The names that JavaScript and its types have for the library's choices. They are made from the library's
//! own lists, so that a new choice cannot be in one of them alone.
use rhytid_core::{BasisStorage, Error, InputErrorKind, Missing, Result, Stage};
use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::{Error as ValueError, StrDeserializer};
use std::fmt::Debug;

/// A list of names.
struct Choice {
    /// What the list is called in JavaScript.
    list: &'static str,
    /// What TypeScript calls one of them.
    name: &'static str,
    /// What they are, for the types' documentation.
    about: &'static str,
    names: Vec<&'static str>,
    /// What the option with such a name is called.
    option: &'static str,
    default: &'static str,
}

fn choices() -> [Choice; 3] {
    [
        Choice {
            list: "STAGES",
            name: "Stage",
            about: "What `face.read` gives: the results of a frame, in the order in which they are computed.",
            names: Stage::ALL.map(Stage::name).to_vec(),
            option: "stage",
            default: Stage::Positions.name(),
        },
        Choice {
            list: "MISSING",
            name: "Missing",
            about: "What to do where a marker is missing from a frame of a take.",
            names: missing().map(Missing::name).collect(),
            option: "missing",
            default: Missing::default().name(),
        },
        Choice {
            list: "BASIS_STORAGES",
            name: "BasisStorage",
            about: "How the basis is kept, by far the largest part of a rig.",
            names: BasisStorage::ALL.map(BasisStorage::name).to_vec(),
            option: "basis",
            default: BasisStorage::default().name(),
        },
    ]
}

/// The policies with which a take can be played: those that files can name.
fn missing() -> impl Iterator<Item = Missing> + Clone {
    Missing::ALL.into_iter().filter(|missing| {
        let name: StrDeserializer<'_, ValueError> = missing.name().into_deserializer();
        Missing::deserialize(name).is_ok()
    })
}

/// `names.js` of the package.
pub fn javascript() -> String {
    let mut text = "// Made by `cargo xtask player` from the library's own lists.\n".to_owned();
    for Choice { list, names, .. } in choices() {
        text += &format!("export const {list} = Object.freeze({names:?});\n");
    }
    let defaults = choices().map(|choice| format!("{}: {:?}", choice.option, choice.default));
    text + &format!("export const DEFAULTS = Object.freeze({{ {} }});\n", defaults.join(", "))
}

/// `names.d.ts` of the package.
pub fn types() -> String {
    let mut text = "// Made by `cargo xtask player` from the library's own lists.\n".to_owned();
    for Choice { list, name, about, names, .. } in choices() {
        text += &format!("/** {about} */\nexport declare const {list}: readonly {names:?};\n");
        text += &format!("export type {name} = (typeof {list})[number];\n");
    }
    let defaults = choices().map(|choice| format!("readonly {}: {}", choice.option, choice.name));
    text + &format!(
        "/** What is taken where nothing is said. */\nexport declare const DEFAULTS: {{ {} }};\n",
        defaults.join("; ")
    )
}

/// The stage with this name.
///
/// # Errors
/// [`Error::Input`] lists the names.
pub fn stage_named(name: &str) -> Result<Stage> {
    named("stage", name, Stage::ALL.into_iter(), Stage::name)
}

/// The policy for missing markers with this name.
///
/// # Errors
/// [`Error::Input`] lists the names.
pub fn missing_named(name: &str) -> Result<Missing> {
    named("policy for missing markers", name, missing(), Missing::name)
}

/// The way to keep the basis with this name.
///
/// # Errors
/// [`Error::Input`] lists the names.
pub fn basis_named(name: &str) -> Result<BasisStorage> {
    named("storage of the basis", name, BasisStorage::ALL.into_iter(), BasisStorage::name)
}

fn named<T: Copy>(
    what: &str,
    name: &str,
    all: impl Iterator<Item = T> + Clone,
    name_of: impl Fn(T) -> &'static str,
) -> Result<T> {
    all.clone().find(|one| name_of(*one) == name).ok_or_else(|| {
        let names: Vec<&str> = all.map(name_of).collect();
        let sentence = format!("there is no {what} “{name}”, expected one of {}", names.join(", "));
        Error::input(sentence).of_kind(InputErrorKind::UnknownName { name: name.to_owned() })
    })
}

/// The kind of an error, as JavaScript tells errors apart: the name of the library's variant.
pub fn kind_of(error: &Error) -> String {
    match error {
        Error::Input(input) => variant(input.kind()),
        Error::Device { kind, .. } => variant(kind),
        other => variant(other),
    }
}

/// The name of an enumeration's variant, without its fields.
fn variant(value: &impl Debug) -> String {
    let text = format!("{value:?}");
    text.split(|c: char| !c.is_ascii_alphanumeric()).next().unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lists_are_the_library_s() {
        let javascript = javascript();
        for stage in Stage::ALL {
            assert!(javascript.contains(&format!("{:?}", stage.name())), "{javascript}");
            assert_eq!(stage_named(stage.name()).unwrap(), stage);
        }
        assert!(javascript.contains(r#"MISSING = Object.freeze(["error", "hold"])"#), "{javascript}");
        assert!(javascript.contains(r#"["f32", "f16", "clustered"]"#), "{javascript}");
        assert!(javascript.contains(r#"stage: "positions", missing: "error", basis: "f32""#));
        let types = types();
        assert!(types.contains(r#"MISSING: readonly ["error", "hold"];"#), "{types}");
    }

    #[test]
    fn an_unknown_name_is_told_the_known_ones() {
        let error = missing_named("leave").unwrap_err();
        assert_eq!(
            error.to_string(),
            "there is no policy for missing markers “leave”, expected one of error, hold"
        );
        assert_eq!(kind_of(&error), "UnknownName");
        assert_eq!(kind_of(&Error::Internal("x".into())), "Internal");
        assert_eq!(kind_of(&Error::too_large("x")), "TooLarge");
        assert!(stage_named("").is_err() && basis_named("f64").is_err());
    }
}
