//! `rhytid export-shapes`

use super::animate::triangle_corners;
use crate::args::StageChoice;
use crate::player::Player;
use crate::progress::Ui;
use crate::{args, device_choice, output};
use rhytid_core::human;
use rhytid_core::{Progress, Result, Rig, WriteBeside, rig_file};
use rhytid_formats::animation::{self, Format};
use rhytid_formats::export::{self, OutputStage, Shape, Shapes};

/// Writes the shapes and says what was done.
///
/// # Errors
/// [`rhytid_core::Error::Input`] and [`rhytid_core::Error::Io`] from reading and writing;
/// [`rhytid_core::Error::Device`]; [`rhytid_core::Error::Cancelled`].
pub fn run(args: &args::ExportShapes, ui: &Ui) -> Result<()> {
    Format::of(&args.output)?;
    drop(WriteBeside::create(&args.output)?);
    let device = device_choice::named(&args.device)?;
    let rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    let provenance = export::Provenance {
        version: env!("CARGO_PKG_VERSION").into(),
        rig: rig_file::hash(&args.rig)?,
        stage: OutputStage::Full.into(),
        ..export::Provenance::default()
    };
    let mut player = Player::new(&rig, device, rig.example_names.len(), ui)?;
    let rest_normals = if args.no_normals { None } else { Some(player.rest_normals()?) };
    // Three shapes for each handle are many: normals would double what has to be held.
    let moving_normals = rest_normals.as_deref().filter(|_| !args.handles);
    let mut shapes = example_shapes(&rig, &mut player, moving_normals, ui)?;
    if args.handles {
        shapes.extend(handle_shapes(&rig, &shapes));
    }
    let written = animation::write_shapes(
        &args.output,
        &Shapes {
            name: &rig.name,
            rest: &rig.rest,
            rest_normals: rest_normals.as_deref(),
            faces: &rig.faces,
            triangle_corners: &triangle_corners(&rig.faces, &rig.triangles)?,
            uvs: rig.uvs.as_ref(),
            materials: rig.materials.as_ref(),
            metres_per_unit: rig.metres_per_unit,
            up_axis: rig.up_axis,
            provenance: &provenance,
            shapes: &shapes,
        },
        &export::Options { force: args.force, ..export::Options::default() },
        ui,
    )?;
    if ui.is_quiet() {
        return Ok(());
    }
    output::say(&format!(
        "{}: {} ({} of examples), {}",
        args.output.display(),
        human::counted(shapes.len(), "shape"),
        rig.example_names.len(),
        human::bytes(written.bytes)
    ))
}

/// What each example adds to the rest pose: the rig evaluated at the example's own handles.
fn example_shapes(
    rig: &Rig,
    player: &mut Player<'_>,
    rest_normals: Option<&[[f32; 3]]>,
    ui: &Ui,
) -> Result<Vec<Shape>> {
    let mut names = rig.example_names.iter();
    let mut shapes = Vec::with_capacity(rig.example_names.len());
    let total = rig.example_names.len() as u64;
    ui.report("evaluate the examples", 0, total);
    let handles = rig.example_handles.as_flattened();
    let normals = rest_normals.is_some();
    player.evaluate(handles, StageChoice::Full, normals, None, ui, |positions, normals| {
        let name = names.next().cloned().unwrap_or_default();
        let offsets = difference(positions, &rig.rest);
        let normal_offsets = rest_normals.map(|rest| difference(normals, rest));
        shapes.push(Shape { name, offsets, normal_offsets });
        ui.report("evaluate the examples", shapes.len() as u64, total);
        Ok(())
    })?;
    Ok(shapes)
}

fn difference(moved: &[f32], rest: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let moved = moved.as_chunks::<3>().0.iter();
    moved.zip(rest).map(|(moved, rest)| std::array::from_fn(|c| moved[c] - rest[c])).collect()
}

/// The basis' columns: what one handle adds when it moves by one unit along an axis. None has the name of one of
/// the `examples`.
fn handle_shapes(rig: &Rig, examples: &[Shape]) -> Vec<Shape> {
    let handles = rig.handles.len();
    let shape = |h: usize, axis: usize| {
        let mut name = format!("{}_{}", rig.labels[h], ["x", "y", "z"][axis]);
        while examples.iter().any(|example| example.name == name) {
            name += "_handle";
        }
        let offset =
            |v: usize| std::array::from_fn(|c| if c == axis { rig.basis[v * handles + h] } else { 0.0 });
        Shape { name, offsets: (0..rig.vertices()).map(offset).collect(), normal_offsets: None }
    };
    (0..handles).flat_map(|h| (0..3).map(move |axis| (h, axis))).map(|(h, axis)| shape(h, axis)).collect()
}
