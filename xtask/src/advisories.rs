//! The lock files beside `xtask/advisories.toml`, what the advisory database has on their crates: the database is out of reach for many
//! a machine on which the tests run, and a lock file can be compared with a copy anywhere.

use crate::run::{Result, root};
use semver::{Version, VersionReq};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use toml::value::Datetime;

const TABLE: &str = "xtask/advisories.toml";
const LOCKS: [&str; 2] = ["Cargo.lock", "fuzz/Cargo.lock"];

/// `xtask/advisories.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    newest: Datetime,
    looked_up: BTreeSet<String>,
    #[serde(rename = "advisory")]
    advisories: Vec<Advisory>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Advisory {
    id: String,
    #[serde(rename = "crate")]
    name: String,
    date: Datetime,
    kind: Kind,
    patched: Vec<VersionReq>,
    #[serde(default)]
    unaffected: Vec<VersionReq>,
    about: String,
}

#[derive(Deserialize, Debug, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Vulnerability,
    Unsound,
    Unmaintained,
}

/// Of `deny.toml`, what cargo-deny and this file both go by.
#[derive(Deserialize)]
struct Deny {
    advisories: Policy,
}

#[derive(Deserialize)]
struct Policy {
    ignore: Vec<Ignored>,
}

#[derive(Deserialize)]
struct Ignored {
    id: String,
}

/// Of a `Cargo.lock`, the packages.
#[derive(Deserialize)]
struct Lock {
    package: Vec<Package>,
}

#[derive(Deserialize)]
struct Package {
    name: String,
    version: Version,
    /// Where it is from; nothing for our own.
    source: Option<String>,
}

/// Compares the lock files with the table, and says how old that is.
///
/// # Errors
/// What is known of a crate and not ignored in `deny.toml`, and crates that were never looked up, each in a line.
pub(crate) fn lock_files() -> Result {
    let table: Table = read(TABLE)?;
    let deny: Deny = read("deny.toml")?;
    let ignored: Vec<&str> = deny.advisories.ignore.iter().map(|ignored| ignored.id.as_str()).collect();
    let mut problems = Vec::new();
    for path in LOCKS {
        problems.extend(table.problems(&ignored, path, &read(path)?));
    }
    if !problems.is_empty() {
        return Err(problems.join("\nerror: "));
    }
    println!(
        "{}: nothing in {TABLE}, whose newest date is {}, but what deny.toml ignores ({})",
        LOCKS.join(", "),
        table.newest,
        ignored.join(", ")
    );
    Ok(())
}

fn read<T: DeserializeOwned>(path: &str) -> Result<T> {
    let text = std::fs::read_to_string(root().join(path)).map_err(|e| format!("{path}: {e}"))?;
    toml::from_str(&text).map_err(|e| format!("{path}: {e}"))
}

impl Table {
    /// What is wrong with the crates of `lock`, the file at `path`: a sentence each.
    fn problems(&self, ignored: &[&str], path: &str, lock: &Lock) -> Vec<String> {
        let foreign = || lock.package.iter().filter(|package| package.source.is_some());
        let known = foreign().flat_map(|package| {
            self.advisories.iter().filter(|advisory| advisory.is_about(package)).map(move |a| (package, a))
        });
        let known = known.filter(|(_, advisory)| !ignored.contains(&advisory.id.as_str()));
        let mut problems: Vec<String> = known.map(|(package, a)| a.sentence(path, package)).collect();
        let new: BTreeSet<&str> =
            foreign().map(|p| p.name.as_str()).filter(|name| !self.looked_up.contains(*name)).collect();
        if !new.is_empty() {
            problems.push(format!(
                "{path}: nobody has looked for advisories on {}: see https://rustsec.org/packages/NAME.html (no such page means that \
                 there are none), and enter the name and what you find in {TABLE}",
                Vec::from_iter(new).join(", ")
            ));
        }
        problems
    }
}

impl Advisory {
    /// Whether this version has what it is about.
    fn is_about(&self, package: &Package) -> bool {
        let is_in = |ranges: &[VersionReq]| ranges.iter().any(|range| range.matches(&package.version));
        self.name == package.name && !is_in(&self.patched) && !is_in(&self.unaffected)
    }

