//! `rhytid export-shapes`

use crate::args::MaterialsChoice;
use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::core::human;
use rhytid::core::{AtomicFile, rig_file};
use rhytid::formats::animation::{self, Format};
use rhytid::formats::export::{self, Shapes, StatedRecipe};
use rhytid::formats::{FileKind, refuse_inputs};
use rhytid::playback::{Playback, handle_shapes};
use rhytid::{Error, Result};

/// Writes the shapes and says what was done.
///
/// # Errors
/// [`rhytid::Error::Input`] and [`rhytid::Error::Io`] from reading and writing;
/// [`rhytid::Error::Device`]; [`rhytid::Error::Cancelled`].
pub(super) fn run(args: &args::ExportShapes, ui: &Ui) -> Result<()> {
    inputs::expect(&args.rig, &[FileKind::Rig], "rhytid export-shapes RIG -o OUT.glb")?;
    check_options(args)?;
    refuse_inputs(&[&args.output], [&*args.rig])?;
    drop(AtomicFile::create(&args.output)?);
    let device = inputs::named_device(&args.device)?;
    let rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    let options = export::Options {
        most_targets: args.targets.map(usize::from),
        one_material: args.materials == MaterialsChoice::One,
        force: args.force,
        textures: args.textures.map(Into::into),
        prim_path: args.layer.prim_path.clone(),
        mesh_name: args.layer.mesh_name.clone(),
        metres: args.layer.metres,
        subdivision: args.layer.subdivision.into(),
        ..export::Options::default()
    };
    let columns = if args.handles { 3 * rig.handles().len() } else { 0 };
    animation::check_shapes(&args.output, rig.examples().names.len() + columns, &options)?;
    let recipe = StatedRecipe::of_shapes(&rig_file::hash(&args.rig)?);
    let devices = inputs::devices(device, ui)?;
    let mut playback = Playback::new(&rig, &devices, rig.examples().names.len())?;
    let rest_normals = if args.no_normals { None } else { Some(playback.rest_normals()?) };
    // Three shapes for each handle are many. Their normals would double the memory.
    let moving_normals = rest_normals.as_deref().filter(|_| !args.handles);
    let mut shapes = playback.example_shapes(moving_normals, ui)?;
    if args.handles {
        shapes.extend(handle_shapes(&rig, &shapes));
    }
    let written = animation::write_shapes(
        &args.output,
        &Shapes {
            name: &rig.surface().name,
            rest: &rig.surface().rest,
            rest_normals: rest_normals.as_deref(),
            faces: &rig.surface().faces,
            triangle_corners: &rig.surface().triangle_corners()?,
            uvs: rig.surface().uvs.as_ref(),
            materials: rig.surface().materials.as_ref(),
            metres_per_unit: rig.surface().metres_per_unit,
            up_axis: rig.surface().up_axis,
            recipe: &recipe,
            shapes: &shapes,
        },
        &options,
        ui,
    )?;
    let summary = serde_json::json!({
        "file": args.output,
        "bytes": written.bytes,
        "shapes": shapes.len(),
        "examples": rig.examples().names.len(),
    });
    output::done(args.json, ui, &summary, || {
        format!(
            "{}: {} ({} of examples), {}",
            args.output.display(),
            human::counted(shapes.len(), "shape"),
            rig.examples().names.len(),
            human::bytes(written.bytes)
        )
    })
}

/// An option that the format would ignore is a mistake.
fn check_options(args: &args::ExportShapes) -> Result<()> {
    let for_gltf = vec![
        (args.targets.is_some(), "--targets"),
        (args.materials != MaterialsChoice::default(), "--materials"),
    ];
    let (of_others, others) = match Format::from_extension(&args.output)? {
        Format::Glb | Format::Gltf => (args.layer.given().to_vec(), "USD (.usd, .usdc, .usda or .usdz)"),
        _ => (for_gltf, "glTF (.glb or .gltf)"),
    };
    match of_others.into_iter().find(|(given, _)| *given) {
        Some((_, option)) => Err(Error::conflict(format!(
            "{}: {option} is for {others}; leave it out, or choose such a file",
            args.output.display()
        ))),
        None => Ok(()),
    }
}
