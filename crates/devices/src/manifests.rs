//! The manifests of installed drivers, by the conventions of the loaders of Vulkan, OpenCL and EGL.

use std::ffi::{OsStr, OsString};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

const VULKAN: [&str; 3] = ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
const OPENCL: &str = "/etc/OpenCL/vendors";
/// Other folders that make a difference.
const FURTHER: [&str; 4] = [
    "/usr/share/vulkan/implicit_layer.d",
    "/etc/vulkan/implicit_layer.d",
    "/usr/share/glvnd/egl_vendor.d",
    "/etc/glvnd/egl_vendor.d",
];

/// Vulkan's loader uses the first of these that is set instead of its folders. Older loaders know only the
/// second.
const VULKAN_FILES: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];
/// Used in addition to its folders, if none of those is set.
const VULKAN_ADDED: &str = "VK_ADD_DRIVER_FILES";
const OPENCL_FOLDER: &str = "OCL_ICD_VENDORS";
/// Other variables that make a difference.
const VARIABLES: [&str; 5] = [
    "VK_LOADER_DRIVERS_DISABLE",
    "VK_LOADER_DRIVERS_SELECT",
    "VK_INSTANCE_LAYERS",
    "OCL_ICD_FILENAMES",
    "__EGL_VENDOR_LIBRARY_FILENAMES",
];

/// The manifests of a backend's drivers.
pub(crate) fn drivers(backend: &str) -> Vec<PathBuf> {
    drivers_by(backend, |name| std::env::var_os(name))
}

/// As [`drivers`], given the environment.
fn drivers_by(backend: &str, variable: impl Fn(&str) -> Option<OsString>) -> Vec<PathBuf> {
    let named = |name: &str| variable(name).map(|paths| std::env::split_paths(&paths).collect());
    let (places, ending): (Vec<PathBuf>, _) = match backend {
        "vulkan" => {
            let home = || Some(PathBuf::from(variable("HOME")?).join(".local/share"));
            let own = variable("XDG_DATA_HOME").map(PathBuf::from).or_else(home);
            let own = own.map(|data| data.join("vulkan/icd.d"));
            let found = || VULKAN.iter().map(PathBuf::from).chain(own);
            let added = || named(VULKAN_ADDED).unwrap_or_default();
            let named = VULKAN_FILES.iter().find_map(|name| named(name));
            (named.unwrap_or_else(|| found().chain(added()).collect()), "json")
        }
        "opencl" => (named(OPENCL_FOLDER).unwrap_or_else(|| vec![OPENCL.into()]), "icd"),
        _ => return Vec::new(),
    };
    let mut files: Vec<PathBuf> = places
        .into_iter()
        .flat_map(|place| match std::fs::read_dir(&place) {
            Ok(entries) => entries.flatten().map(|entry| entry.path()).collect(),
            Err(_) => vec![place],
        })
        .filter(|file| file.extension() == Some(OsStr::new(ending)))
        .collect();
    files.sort();
    files.dedup();
    files
}

/// The variables that make a loader see only this driver.
pub(crate) fn alone<'a>(backend: &str, driver: &'a Path) -> Vec<(&'static str, &'a Path)> {
    match backend {
        "vulkan" => VULKAN_FILES.iter().map(|name| (*name, driver)).collect(),
        _ => vec![(OPENCL_FOLDER, driver)],
    }
}

/// How to avoid these drivers.
pub(crate) fn remedy(backend: &str, drivers: &[&PathBuf]) -> String {
    if backend == "vulkan" {
        let names: Vec<String> =
            drivers.iter().filter_map(|driver| Some(driver.file_name()?.display().to_string())).collect();
        format!("remove or update it, or turn it off with VK_LOADER_DRIVERS_DISABLE={}", names.join(","))
    } else {
        "remove or update it".into()
    }
}

/// The drivers that are installed now, with the time of each. While this text stays the same, the drivers
/// behave the same.
pub(crate) fn installed() -> String {
    let mut text = String::new();
    for variable in VULKAN_FILES.iter().chain([&VULKAN_ADDED, &OPENCL_FOLDER]).chain(&VARIABLES) {
        if let Some(value) = std::env::var_os(variable) {
            let _ = write!(text, "{variable}={} ", value.display());
        }
    }
    let mut files: Vec<PathBuf> = ["vulkan", "opencl"].iter().flat_map(|backend| drivers(backend)).collect();
    let entries = FURTHER.iter().filter_map(|folder| std::fs::read_dir(folder).ok());
    files.extend(entries.flatten().flatten().map(|entry| entry.path()));
    files.sort();
    for file in files {
        let changed = file.metadata().and_then(|found| found.modified()).ok();
        let seconds =
            changed.and_then(|time| time.duration_since(UNIX_EPOCH).ok()).map_or(0, |time| time.as_secs());
        let _ = write!(text, "{}@{seconds} ", file.display());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drivers_are_where_the_loader_finds_them() {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join(".local/share/vulkan/icd.d");
        std::fs::create_dir_all(&folder).unwrap();
        let own = folder.join("own.json");
        std::fs::write(&own, "{}").unwrap();
        std::fs::write(folder.join("notes.txt"), "").unwrap();
        let found = |set: &[(&str, &str)]| {
            let home = ("HOME", home.path().to_str().unwrap());
            let set: Vec<_> = set.iter().chain([&home]).collect();
            drivers_by("vulkan", |name| set.iter().find(|(n, _)| *n == name).map(|(_, value)| value.into()))
        };
        let usual = found(&[("XDG_DATA_HOME", "/nowhere")]);
        assert!(!usual.contains(&own));
        let with = |further: &[&Path]| {
            let mut all = usual.clone();
            all.extend(further.iter().map(|path| path.to_path_buf()));
            all.sort();
            all
        };
        assert_eq!(found(&[]), with(&[&own]));
        let (a, b) = (Path::new("/x/a.json"), Path::new("/x/b.json"));
        assert_eq!(found(&[("VK_ADD_DRIVER_FILES", "/x/a.json:/x/b.json")]), with(&[a, b, &own]));
        // This variable replaces all of them.
        assert_eq!(found(&[("VK_ADD_DRIVER_FILES", "/x/a.json"), ("VK_ICD_FILENAMES", "/x/b.json")]), [b]);
    }
}
