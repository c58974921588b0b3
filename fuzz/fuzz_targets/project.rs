//! Any text as a project file gives a project with sound values, or an error.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_core::Error;
use rhytid_formats::project::parse;
use std::collections::HashSet;

fuzz_target!(|text: &str| match parse(text, "fuzz") {
    Ok(project) => {
        let metres = project.mesh.units.metres_per_unit();
        assert!(metres.is_finite() && metres > 0.0);
        assert!(project.large_scale.bending_length.is_none_or(|l| l.is_finite() && l > 0.0));
        assert!(project.fine_scale.max_influences >= 1);
        let names: HashSet<_> = project.examples.iter().map(|example| &example.name).collect();
        assert_eq!(names.len(), project.examples.len());
    }
    Err(Error::Input(sentence)) => assert!(sentence.sentence().starts_with("fuzz"), "{sentence}"),
    Err(other) => panic!("expected an input error, found {other:?}"),
});