    fn sentence(&self, path: &str, package: &Package) -> String {
        let Package { name, version, .. } = package;
        let remedy = match &self.patched[..] {
            [] => "no version is without it: replace the crate".to_owned(),
            patched => {
                let patched: Vec<String> = patched.iter().map(ToString::to_string).collect();
                format!("`cargo update -p {name}@{version}` to {}", patched.join(" or "))
            }
        };
        let Self { id, date, kind, about, .. } = self;
        let kind = match kind {
            Kind::Vulnerability => "a vulnerability",
            Kind::Unsound => "unsound",
            Kind::Unmaintained => "unmaintained",
        };
        format!(
            "{path}: {name} {version} is {kind} ({id} of {date}: {about}): {remedy}, or say under [advisories] ignore in deny.toml why \
             it does no harm"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MADE_UP: &str = r#"
        newest = 2026-07-18
        looked_up = ["torn", "worn", "fine"]
        [[advisory]]
        id = "RUSTSEC-2025-0001"
        crate = "torn"
        date = 2025-01-02
        kind = "vulnerability"
        patched = [">= 1.4.2, < 2.0.0", ">= 2.1.0"]
        unaffected = ["< 1.2.0"]
        about = "it tears"
        [[advisory]]
        id = "RUSTSEC-2025-0002"
        crate = "worn"
        date = 2025-03-04
        kind = "unmaintained"
        patched = []
        about = "nobody mends it"
    "#;

    fn problems(packages: &[(&str, &str)], ignored: &[&str]) -> Vec<String> {
        let package = |(name, version): &(&str, &str)| {
            format!("[[package]]\nname = \"{name}\"\nversion = \"{version}\"\nsource = \"registry\"\n")
        };
        let own = "[[package]]\nname = \"our-own\"\nversion = \"0.1.0\"\n";
        let lock: String = packages.iter().map(package).chain([own.to_owned()]).collect();
        let table: Table = toml::from_str(MADE_UP).unwrap();
        table.problems(ignored, "Cargo.lock", &toml::from_str(&lock).unwrap())
    }

    #[test]
    fn a_version_is_hit_unless_it_is_patched_or_was_never_affected() {
        for (version, is_hit) in [
            ("1.1.9", false),
            ("1.2.0", true),
            ("1.4.1", true),
            ("1.4.2", false),
            ("1.9.0+build.7", false),
            ("2.0.5", true),
            ("2.1.0", false),
            // No range has what comes before a release, unless it says so.
            ("2.1.0-rc.1", true),
        ] {
            let found = problems(&[("torn", version), ("fine", version)], &[]);
            assert_eq!(found.len(), usize::from(is_hit), "{version}: {found:?}");
        }
        let found = problems(&[("torn", "2.0.5"), ("torn", "1.1.0")], &[]);
        assert_eq!(
            found,
            [
                "Cargo.lock: torn 2.0.5 is a vulnerability (RUSTSEC-2025-0001 of 2025-01-02: it tears): `cargo update -p torn@2.0.5` to \
              >=1.4.2, <2.0.0 or >=2.1.0, or say under [advisories] ignore in deny.toml why it does no harm"
            ]
        );
    }

    #[test]
    fn what_is_ignored_is_ignored_alone() {
        let lock = [("torn", "1.3.0"), ("worn", "7.0.0")];
        assert_eq!(problems(&lock, &[]).len(), 2);
        let [found] = &problems(&lock, &["RUSTSEC-2025-0001"])[..] else { panic!("one is left") };
        assert!(
            found.contains("worn 7.0.0 is unmaintained") && found.contains("replace the crate"),
            "{found}"
        );
        assert!(problems(&lock, &["RUSTSEC-2025-0001", "RUSTSEC-2025-0002"]).is_empty());
    }

    #[test]
    fn a_crate_that_nobody_has_looked_up_is_said_once_and_our_own_are_not() {
        let [found] = &problems(&[("new", "0.1.0"), ("newer", "1.0.0"), ("new", "2.0.0")], &[])[..] else {
            panic!("one sentence")
        };
        assert!(found.contains("advisories on new, newer: see https://rustsec.org"), "{found}");
    }

    #[test]
    fn the_table_is_sound_and_the_lock_files_pass() {
        let table: Table = read(TABLE).unwrap();
        let ids: BTreeSet<&str> = table.advisories.iter().map(|advisory| advisory.id.as_str()).collect();
        assert_eq!(ids.len(), table.advisories.len(), "an advisory is listed twice");
        for advisory in &table.advisories {
            assert!(table.looked_up.contains(&advisory.name), "{} is not looked up", advisory.name);
            assert!(
                advisory.date.to_string() <= table.newest.to_string(),
                "{}: {}",
                advisory.id,
                advisory.date
            );
        }
        lock_files().unwrap();
    }
}
