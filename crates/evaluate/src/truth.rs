//! Compares a rig with the truth, and with other methods that use the same examples.

use crate::Regions;
use crate::blendshapes::Weights;
use crate::errors::{Errors, Sum, distances};
use crate::mixtures::Mixtures;
use rayon::prelude::*;
use rhytid_core::{
    DeviceInfo, Error, Face, LearnedSettings, Method, NoProgress, Progress, Result, Rig, Table, Take,
};
use rhytid_formats::export::OutputStage;
use rhytid_formats::sequence::Sequence;
use rhytid_kernels::vec3;
use rhytid_playback::Playback;
use rhytid_solve::{FacePart, Smoothing, solve};
use serde::Serialize;

/// The number of frames whose wrinkle band is computed at once.
const FRAMES_AT_ONCE: usize = 8;

/// Dense meshes, and the take that belongs to them.
pub struct Truth {
    /// The meshes.
    pub meshes: Sequence,
    /// The frame of the take that each mesh shows.
    pub frames: Vec<usize>,
    /// The markers.
    pub take: Take,
}

impl Truth {
    /// `frames` are the frames of the take that the meshes show. Without it, there has to be a mesh for each
    /// frame.
    ///
    /// # Errors
    /// [`Error::Input`] if the numbers of meshes and frames differ.
    pub fn new(meshes: Sequence, frames: Option<Vec<usize>>, take: Take) -> Result<Self> {
        let is_given = frames.is_some();
        let frames = frames.unwrap_or_else(|| (0..take.frames()).collect());
        match meshes.frames() == frames.len() && frames.iter().all(|&frame| frame < take.frames()) {
            true => Ok(Self { meshes, frames, take }),
            false if is_given => Err(Error::mismatch(format!(
                "the truth has {} frames, but {} are listed for it; list the frame of the take for each, in their order",
                meshes.frames(),
                frames.len()
            ))),
            false => Err(Error::mismatch(format!(
                "the truth has {} frames and the take {}; say which frames of the take they are, in a CSV file with a column frame",
                meshes.frames(),
                frames.len()
            ))),
        }
    }
}

/// A method that makes the frames, and its distance from the truth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// `learned`, `chapter`, `shell`, `blendshapes` (weights from 0 to 1), `components` (any weights: all
    /// principal components of the examples), `components+shell` (the same, and what it leaves of the markers
    /// by the shell).
    pub method: &'static str,
    /// Over all vertices.
    #[serde(flatten)]
    pub errors: Errors,
    /// The RMS of the errors without their smooth part: wrinkles that are missing or wrong.
    #[serde(rename = "fold_band_rms_mm")]
    pub wrinkle_band_rms_mm: f64,
}

