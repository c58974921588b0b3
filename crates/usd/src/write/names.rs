//! Names of prims.
use crate::layer::Value;
use std::collections::HashSet;

/// The field with the name that people gave, where a prim may not be called so.
pub(super) fn display_name(identifier: &str, original: &str) -> Option<(String, Value)> {
    let is_other = identifier != original && !original.is_empty();
    is_other.then(|| ("displayName".into(), Value::String(original.into())))
}

/// `name` as a prim may be called in every version of USD: ASCII letters, digits and underscores, not
/// beginning with a digit.
pub(super) fn identifier(name: &str) -> String {
    let mut identifier: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if identifier.chars().next().is_none_or(|c| c.is_ascii_digit()) {
        identifier.insert(0, '_');
    }
    identifier
}

/// An identifier for each name, all different. Names with equal identifiers get a number, except for the
/// first.
pub(super) fn identifiers<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let wanted: Vec<String> = names.map(identifier).collect();
    // A numbered identifier never takes one that another name wants without a number.
    let mut taken: HashSet<String> = wanted.iter().cloned().collect();
    let mut seen = HashSet::new();
    wanted
        .into_iter()
        .map(|name| {
            if seen.insert(name.clone()) {
                return name;
            }
            let free = (1_u64..).map(|n| format!("{name}_{n}")).find(|other| !taken.contains(other));
            let free = free.unwrap_or(name);
            taken.insert(free.clone());
            free
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_identifiers_are_the_same() {
        let names = ["lip s", "lip-s", "lip_s_1", "lip_s", "", "1", "_1", "Zoë"];
        let expected = ["lip_s", "lip_s_2", "lip_s_1", "lip_s_3", "_", "_1", "_1_1", "Zo_"];
        assert_eq!(identifiers(names.into_iter()), expected);
    }
}
