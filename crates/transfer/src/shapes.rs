//! The first face in each of its examples, evaluated by its rig, with and without its wrinkles.
use glam::DVec3;
use rhytid_core::{DeviceInfo, Error, Progress, Result, Rig, Table};
use rhytid_formats::export::OutputStage;
use rhytid_playback::Playback;
use rhytid_solve::Smoothing;

/// σ of the smoothing that separates wrinkles from wider shapes, in spacings of the handles.
///
/// The bands of the learned method do not separate them: the linear band has half of the depth of a wrinkle
/// of a few millimetres.
const WIDE: f64 = 0.25;

/// An example, evaluated: V positions each, in mesh units.
pub(crate) struct Evaluated {
    /// Without its wrinkles: the shell, and the wide part of its residual.
    pub smooth: Vec<[f64; 3]>,
    /// With its wrinkles.
    pub full: Vec<[f64; 3]>,
}

/// Evaluates the rig at the handles of each of its examples.
///
/// # Errors
/// [`Error::Input`] for a rig without examples. Otherwise as [`Playback::evaluate`] and [`Smoothing::over`].
pub(crate) fn evaluated(
    rig: &Rig,
    devices: &[DeviceInfo],
    progress: &dyn Progress,
) -> Result<Vec<Evaluated>> {
    let count = rig.examples().names.len();
    if count == 0 {
        return Err(Error::rig_lacks(format!(
            "{} has no examples, so it has no wrinkles to transfer; give the rig of a face with expression \
             scans",
            rig.surface().name
        )));
    }
    progress.step("evaluate the examples", 0, 2)?;
    let full = played(rig, OutputStage::Full, devices, progress)?;
    progress.step("evaluate the examples", 1, 2)?;
    let shell = played(&rig.clone().shell()?, OutputStage::Shell, devices, progress)?;
    progress.step("evaluate the examples", 2, 2)?;
    let left = |v: usize| (0..count).map(move |p| (p, v));
    let difference = |(p, v): (usize, usize)| (DVec3::from(full[p][v]) - DVec3::from(shell[p][v])).to_array();
    let wide = (0..rig.vertices()).flat_map(left).map(difference).collect();
    let mut wide = Table::new(rig.vertices(), count, wide);
    Smoothing::over(&rig.widened(), WIDE * spacing(rig), progress)?.apply(&mut wide, progress)?;
    let smooth = |(p, shell): (usize, Vec<[f64; 3]>)| {
        let at = |(v, x): (usize, [f64; 3])| (DVec3::from(x) + DVec3::from(wide.row(v)[p])).to_array();
        shell.into_iter().enumerate().map(at).collect()
    };
    let smooth = shell.into_iter().enumerate().map(smooth);
    Ok(smooth.zip(full.iter().cloned()).map(|(smooth, full)| Evaluated { smooth, full }).collect())
}

/// The spacing of the handles: the mean rest length of the strain edges. Without strain edges, the bending
/// length.
pub(crate) fn spacing(rig: &Rig) -> f64 {
    match (&rig.handles().strain_edges[..], rig.handles().feature_lengths().last()) {
        ([_, ..], Some(mean)) => *mean,
        _ => rig.bending_length(),
    }
}

fn played(
    rig: &Rig,
    stage: OutputStage,
    devices: &[DeviceInfo],
    progress: &dyn Progress,
) -> Result<Vec<Vec<[f64; 3]>>> {
    let mut playback = Playback::new(rig, devices, rig.examples().names.len())?;
    let mut found = Vec::with_capacity(rig.examples().names.len());
    playback.evaluate(
        rig.examples().handles.as_slice().as_flattened(),
        stage,
        false,
        progress,
        |positions, _| {
            found.push(positions.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect());
            Ok(())
        },
    )?;
    Ok(found)
}
