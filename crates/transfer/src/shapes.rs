//! The first face in each of its examples, as its rig has it.
use rhytid_core::{DeviceInfo, Error, Progress, Result, Rig};
use rhytid_formats::export::OutputStage;
use rhytid_playback::Playback;

/// An example, evaluated: V positions each, in mesh units.
pub(crate) struct Evaluated {
    /// The large scale, without folds.
    pub smooth: Vec<[f64; 3]>,
    /// The whole.
    pub full: Vec<[f64; 3]>,
}

/// Evaluates the rig at the handles of each of its examples.
///
/// # Errors
/// [`Error::Input`] for a rig without examples; as [`Playback::evaluate`].
pub(crate) fn evaluated(
    rig: &Rig,
    devices: &[DeviceInfo],
    progress: &dyn Progress,
) -> Result<Vec<Evaluated>> {
    let count = rig.example_names.len();
    if count == 0 {
        return Err(Error::input(format!(
            "{} has no examples, of which wrinkles could be transferred; give the rig of a face with expression scans",
            rig.name
        )));
    }
    let mut playback = Playback::new(rig, devices, count)?;
    let handles = rig.example_handles.as_flattened();
    let mut stage = |stage: OutputStage| -> Result<Vec<Vec<[f64; 3]>>> {
        let mut found = Vec::with_capacity(count);
        playback.evaluate(handles, stage, false, progress, |positions, _| {
            found.push(positions.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect());
            Ok(())
        })?;
        Ok(found)
    };
    progress.step("evaluate the examples", 0, 2)?;
    let smooth = stage(OutputStage::LargeScale)?;
    progress.step("evaluate the examples", 1, 2)?;
    let full = stage(OutputStage::Full)?;
    progress.step("evaluate the examples", 2, 2)?;
    Ok(smooth.into_iter().zip(full).map(|(smooth, full)| Evaluated { smooth, full }).collect())
}
