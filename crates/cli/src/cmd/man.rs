//! `rhytid man`

use crate::progress::Ui;
use crate::{args, output};
use clap::Command;
use rhytid::core::AtomicFile;
use rhytid::core::human;
use rhytid::{Error, Result};
use std::path::Path;

/// Writes `rhytid.1` and one page per command.
///
/// # Errors
/// [`Error::Io`] if the folder or a page cannot be written.
pub(super) fn run(args: &args::Man, ui: &Ui) -> Result<()> {
    std::fs::create_dir_all(&args.dir).map_err(Error::io(&args.dir))?;
    let mut program = args::command().disable_help_subcommand(true);
    program.build();
    write_page(&args.dir, program.clone())?;
    let mut pages = 1;
    for command in program.get_subcommands().filter(|command| !command.is_hide_set()) {
        write_page(&args.dir, command.clone())?;
        pages += 1;
    }
    output::done(args.json, ui, &serde_json::json!({ "folder": args.dir, "pages": pages }), || {
        format!("{}: {}", args.dir.display(), human::counted(pages, "man page"))
    })
}

fn write_page(dir: &Path, command: Command) -> Result<()> {
    let page = clap_mangen::Man::new(command);
    let mut file = AtomicFile::create(&dir.join(page.get_filename()))?;
    page.render(&mut file).map_err(file.error())?;
    file.finish()
}