/// The distance of each method from the truth, the method of the face's settings first. For each method also
/// the RMS of every vertex in millimetres. `rig` is the solved face.
///
/// # Errors
/// As solving, reading the truth and playing.
pub(crate) fn compare(
    face: &Face,
    rig: &Rig<f64>,
    truth: &mut Truth,
    regions: &Regions,
    parts: &[FacePart],
    devices: &[DeviceInfo],
    progress: &dyn Progress,
) -> Result<Vec<(Comparison, Vec<f32>)>> {
    let all = truth.take.handle_positions(&rig.handles().labels)?;
    let all: Vec<&[f32]> = all.chunks_exact(3 * rig.handles().len()).collect();
    let handles: Vec<f32> = truth.frames.iter().flat_map(|&frame| all[frame]).copied().collect();
    let smoothing = Smoothing::new(rig, &NoProgress)?;
    let millimetres = 1e3 * face.metres_per_unit;
    let mut against =
        Against { truth: &mut truth.meshes, regions, parts, smoothing: &smoothing, millimetres, progress };

    let is_learned = matches!(face.settings.method, Method::Learned(_));
    let mut other = face.clone();
    other.settings.method = match is_learned {
        true => Method::Chapter,
        false => Method::Learned(LearnedSettings::default()),
    };
    // The chapter's method has no use for a prior.
    other.prior = None;
    let other = solve(&other, progress)?.rounded()?;
    let own = rig.rounded()?;
    let names = if is_learned { ["learned", "chapter"] } else { ["chapter", "learned"] };
    let shell = own.clone().shell()?;
    let mut found = Vec::new();
    for (name, rig, stage) in [
        (names[0], &own, OutputStage::Full),
        (names[1], &other, OutputStage::Full),
        ("shell", &shell, OutputStage::Shell),
    ] {
        let mut playback = Playback::new(rig, devices, truth.frames.len())?;
        found.push(against.compare(name, |each| {
            playback.evaluate(&handles, stage, false, progress, |positions, _| each(positions))
        })?);
    }
    let mixtures = Mixtures::new(face, rig);
    let markers = handles.as_chunks().0;
    for (name, weights) in [("blendshapes", Weights::ZeroToOne), ("components", Weights::Any)] {
        let fits = mixtures.fit(markers, weights)?;
        found.push(
            against.compare(name, |each| fits.iter().try_for_each(|fit| each(&mixtures.positions(fit))))?,
        );
    }
    let fits = mixtures.fit(markers, Weights::Any)?;
    let left = mixtures.left(markers, &fits);
    let mut playback = Playback::new(&shell, devices, truth.frames.len())?;
    found.push(against.compare("components+shell", |each| {
        let mut fits = fits.iter();
        playback.evaluate(&left, OutputStage::Shell, false, progress, |positions, _| {
            let fit = fits.next().ok_or_else(|| Error::Internal("more frames than were asked for".into()))?;
            let mixed = |(v, x): (usize, &[f32; 3])| {
                vec3::add(x.map(f64::from), mixtures.displacement(fit, v)).map(|x| x as f32)
            };
            let mixed: Vec<[f32; 3]> =
                positions.as_chunks::<3>().0.par_iter().enumerate().map(mixed).collect();
            each(mixed.as_flattened())
        })
    })?);
    Ok(found)
}

/// The truth that frames are compared with.
struct Against<'a> {
    truth: &'a mut Sequence,
    regions: &'a Regions,
    parts: &'a [FacePart],
    smoothing: &'a Smoothing,
    millimetres: f64,
    progress: &'a dyn Progress,
}

/// Receives a frame's 3V positions.
type Each<'a> = &'a mut dyn FnMut(&[f32]) -> Result<()>;

impl Against<'_> {
    /// Compares all frames, which `play` hands over in order.
    fn compare(
        &mut self,
        method: &'static str,
        play: impl FnOnce(Each<'_>) -> Result<()>,
    ) -> Result<(Comparison, Vec<f32>)> {
        let count = self.truth.frames();
        let mut expected = Vec::new();
        self.truth.positions(0, &mut expected)?;
        let vertices = expected.len() / 3;
        let mut sum = Sum::new(self.regions, self.parts, self.millimetres);
        let (mut frame, mut wrinkles, mut open) = (0, 0.0, Vec::new());
        play(&mut |positions| {
            self.truth.positions(frame, &mut expected)?;
            sum.add(distances(positions, &expected));
            open.push(positions.iter().zip(&expected).map(|(a, b)| f64::from(*a) - f64::from(*b)).collect());
            frame += 1;
            if open.len() == FRAMES_AT_ONCE || frame == count {
                wrinkles += self.wrinkles(&open)?;
                open.clear();
            }
            self.progress.step("compare", frame as u64, count as u64)
        })?;
        let wrinkle_band_rms_mm = self.millimetres * (wrinkles / (vertices * count) as f64).sqrt();
        let by_vertex = sum.by_vertex();
        Ok((Comparison { method, errors: sum.finish(), wrinkle_band_rms_mm }, by_vertex))
    }

    /// The squares of the parts of these frames' errors that smoothing removes, each 3V.
    fn wrinkles(&self, errors: &[Vec<f64>]) -> Result<f64> {
        let vertices = errors[0].len() / 3;
        let at = |v: usize, frame: &Vec<f64>| [0, 1, 2].map(|c| frame[3 * v + c]);
        let field = (0..vertices).flat_map(|v| errors.iter().map(move |frame| at(v, frame))).collect();
        let field = Table::new(vertices, errors.len(), field);
        let mut smooth = field.clone();
        self.smoothing.apply(&mut smooth, &NoProgress)?;
        let left = field
            .as_slice()
            .as_flattened()
            .iter()
            .zip(smooth.as_slice().as_flattened())
            .map(|(all, smooth)| (all - smooth).powi(2));
        Ok(left.sum())
    }
}
