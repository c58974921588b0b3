//! Frames to be drawn, evaluated one after the other: on the device that draws, or on another one that hands
//! them over.

use super::shape::Shape;
use super::truth::Truth;
use crate::progress::Ui;
use crate::{args, drawing, inputs};
use rhytid::core::{Backend, DeviceInfo, channel};
use rhytid::devices::Watch;
use rhytid::devices::wgpu::{Wgpu, WgpuSession};
use rhytid::formats::export::{OutputStage, Recipe};
use rhytid::playback::{EditedTake, Layers, Playback, Selection, finishes_frames_on_host};
use rhytid::render::Vertices;
use rhytid::{Animator, Error, Progress, Result, Rig, Stage, UploadOptions};
use std::time::{Duration, Instant};

/// Frames whose other stages are kept until the result arrives.
const BATCH: usize = 16;

/// The data of one frame.
#[derive(Default)]
pub(super) struct Evaluated<'a> {
    /// The result on the device that draws. Everything else is then empty.
    pub drawn_from: Option<Vertices<'a>>,
    pub result: Shape<'a>,
    /// The result at an earlier stage or by another rig, if requested.
    pub before: Shape<'a>,
    /// The true shape, if given.
    pub truth: Shape<'a>,
    /// V × 3 positions, if requested.
    pub large_scale: &'a [f32],
    /// V values, if requested.
    pub sigma: &'a [f32],
}

/// The shape to put beside the result.
pub(super) struct Before {
    /// `None` for the same rig.
    pub rig: Option<Rig>,
    pub stage: OutputStage,
    /// The name of that shape, and the name of the result.
    pub words: [String; 2],
}

/// What each frame must contain.
pub(super) struct Wanted<'a> {
    pub recipe: Recipe,
    /// The effects of edits beyond the take's handles, and the edited take with all of its frames.
    pub layers: Option<(Layers, EditedTake)>,
    pub large_scale: bool,
    pub before: Option<&'a Before>,
    pub truth: Option<Truth>,
    /// The pictures need frames on the host.
    pub on_host: bool,
}

impl Wanted<'_> {
    /// Whether a session's own buffers have everything: positions and normals.
    fn is_drawn_from_a_session(&self, rig: &Rig) -> bool {
        let is_more = self.on_host
            || finishes_frames_on_host(rig)
            || self.large_scale
            || self.before.is_some()
            || self.truth.is_some()
            || self.layers.is_some();
        !is_more && self.recipe == Recipe::default()
    }
}

/// Frames of a rig.
pub(super) struct Frames<'a> {
    rig: &'a Rig,
    on: On<'a>,
    wanted: Wanted<'a>,
    /// Time of evaluation. On another device only the time that drawing had to wait.
    pub evaluation: Duration,
}

/// Where the frames are evaluated.
enum On<'a> {
    /// On the device that draws, so that frames are drawn directly from its buffers.
    Same(Box<SameDevice<'a>>),
    /// On another device; with the other rig to put beside the result, if there is one.
    Other { playback: Box<Playback<'a>>, before: Option<Box<Playback<'a>>> },
}

/// The session of the device that draws.
struct SameDevice<'a> {
    session: Animator<WgpuSession>,
    info: DeviceInfo,
    watch: Option<Watch<'a>>,
}

/// The device to draw with, and the device named for evaluation (`None` for `auto`).
///
/// # Errors
/// As [`inputs::named_device`] and [`drawing::device`].
pub(super) fn devices(args: &args::Render) -> Result<(DeviceInfo, Option<DeviceInfo>)> {
    let named = inputs::named_device(&args.device)?;
    let evaluates = named.as_ref().filter(|device| device.backend == Wgpu::NAME);
    let draws = match (&args.draw_on, evaluates) {
        (None, Some(device)) => device.clone(),
        (wanted, _) => drawing::device(wanted.as_deref().unwrap_or(Wgpu::NAME))?,
    };
    Ok((draws, named))
}

