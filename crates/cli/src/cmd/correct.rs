//! `rhytid correct`

use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::core::{AtomicFile, Mesh, rig_file};
use rhytid::formats::export::{ChannelChoice, Recipe};
use rhytid::formats::{mesh, refuse_inputs};
use rhytid::playback::Performance;
use rhytid::{Error, Result};
use std::path::{Path, PathBuf};

/// Writes a frame as a mesh, to be sculpted.
///
/// # Errors
/// As reading, evaluating and writing; [`Error::Input`] for a frame that is not there.
pub(super) fn run(args: &args::Correct, ui: &Ui) -> Result<()> {
    inputs::rig_and_take(&args.rig, &args.take, "rhytid correct RIG TAKE --frame N -o POSE.obj")?;
    let output = &args.output;
    if output.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("obj")) {
        return Err(Error::unsupported_format(format!(
            "{}: expected a name that ends in .obj",
            output.display()
        )));
    }
    let edits = inputs::edit_files(args.edit.as_deref())?;
    let read = [&args.rig, &args.take].into_iter().chain(&args.reading.setup).chain(&edits);
    refuse_inputs(&[output], read.map(PathBuf::as_path))?;
    drop(AtomicFile::create(output)?);
    let rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    let take = inputs::take(&args.take, &rig, &args.reading, ui)?;
    inputs::frame(&take, args.frame, &args.take)?;
    let layers = inputs::layers(args.edit.as_deref(), &rig, &args.reading)?;
    let recipe = Recipe {
        first_frame: args.frame as u64,
        end_frame: args.frame as u64 + 1,
        channels: ChannelChoice::NONE,
        ..Recipe::default()
    };
    let performance = Performance::new(recipe, rig, take, layers)?;
    let mut playback = performance.playback(&[inputs::processor()?], ui)?;
    let mut positions = Vec::new();
    playback.play(&performance.selection, &performance.recipe, ui, |frame| {
        positions = frame.positions().as_chunks::<3>().0.iter().map(|x| x.map(f64::from)).collect();
        Ok(())
    })?;
    let rig = &performance.rig;
    let (faces, uvs, materials) =
        (rig.surface().faces.clone(), rig.surface().uvs.clone(), rig.surface().materials.clone());
    mesh::write_obj(output, &Mesh { positions, faces, uvs, materials })?;
    ui.clear();
    let summary = serde_json::json!({ "file": output, "frame": args.frame, "take": args.take });
    output::done(args.json, ui, &summary, || text(args))
}

/// How the written mesh goes on.
fn text(args: &args::Correct) -> String {
    let output = &args.output;
    let name = |path: &Path| path.display().to_string();
    format!(
        "{}: frame {} of {}. Sculpt it without changing its vertices' order. Then, for this take and others like it, in a file of edits:\n\n  \
         [[correction]]\n  mesh = {:?}\n  frame = {}\n\nor, as an example of the rig, in the project file:\n\n  [[example]]\n  name = \"frame {}\"\n  \
         mesh = {:?}\n  take = {:?}\n  frame = {}",
        name(output),
        args.frame,
        name(&args.take),
        name(output),
        args.frame,
        args.frame,
        name(output),
        name(&args.take),
        args.frame
    )
}
