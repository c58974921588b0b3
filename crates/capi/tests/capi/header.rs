//! `include/rhytid.h` is what cbindgen makes of the sources.
use crate::support::own;
use std::path::PathBuf;

/// The sources in the order of the header.
const SOURCES: [&str; 8] = [
    "version.rs",
    "status.rs",
    "enums.rs",
    "rig.rs",
    "take.rs",
    "devices.rs",
    "animator.rs",
    "vulkan/mod.rs",
];

fn generated() -> String {
    let config = cbindgen::Config::from_file(own().join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    for source in SOURCES {
        builder = builder.with_src(own().join("src").join(source));
    }
    let mut bytes = Vec::new();
    builder.generate().unwrap().write(&mut bytes);
    without_rust(&String::from_utf8(bytes).unwrap())
}

/// Leaves out the sections that say what a caller from Rust guarantees. C programs have the text above them.
fn without_rust(header: &str) -> String {
    let mut lines: Vec<&str> = Vec::new();
    let mut is_left_out = false;
    for line in header.lines() {
        let comment = line.trim_start().starts_with("//");
        if line.trim() == "// # Safety" {
            is_left_out = true;
            // The empty line above it.
            lines.pop_if(|line| line.trim() == "//");
        }
        is_left_out &= comment;
        if !is_left_out {
            lines.push(line);
        }
    }
    lines.join("\n") + "\n"
}

#[test]
fn the_header_is_made_from_the_sources() {
    let (header, generated) = (own().join("include/rhytid.h"), generated());
    if std::fs::read_to_string(&header).unwrap_or_default() != generated {
        let fresh = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("rhytid.h");
        std::fs::write(&fresh, generated).unwrap();
        panic!("{} is stale: copy {} over it", header.display(), fresh.display());
    }
}

/// What every name begins with.
#[test]
fn every_name_is_rhytids() {
    let header = std::fs::read_to_string(own().join("include/rhytid.h")).unwrap();
    let code: String =
        header.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    let own = |name: &str| ["rhytid_", "Rhytid", "RHYTID_"].iter().any(|prefix| name.starts_with(prefix));
    for word in ["#define ", "enum ", "struct "] {
        for (i, _) in code.match_indices(word) {
            let name: String =
                code[i + word.len()..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            assert!(own(&name), "{word}{name}");
        }
    }
    for text in
        ["rhytid_abi_version", "RHYTID_ABI_VERSION 1", "RHYTID_MISSING_HOLD", "RHYTID_BASIS_CLUSTERED"]
    {
        assert!(code.contains(text), "{text}");
    }
}