impl<'a> Frames<'a> {
    /// `count` frames of `rig`, which `wgpu` draws on the device `draws`.
    ///
    /// The frames are evaluated on the device `named`. Without a name, `draws` evaluates them if it is a GPU
    /// and has everything that is wanted. Otherwise the fastest device does.
    ///
    /// # Errors
    /// As [`Playback::new`] and [`inputs::devices`].
    pub(super) fn new(
        rig: &'a Rig,
        count: usize,
        wanted: Wanted<'a>,
        wgpu: &Wgpu,
        draws: &DeviceInfo,
        named: Option<DeviceInfo>,
        ui: &Ui,
    ) -> Result<Self> {
        let is_same = named.as_ref().map_or(!draws.is_software_driver(), |named| named == draws);
        let same = match is_same && wanted.is_drawn_from_a_session(rig) {
            true => match On::same(rig, wgpu, draws) {
                Err(error @ Error::Device { .. }) if named.is_none() => {
                    log::warn!("{error}; going on with another device");
                    None
                }
                on => Some(on?),
            },
            false => None,
        };
        let on = match same {
            Some(on) => on,
            None => {
                let devices = inputs::devices(named, ui)?;
                let before = wanted.before.and_then(|before| before.rig.as_ref());
                let before = before.map(|rig| Playback::new(rig, &devices, count.min(BATCH)));
                let mut playback = Playback::new(rig, &devices, count)?;
                if let Some((layers, take)) = &wanted.layers {
                    playback = playback.with_layers(layers, take, ui)?;
                }
                On::Other { playback: Box::new(playback), before: before.transpose()?.map(Box::new) }
            }
        };
        Ok(Self { rig, on, wanted, evaluation: Duration::ZERO })
    }

    /// The device that evaluates.
    pub(super) fn device(&self) -> &DeviceInfo {
        match &self.on {
            On::Same(same) => &same.info,
            On::Other { playback, .. } => playback.device(),
        }
    }

    /// Evaluates the frames of `take` with these rising numbers, and gives each to `each`.
    ///
    /// # Errors
    /// As [`Playback::play`] and `each`.
    pub(super) fn each(
        &mut self,
        take: &EditedTake,
        frames: &[usize],
        ui: &Ui,
        mut each: impl FnMut(&Evaluated<'_>) -> Result<()>,
    ) -> Result<()> {
        match &mut self.on {
            On::Same(same) => {
                let SameDevice { session, watch, .. } = &mut **same;
                let handles = take.take.pick(frames).handle_positions(&self.rig.handles().labels)?;
                for handles in handles.chunks_exact(3 * self.rig.handles().len()) {
                    if ui.cancelled() {
                        return Err(Error::Cancelled);
                    }
                    let begin = Instant::now();
                    session.evaluate(handles)?;
                    session.session().wait()?;
                    self.evaluation += begin.elapsed();
                    if let Some(watch) = watch.as_mut().filter(|watch| watch.is_due()) {
                        let stages = [Stage::Positions, Stage::Normals];
                        let mut found = [Vec::new(), Vec::new()];
                        for (stage, found) in stages.into_iter().zip(&mut found) {
                            session.read(stage, found)?;
                        }
                        watch.batch(handles, &stages, &found)?;
                    }
                    each(&Evaluated {
                        drawn_from: Some(vertices(session.session())?),
                        ..Default::default()
                    })?;
                }
                Ok(())
            }
            On::Other { playback, before } => {
                let is_kept = self.wanted.large_scale || self.wanted.before.is_some();
                for frames in frames.chunks(if is_kept { BATCH } else { usize::MAX }) {
                    let begin = Instant::now();
                    let drawn = hand_over(
                        &mut self.wanted,
                        playback,
                        before.as_deref_mut(),
                        take,
                        frames,
                        ui,
                        &mut each,
                    )?;
                    self.evaluation += begin.elapsed().saturating_sub(drawn);
                }
                Ok(())
            }
        }
    }
}

impl On<'_> {
    fn same<'a>(rig: &'a Rig, wgpu: &Wgpu, info: &DeviceInfo) -> Result<On<'a>> {
        let options = UploadOptions::frames(1);
        let mut session = Animator::new(wgpu, rig, options)?;
        let watch = Watch::begin(rig, options, info, &mut session)?;
        Ok(On::Same(Box::new(SameDevice { session, info: info.clone(), watch })))
    }
}

