//! `cargo xtask blender`: the Blender extension as a zip, with the wheel of the Python package in it.
use crate::python;
use crate::run::{Result, command, output, root, run};
use crate::wheel;
use std::path::PathBuf;

/// What to pack.
#[derive(clap::Args)]
pub(crate) struct Blender {
    /// The wheel to pack. Without it, the wheel is built as by `cargo xtask python`.
    #[arg(long, value_name = "FILE")]
    wheel: Option<PathBuf>,
    /// The folder that gets the zip. A relative one is below the repository's root.
    #[arg(long, value_name = "FOLDER", default_value = "target/blender")]
    out: PathBuf,
}

/// Packs the extension, and has Blender's own check look at it.
pub(crate) fn blender(options: &Blender) -> Result {
    let wheel = match &options.wheel {
        Some(wheel) => wheel.clone(),
        None => {
            wheel::python(&wheel::Python::default())?;
            wheel::wheel(&root().join(wheel::WHEELS))?
        }
    };
    let version = env!("CARGO_PKG_VERSION");
    let python = python::blender()?;
    let zip = root().join(&options.out).join(format!("rhytid-{version}-linux-x64.zip"));
    let mut build = command(&python, &["integrations/blender/build.py", version]);
    build.arg(wheel).arg(&zip);
    run(build)?;
    let find =
        "import bpy, os; print(os.path.join(bpy.utils.system_resource('SCRIPTS'), 'addons_core/bl_pkg/cli'))";
    let folder = output(command(&python, &["-c", find]))
        .ok_or("Blender's module does not start: run `cargo xtask setup`")?;
    let folder = folder.lines().last().unwrap_or_default();
    let mut validate = command(&python, &[]);
    validate.arg(PathBuf::from(folder).join("blender_ext.py")).arg("validate").arg(&zip);
    run(validate)?;
    println!("{}: drop it into Blender's window, or install it from disk in its preferences", zip.display());
    Ok(())
}
