//! The tests that SECURITY.md names for its promises are there.

use std::path::Path;

#[test]
fn each_promise_has_its_tests() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let page = std::fs::read_to_string(root.join("SECURITY.md")).unwrap();
    let (_, section) = page.split_once("### Each promise and its tests").unwrap();
    let section = section.split("\n## ").next().unwrap();
    let program = root.join("crates/cli/tests/program");
    let mut rows = 0;
    for row in section.lines().filter(|line| line.starts_with("| ") && line.contains("::")) {
        rows += 1;
        for name in row.split('`').skip(1).step_by(2).filter(|name| name.contains("::")) {
            let (module, test) = name.split_once("::").unwrap();
            let files = [program.join(format!("{module}.rs")), program.join(module).join("mod.rs")];
            let text = files.iter().find_map(|file| std::fs::read_to_string(file).ok());
            let text = text.unwrap_or_else(|| panic!("SECURITY.md: there is no file of {name}"));
            assert!(text.contains(&format!("#[test]\nfn {test}(")), "SECURITY.md: there is no test {name}");
        }
    }
    let rows_of_table = section.lines().filter(|line| line.starts_with("| ")).count();
    assert_eq!(rows, rows_of_table - 2, "each row of the table names a test");
}
