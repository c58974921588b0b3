//! The kernels' folders: their files, and the tables of buffers in their READMEs.
use crate::reflected::compare;
use rhytid_kernels::table::{Access, Entry, Kernel};
use std::fs;
use std::path::Path;

/// The files of a kernel's folder besides Rust.
fn expected_files(name: &str) -> Vec<String> {
    let sources = ["cl", "comp", "spv", "wgsl"].map(|extension| format!("{name}.{extension}"));
    ["README.md".into()].into_iter().chain(sources).collect()
}

/// One sentence for each missing file, and for each file that nothing reads. `root` holds a folder per
/// kernel.
pub(crate) fn files(root: &Path) -> Vec<String> {
    let mut all = Vec::new();
    for kernel in Kernel::ALL.map(Kernel::entry) {
        for name in expected_files(kernel.name) {
            if !root.join(kernel.name).join(&name).is_file() {
                all.push(format!("{}/{name}: missing", kernel.name));
            }
        }
    }
    unread(root, root, &mut all);
    all
}

fn unread(root: &Path, folder: &Path, all: &mut Vec<String>) {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) => return all.push(format!("{}: {e}", folder.display())),
    };
    let mut paths: Vec<_> = entries.filter_map(Result::ok).map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let shown = path.strip_prefix(root).unwrap_or(&path).display().to_string();
        let of_a_kernel = |kernel: &Kernel| {
            let name = kernel.name();
            expected_files(name).iter().any(|file| path == root.join(name).join(file))
        };
        if path.is_dir() {
            unread(root, &path, all);
        } else if !shown.ends_with(".rs") && !Kernel::ALL.iter().any(of_a_kernel) {
            all.push(format!("{shown}: nobody reads this file; remove it, or add its kernel to table.rs"));
        }
    }
}

/// One sentence for each row of the README's table of buffers that differs from the kernel. The row states
/// the name in order, in or out, tiled or not.
pub(crate) fn readme(kernel: &Entry, text: &str) -> Vec<String> {
    let expected = kernel.bindings.iter().map(|binding| {
        let way = match binding.access {
            Access::Read => "in",
            Access::Write => "out",
            Access::ReadWrite => "in and out",
        };
        show(binding.buffer.name(), way, binding.tiled)
    });
    let found = text.lines().filter_map(row);
    compare("row", &found.collect::<Vec<_>>(), &expected.collect::<Vec<_>>())
}

/// ``| `basis` | V × H | in, a ratio; tiled |``
fn row(line: &str) -> Option<String> {
    let cells: Vec<&str> = line.strip_prefix("| `")?.split('|').collect();
    let name = cells.first()?.trim().trim_end_matches('`');
    let mut words = cells.get(2).copied().unwrap_or_default().split([',', ';']).map(str::trim);
    let way = words.next().unwrap_or_default();
    Some(show(name, way, words.any(|word| word == "tiled")))
}

fn show(name: &str, way: &str, tiled: bool) -> String {
    format!("`{name}` ({way}{})", if tiled { ", tiled" } else { "" })
}
