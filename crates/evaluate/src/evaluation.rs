//! The whole evaluation of a face.

use crate::Regions;
use crate::errors::{Errors, Sum};
use crate::noise;
use crate::truth::{Comparison, Truth, compare};
use rhytid_core::{DeviceInfo, Face, HandleId, Progress, Result, Rig, Table};
use rhytid_kernels::vec3;
use rhytid_solve::{Solved, face_parts, solve_in_full};
use serde::Serialize;

/// How good the rig of a face is, and where it is not.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evaluation {
    /// The face's name.
    pub name: String,
    /// V.
    pub vertices: usize,
    /// H.
    pub handles: usize,
    /// The error of the smooth part of each example if that example were left out, over the skin by area.
    /// `None` without examples, or by the chapter's method. The level is pessimistic, because each example is
    /// far from the others. The distribution over the face is right.
    pub leave_one_out: Option<LeaveOneOut>,
    /// The effect of the noise of markers on the skin, at the rest pose and the examples.
    pub noise: NoiseAnswer,
    /// The distance of each method from the truth, if one was given; the method of the face's settings first.
    pub truth: Option<Vec<Comparison>>,
}

/// The error of each example if it were left out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeaveOneOut {
    /// Over all examples; a frame is an example.
    #[serde(flatten)]
    pub all: Errors,
    /// The RMS error of the shell alone, over all examples.
    pub shell_rms_mm: f64,
    /// The same on the skin alone.
    pub shell_skin_rms_mm: f64,
    /// One by one.
    pub examples: Vec<LeftOut>,
    /// Where the linear band is faded to the shell, the least kept first.
    pub faded: Vec<Faded>,
}

/// A handle around which the linear band is faded to the shell, because left-out examples are hardly better
/// with it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Faded {
    /// Its label.
    pub handle: String,
    /// How much of the linear band is kept, 0..1.
    pub kept: f64,
}

/// An example that is left out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftOut {
    /// Its name in the rig.
    pub example: String,
    /// The error of the rig of the other examples.
    #[serde(flatten)]
    pub errors: Errors,
    /// The RMS error of the shell alone.
    pub shell_rms_mm: f64,
    /// The same on the skin alone.
    pub shell_skin_rms_mm: f64,
}

/// The answer to the noise of markers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoiseAnswer {
    /// The standard deviation of the noise per axis.
    pub noise_mm: f64,
    /// The movement of the skin that it causes.
    #[serde(flatten)]
    pub errors: Errors,
}

/// The subject of a map. Maps of the same subject are drawn on one scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Subject {
    /// Examples that are left out.
    LeaveOneOut,
    /// The answer to noise.
    Noise,
    /// The distance from the truth.
    Truth,
}

/// A number for each vertex, in millimetres.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Its subject.
    pub subject: Subject,
    /// What it shows.
    pub title: String,
    /// V numbers.
    pub values: Vec<f32>,
}

/// Solves `face` and evaluates it. Returns the rig, the results, and maps of them. `inputs` receives the rig
/// and returns its regions, such as [`Regions::by_handles`], and the truth, if there is any.
///
/// # Errors
/// As solving, playing and reading the truth; as `inputs`.
pub fn evaluate(
    face: &Face,
    inputs: impl FnOnce(&Rig) -> Result<(Regions, Option<Truth>)>,
    devices: &[DeviceInfo],
    progress: &dyn Progress,
) -> Result<(Rig, Evaluation, Vec<Map>)> {
    let Solved { rig, left_out, report } = solve_in_full(face, true, progress)?;
    let rounded = rig.rounded()?;
    let (regions, truth) = inputs(&rounded)?;
    let parts = face_parts(&rounded);
    let regions = regions.with_parts(&parts);
    let millimetres = 1e3 * face.metres_per_unit;
    let mut maps = Vec::new();
    let leave_one_out = left_out.filter(|left_out| !left_out.errors.is_empty()).map(|left_out| {
        let rms = |sum: Sum<'_>| {
            let errors = sum.finish();
            (errors.rms_mm, errors.skin.rms_mm)
        };
        let sum = || Sum::weighted(&regions, &parts, left_out.skin_area.clone(), millimetres);
        let [mut all, mut all_of_shell] = [sum(), sum()];
        let mut of_examples = Vec::new();
        let mut of_example_maps = Vec::new();
        for (p, name) in rig.examples().names.iter().enumerate() {
            let distances = |of: &Table<[f64; 3]>| -> Vec<f64> {
                of.rows().map(|errors| vec3::length(errors[p])).collect()
            };
            let [mut one, mut shell] = [sum(), sum()];
            one.add(distances(&left_out.errors).into_iter());
            all.add(distances(&left_out.errors).into_iter());
            shell.add(distances(&left_out.of_shell).into_iter());
            all_of_shell.add(distances(&left_out.of_shell).into_iter());
            of_example_maps.push(Map {
                subject: Subject::LeaveOneOut,
                title: format!("without {name}"),
                values: one.by_vertex(),
            });
            let (shell_rms_mm, shell_skin_rms_mm) = rms(shell);
            of_examples.push(LeftOut {
                example: name.clone(),
                errors: one.finish(),
                shell_rms_mm,
                shell_skin_rms_mm,
            });
        }
        maps.push(Map {
            subject: Subject::LeaveOneOut,
            title: "any of them".into(),
            values: all.by_vertex(),
        });
        maps.append(&mut of_example_maps);
        let handle =
            |(h, kept): (HandleId, f64)| Faded { handle: rig.handles().labels[h.index()].clone(), kept };
        let (shell_rms_mm, shell_skin_rms_mm) = rms(all_of_shell);
        LeaveOneOut {
            all: all.finish(),
            shell_rms_mm,
            shell_skin_rms_mm,
            examples: of_examples,
            faded: report.faded().into_iter().map(handle).collect(),
        }
    });
    let (errors, map) = noise::noise(&rounded, &regions, &parts, devices, progress)?;
    maps.push(Map {
        subject: Subject::Noise,
        title: format!("{} mm of noise", noise::NOISE_MM),
        values: map,
    });
    let truth = match truth {
        None => None,
        Some(mut truth) => {
            let found = compare(face, &rig, &mut truth, &regions, &parts, devices, progress)?;
            let (comparisons, by_vertex): (Vec<_>, Vec<_>) = found.into_iter().unzip();
            let of_method = |(comparison, values): (&Comparison, Vec<f32>)| Map {
                subject: Subject::Truth,
                title: comparison.method.into(),
                values,
            };
            maps.extend(comparisons.iter().zip(by_vertex).map(of_method));
            Some(comparisons)
        }
    };
    let evaluation = Evaluation {
        name: face.name.clone(),
        vertices: rig.vertices(),
        handles: rig.handles().len(),
        leave_one_out,
        noise: NoiseAnswer { noise_mm: noise::NOISE_MM, errors },
        truth,
    };
    Ok((rounded, evaluation, maps))
}
