//! What the shared library exports.
use crate::support::{has, libraries, own, said};
use std::collections::BTreeSet;
use std::process::Command;

/// The functions that the header declares.
fn declared() -> BTreeSet<String> {
    let header = std::fs::read_to_string(own().join("include/rhytid.h")).unwrap();
    let code = header.lines().filter(|line| !line.trim_start().starts_with("//"));
    let names = code.filter_map(|line| {
        let (before, _) = line.split_once('(')?;
        let name = before.rsplit([' ', '*']).next()?;
        name.starts_with("rhytid_").then(|| name.to_owned())
    });
    names.collect()
}

#[test]
fn the_library_exports_what_the_header_declares_and_nothing_else() {
    if !has(&["nm"]) {
        return;
    }
    let library = libraries().join("librhytid_c.so");
    let listed = said(Command::new("nm").args(["-D", "--defined-only", "--format=posix"]).arg(library));
    let exported: BTreeSet<String> =
        listed.lines().filter_map(|line| line.split(' ').next()).map(str::to_owned).collect();
    let declared = declared();
    assert!(declared.len() > 30, "{declared:?}");
    assert_eq!(exported, declared);
}

/// Each function of C is used by the wrapper of C++.
#[test]
fn the_wrapper_has_each_function() {
    let wrapper = std::fs::read_to_string(own().join("include/rhytid.hpp")).unwrap();
    for name in declared() {
        assert!(wrapper.contains(&format!("{name}(")), "rhytid.hpp lacks {name}");
    }
}