/// The vertices in the buffers of a session of one frame.
fn vertices(session: &WgpuSession) -> Result<Vertices<'_>> {
    let result = |stage| session.results(stage).next().map(|(_, buffer)| buffer.slice(..));
    let (positions, normals) = (result(Stage::Positions), result(Stage::Normals));
    match positions.zip(normals) {
        Some((positions, normals)) => Ok(Vertices { positions, normals, numbers: None }),
        None => Err(Error::Internal("a session without results".into())),
    }
}

/// Plays frames of a take on the host: the rig, and `before` if it is another rig. Returns the time that
/// `each` took.
fn hand_over<'a>(
    wanted: &mut Wanted<'_>,
    playback: &mut Playback<'a>,
    other: Option<&mut Playback<'a>>,
    take: &EditedTake,
    frames: &[usize],
    ui: &Ui,
    each: &mut impl FnMut(&Evaluated<'_>) -> Result<()>,
) -> Result<Duration> {
    let (take, inner) = (take.pick(frames), 0..frames.len());
    let selection = Selection { rate: take.take.rate(), take, inner, first: 0 };
    let per_frame = 3 * playback.rig().vertices();
    let mut large_scale = Kept::default();
    if wanted.large_scale {
        large_scale = Kept::new(playback, &selection, OutputStage::LargeScale, ui)?;
    }
    let mut before = Kept::default();
    if let Some(Before { stage, .. }) = wanted.before {
        before = Kept::new(other.unwrap_or(&mut *playback), &selection, *stage, ui)?;
    }
    let (mut i, mut drawn) = (0, Duration::ZERO);
    playback.play(&selection, &wanted.recipe, ui, |frame| {
        let truth = wanted.truth.as_mut().map(|truth| truth.frame(frames[i])).transpose()?;
        let begin = Instant::now();
        each(&Evaluated {
            drawn_from: None,
            result: Shape {
                positions: frame.positions(),
                normals: frame.get(&channel::NORMALS).unwrap_or_default(),
            },
            before: before.frame(i, per_frame),
            truth: truth.unwrap_or_default(),
            large_scale: large_scale.frame(i, per_frame).positions,
            sigma: frame.get(&channel::SIGMA).unwrap_or_default(),
        })?;
        i += 1;
        drawn += begin.elapsed();
        Ok(())
    })?;
    Ok(drawn)
}

/// Frames one after the other.
#[derive(Default)]
struct Kept {
    positions: Vec<f32>,
    normals: Vec<f32>,
}

impl Kept {
    fn new(playback: &mut Playback<'_>, selection: &Selection, stage: OutputStage, ui: &Ui) -> Result<Self> {
        let mut kept = Self::default();
        playback.play(selection, &Recipe { stage, ..Recipe::default() }, ui, |frame| {
            kept.positions.extend_from_slice(frame.positions());
            kept.normals.extend_from_slice(frame.get(&channel::NORMALS).unwrap_or_default());
            Ok(())
        })?;
        Ok(kept)
    }

    /// A frame of `per_frame` numbers; empty where nothing was kept.
    fn frame(&self, i: usize, per_frame: usize) -> Shape<'_> {
        let of = |numbers: &[f32]| i * per_frame..((i + 1) * per_frame).min(numbers.len());
        Shape {
            positions: self.positions.get(of(&self.positions)).unwrap_or_default(),
            normals: self.normals.get(of(&self.normals)).unwrap_or_default(),
        }
    }
}
