//! The options of `rhytid animate`: what of them is a mistake, and what they are to the library.

use super::{masks, take_name};
use crate::args::MaterialsChoice;
use crate::{args, inputs};
use rhytid::core::{AtomicFile, ChannelKind};
use rhytid::formats::animation::Format;
use rhytid::formats::export::{self, Recipe, ShapeSet, WrinkleGroups};
use rhytid::formats::{FileKind, raw_take, refuse_inputs};
use rhytid::playback::Layers;
use rhytid::{Error, Result};
use std::path::{Path, PathBuf};

/// An option that the stage or the format would ignore is a mistake.
pub(crate) fn check(args: &args::Animate, format: Format) -> Result<()> {
    args.fine_detail.check()?;
    // A raw take may need it for its clean-up, whatever the format.
    let is_raw = args.live.sender.world || args.takes.iter().any(|take| !raw_take::is_take_csv(take));
    let for_gltf = [
        (args.compressed, "--compressed"),
        (args.quantize, "--quantize"),
        (args.meshopt, "--meshopt"),
        (args.targets.is_some(), "--targets"),
        (args.vertex_ids, "--vertex-ids"),
        (args.materials != MaterialsChoice::default(), "--materials"),
        (args.reading.force && !is_raw, "--force"),
    ];
    if args.compressed && args.reading.shapes_to_write().is_some() {
        return Err(Error::conflict(
            "--compressed and --shapes N are two ways to write few shapes; give one",
        ));
    }
    if args.onto.is_some() && args.reading.shapes_to_write().is_some() {
        return Err(Error::conflict("--onto fits given shapes, and --shapes N makes new ones; give one"));
    }
    if format == Format::Csv && args.onto.is_none() {
        return Err(Error::conflict(format!(
            "{}: a .csv holds weights of shapes; give the shapes with --onto SHAPES, or write .usd or .glb",
            args.output.display()
        )));
    }
    if let Some(shapes) = args.reading.shapes_of_curves().filter(|_| args.live.listen.is_some()) {
        return Err(Error::conflict(format!(
            "--listen receives positions, so that --shapes {} changes nothing; leave it out",
            shapes.display()
        )));
    }
    let kinds = args.channels.0.kinds().filter(|kind| !kind.is_default() && !format.carries(*kind));
    if let Some(kind) = kinds.into_iter().next() {
        return Err(Error::conflict(format!(
            "{}: --{} is for {}; leave it out, or choose such a file",
            args.output.display(),
            args::option(kind),
            args::formats(kind)
        )));
    }
    const GLTF: &str = "glTF (.glb or .gltf)";
    let for_both =
        [(args.reading.shapes_to_write().is_some(), "--shapes"), (args.textures.is_some(), "--textures")];
    const USD: &str = "USD (.usd, .usdc, .usda or .usdz)";
    let mut for_usd = args.layer.given().to_vec();
    for_usd.push((args.over, "--over"));
    if format == Format::Pc2 && args.onto.is_some() {
        return Err(Error::conflict(format!(
            "{}: --onto is for USD, glTF and .csv; leave it out, or choose such a file",
            args.output.display()
        )));
    }
    let of_others = match format {
        Format::Usdc | Format::Usda | Format::Usdz => vec![(&for_gltf[..], GLTF)],
        Format::Glb | Format::Gltf => vec![(&for_usd[..], USD)],
        Format::Csv | Format::Pc2 => {
            vec![(&for_gltf[..], GLTF), (&for_both, "USD and glTF"), (&for_usd[..], USD)]
        }
    };
    let mut given = of_others.iter().flat_map(|(options, of)| options.iter().map(move |option| (option, of)));
    match given.find(|((given, _), _)| *given) {
        Some(((_, option), of)) => Err(Error::conflict(format!(
            "{}: {option} is for {of}; leave it out, or choose such a file",
            Path::new(&args.output).display()
        ))),
        None => Ok(()),
    }
}

/// Checks that the inputs are of the right kinds, and that every output can be written and is no input.
pub(super) fn check_files(args: &args::Animate) -> Result<()> {
    for take in &args.takes {
        inputs::rig_and_take(&args.rig, take, "rhytid animate RIG TAKE -o OUT.usd")?;
    }
    if args.takes.is_empty() {
        inputs::expect(&args.rig, &[FileKind::Rig], "rhytid animate RIG --listen --frames N -o OUT.usd")?;
    }
    let edits = inputs::edit_files(args.edit.as_deref())?;
    let inputs = [Some(&args.rig), args.reading.setup.as_ref(), args.groups.as_ref(), args.onto.as_ref()];
    let inputs = inputs.into_iter().flatten().chain(&args.takes).chain(&edits).map(PathBuf::as_path);
    let inputs = inputs.chain(args.reading.shapes_of_curves());
    let masks = masks::outputs(args);
    let others = args.live.record.iter().chain(&args.strain_curves).chain(&masks);
    let outputs: Vec<&Path> = std::iter::once(&args.output).chain(others).map(PathBuf::as_path).collect();
    refuse_inputs(&outputs, inputs)?;
    for output in outputs {
        drop(AtomicFile::create(output)?);
    }
    Ok(())
}

/// The recipe of the options for the rig with this hash. The frames are known only with the take.
pub(crate) fn recipe(
    args: &args::Animate,
    rig: String,
    format: Format,
    layers: Option<&Layers>,
) -> Result<Recipe> {
    let mut channels = args.channels.0.clone();
    // A default channel is left out if the format has no place for it.
    let lacks = |kind: &ChannelKind| kind.is_default() && !format.carries(*kind);
    ChannelKind::ALL.into_iter().filter(lacks).for_each(|kind| channels.set(kind, false));
    Ok(Recipe {
        rig,
        stage: args.fine_detail.stage.into(),
        fps: args.fps,
        start_frame: args.start_frame,
        missing: args.reading.missing.into(),
        fade_detail: args.fine_detail.fade,
        head: args.head.into(),
        detail: args.fine_detail.gain,
        detail_of: inputs::gains(&args.fine_detail, &args.reading)?,
        edit: layers.map(|layers| layers.text().to_owned()),
        edit_hash: layers.map(|layers| layers.hash().to_owned()),
        channels,
        wrinkle_groups: WrinkleGroups(args.wrinkle_group.clone()),
        refine: args.refine,
        treatment: args.reading.treatment(args.takes.first().map(PathBuf::as_path))?,
        ..Recipe::default()
    })
}

/// What the library is told about the file.
pub(crate) fn export_options(
    args: &args::Animate,
    metres_per_unit: f64,
    onto: Option<ShapeSet>,
) -> export::Options {
    export::Options {
        max_error: args.compressed.then_some(args.max_error * 1e-3 / metres_per_unit),
        quantize: args.quantize,
        meshopt: args.meshopt,
        most_targets: args.targets.map(usize::from),
        force: args.reading.force,
        shapes: args.reading.shapes_to_write(),
        vertex_ids: args.vertex_ids,
        one_material: args.materials == MaterialsChoice::One,
        clips: args.takes.iter().chain(&args.live.record).map(|take| take_name(take)).collect(),
        onto,
        textures: args.textures.map(Into::into),
        prim_path: args.layer.prim_path.clone(),
        mesh_name: args.layer.mesh_name.clone(),
        metres: args.layer.metres,
        over: args.over,
        subdivision: args.layer.subdivision.into(),
    }
}
