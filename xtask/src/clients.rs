//! `cargo xtask clients`: exports, opened by other programs. It writes the table of `docs/clients.md`. The
//! quick half is a test of the program, too.
use crate::run::{Result, cargo, command, root, run};
use crate::{python, setup};
use std::path::PathBuf;

/// What to measure.
#[derive(clap::Args)]
pub(crate) struct Clients {
    /// The program whose exports are opened [default: this one, built for release]
    #[arg(long, value_name = "RHYTID")]
    program: Option<PathBuf>,
    /// Print the table and the clients' errors, and write nothing.
    #[arg(long)]
    print: bool,
    /// Leave out Blender and the browser.
    #[arg(long, requires = "print")]
    quick: bool,
    /// Keep the exports in this folder.
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
}

/// Installs the clients, builds the program, exports a small face, and has every client open the files.
pub(crate) fn clients(options: &Clients) -> Result {
    setup::setup()?;
    let blenders = if options.quick { Vec::new() } else { python::blenders()? };
    let program = match &options.program {
        Some(program) => program.clone(),
        None => {
            run(cargo(&["build", "--release", "--package", "rhytid-cli"]))?;
            root().join("target/release/rhytid")
        }
    };
    run(cargo(&["build", "--package", "rhytid-clients", "--examples"]))?;
    let python = python::clients()?;
    let mut measure = command(&python, &[]);
    measure.arg(root().join("benches/clients/clients.py")).arg("--program").arg(program);
    measure.arg("--python").arg(&python).arg("--node").arg(root().join("target/node"));
    measure.arg("--gltf-crate").arg(root().join("target/debug/examples/gltf_crate"));
    measure.arg("--page").arg(root().join("docs/clients.md"));
    for blender in blenders {
        measure.arg("--blender").arg(blender);
    }
    for (flag, is_set) in [("--print", options.print), ("--quick", options.quick)] {
        if is_set {
            measure.arg(flag);
        }
    }
    if let Some(folder) = &options.keep {
        measure.arg("--keep").arg(folder);
    }
    run(measure)
}
