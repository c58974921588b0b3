//! `rhytid render`

use crate::args::{Show, StageChoice};
use crate::guard::guard;
use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::backends::wgpu::Wgpu;
use rhytid::formats::export::OutputStage;
use rhytid::formats::refuse_inputs;
use rhytid::playback::{Playback, find_device};
use rhytid::render::{
    Camera, FrameBuffers, Heat, Look, Offscreen, Picture, Renderer, Sheet, Sphere, Strains, View, distances,
};
use rhytid::{AtomicFile, Backend, Error, Progress, Result, Rig, human, rig_file};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Where a frame's number goes in a file's name.
const FRAME: &str = "{frame}";
const ON_A_SHEET: [u32; 2] = [300, 400];
const ALONE: [u32; 2] = [720, 960];

/// Draws and says what was done.
///
/// # Errors
/// [`Error::Input`] and [`Error::Io`] from reading and writing; [`Error::Device`]; [`Error::Cancelled`].
pub(super) fn run(args: &args::Render, ui: &Ui) -> Result<()> {
    let name = args.output.to_string_lossy();
    if !args.output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
        return Err(Error::input(format!("{name}: pictures are written as .png")));
    }
    if args.stage != StageChoice::Full && args.show.contains(&Show::Detail) {
        return Err(Error::input("--show detail is for --stage full: the others have no detail"));
    }
    inputs::rig_and_take(&args.rig, &args.take, "rhytid render RIG TAKE -o OUT.png")?;
    let device = inputs::named_device(&args.device)?;
    let mut rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    if args.stage == StageChoice::Shell {
        rig = rig.shell();
    }
    let setup = (args.setup.as_deref(), args.elsewhere.reach());
    let take = inputs::take(&args.take, &rig, args.missing, setup, &args.space, ui)?;
    let range = args.frames.within(take.frames())?;
    let is_sheet = !name.contains(FRAME);
    let frames: Vec<usize> = match is_sheet {
        true => spread(range.start, range.len(), args.count as usize),
        false => range.collect(),
    };
    let file = |frame: usize| PathBuf::from(name.replace(FRAME, &format!("{frame:05}")));
    let outputs: Vec<PathBuf> = frames.iter().map(|&frame| file(frame)).collect();
    let outputs: Vec<&Path> = outputs.iter().map(PathBuf::as_path).collect();
    let known = [&*args.rig, &*args.take].into_iter().chain(args.setup.as_deref());
    refuse_inputs(if is_sheet { &outputs[..1] } else { &outputs }, known)?;
    drop(AtomicFile::create(outputs[0])?);

    let mut pictures = Pictures::new(args, &rig, if is_sheet { ON_A_SHEET } else { ALONE })?;
    let mut sheet = match is_sheet {
        true => Some(Sheet::new(frames.len() as u32, pictures.size(), &pictures.legends())?),
        false => None,
    };
    let all = take.handle_positions(&rig.labels)?;
    let per_frame = 3 * rig.handles.len();
    let handles: Vec<f32> =
        frames.iter().flat_map(|&frame| &all[frame * per_frame..][..per_frame]).copied().collect();
    let devices = inputs::devices(device, ui)?;
    let mut playback = Playback::new(&rig, &devices, frames.len())?;
    let (start, mut drawing, mut bytes, mut done) = (Instant::now(), Duration::ZERO, 0, 0);
    let mut each = |positions: &[f32], normals: &[f32], large_scale: &[f32]| -> Result<()> {
        let begin = Instant::now();
        let (frame, picture) = (frames[done], pictures.draw(positions, normals, large_scale)?);
        drawing += begin.elapsed();
        match &mut sheet {
            Some(sheet) => sheet.add(&picture, &format!("{frame}   {:.2} s", take.times[frame])),
            None => bytes += write(outputs[done], &picture)?,
        }
        done += 1;
        ui.step("render", done as u64, frames.len() as u64)
    };
    ui.report("render", 0, frames.len() as u64);
    let stage = OutputStage::from(args.stage);
    if args.show.contains(&Show::Detail) {
        // Both of a batch, so that neither is kept for all frames.
        for handles in handles.chunks(per_frame * BATCH) {
            let mut large_scale = Vec::new();
            playback.evaluate(handles, OutputStage::LargeScale, false, ui, |positions, _| {
                large_scale.extend_from_slice(positions);
                Ok(())
            })?;
            let mut large_scale = large_scale.chunks_exact(3 * rig.vertices());
            playback.evaluate(handles, stage, true, ui, |positions, normals| {
                each(positions, normals, large_scale.next().unwrap_or_default())
            })?;
        }
    } else {
        playback.evaluate(&handles, stage, true, ui, |positions, normals| each(positions, normals, &[]))?;
    }
    if let Some(sheet) = sheet {
        bytes = write(outputs[0], &sheet.into_picture())?;
    }
    if ui.is_quiet() {
        return Ok(());
    }
    let seconds = start.elapsed().as_secs_f64();
    output::say(&format!(
        "{name}: {} evaluated on {} ({}) and drawn on {} in {}, of these {} drawing; {} frames/s, {}",
        human::counted(frames.len(), "frame"),
        playback.device().id(),
        playback.device().name,
        pictures.device,
        human::duration(start.elapsed()),
        human::duration(drawing),
        human::number((frames.len() as f64 / seconds * 10.0).round() / 10.0),
        human::bytes(bytes)
    ))
}

/// Frames whose large scale is kept until their detail is there.
const BATCH: usize = 16;

/// `count` of `frames` frames from `first` on, the first and the last among them.
fn spread(first: usize, frames: usize, count: usize) -> Vec<usize> {
    let count = count.min(frames);
    (0..count).map(|i| first + (i * (frames - 1) + (count - 1) / 2) / (count - 1).max(1)).collect()
}

fn write(path: &Path, picture: &Picture) -> Result<u64> {
    let bytes = picture.png()?;
    let mut file = AtomicFile::create(path)?;
    file.write_all(&bytes).map_err(file.error())?;
    file.finish()?;
    Ok(bytes.len() as u64)
}

/// Where handles are at rest, and as far again beyond them as a face goes on.
fn about_the_handles(rig: &Rig) -> Vec<[f32; 3]> {
    const BEYOND: f32 = 1.4;
    let points: Vec<[f32; 3]> = rig.handles.iter().map(|&v| rig.rest[v as usize]).collect();
    let center = Sphere::around(&points).center;
    points.iter().map(|p| std::array::from_fn(|c| center[c] + BEYOND * (p[c] - center[c]))).collect()
}

/// What draws a frame, once for each thing to show.
struct Pictures {
    /// What draws, for people.
    device: String,
    shown: Vec<(Show, Option<Heat>)>,
    renderer: Renderer,
    page: Offscreen,
    frame: FrameBuffers,
    camera: Camera,
    strains: Option<Strains>,
    millimetres: f32,
}

impl Pictures {
    fn new(args: &args::Render, rig: &Rig, size: [u32; 2]) -> Result<Self> {
        let info = find_device(&args.draw_on, guard())?;
        if info.backend != Wgpu::NAME {
            return Err(Error::input(format!(
                "--draw-on {}: expected a device of the backend wgpu, as `rhytid devices` lists them",
                args.draw_on
            )));
        }
        let wgpu = Wgpu::open(&info)?;
        let (device, queue) = (wgpu.device(), wgpu.queue());
        let page = Offscreen::new(device, queue, args.size.unwrap_or(size))?;
        let view = View { turn: args.turn, raise: args.raise, lens: args.lens };
        let heat = |show| match show {
            Show::Strain => Some(Heat::Signed(args.strain_range)),
            Show::Detail => Some(Heat::From0(args.detail_range)),
            _ => None,
        };
        Ok(Self {
            device: format!("{} ({})", info.id(), info.name),
            shown: args.show.iter().map(|&show| (show, heat(show))).collect(),
            renderer: Renderer::new(device, queue, &rig.faces, &rig.triangles, Offscreen::TARGET)?,
            frame: FrameBuffers::new(device, queue, rig.vertices())?,
            camera: match args.whole {
                true => Camera::framing(&rig.rest, rig.up_axis, view, page.aspect()),
                false => Camera::framing(&about_the_handles(rig), rig.up_axis, view, page.aspect()),
            },
            strains: args.show.contains(&Show::Strain).then(|| Strains::new(&rig.faces, &rig.rest)),
            millimetres: 1e3 * rig.metres_per_unit as f32,
            page,
        })
    }

    /// Of what is shown, beside each other.
    fn size(&self) -> [u32; 2] {
        let [width, height] = self.page.size();
        [width.saturating_mul(self.shown.len() as u32), height]
    }

    fn legends(&self) -> Vec<(Heat, &'static str)> {
        let title = |show: Show| if show == Show::Strain { "strain" } else { "detail, mm" };
        self.shown.iter().filter_map(|(show, heat)| Some(((*heat)?, title(*show)))).collect()
    }

    fn draw(&mut self, positions: &[f32], normals: &[f32], large_scale: &[f32]) -> Result<Picture> {
        let [width, _] = self.page.size();
        let mut picture = Picture::filled(self.size(), [0; 4]);
        for (i, (show, heat)) in (0..).zip(&self.shown) {
            let numbers = match show {
                Show::Strain => {
                    self.strains.as_ref().map(|strains| strains.of(positions)).unwrap_or_default()
                }
                Show::Detail => distances(positions, large_scale, self.millimetres),
                _ => Vec::new(),
            };
            self.frame.set(positions, normals, &numbers);
            let look = show.look().or(heat.map(Look::Heat)).unwrap_or(Look::Smooth);
            self.renderer.show(&self.camera, self.page.aspect(), look);
            let part = self.page.draw(&self.renderer, self.frame.vertices(), Sheet::background())?;
            picture.put(&part, [i * width, 0]);
        }
        Ok(picture)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_spread_evenly_from_the_first_to_the_last() {
        assert_eq!(spread(10, 101, 5), [10, 35, 60, 85, 110]);
        assert_eq!(spread(3, 4, 12), [3, 4, 5, 6]);
        assert_eq!(spread(7, 1, 12), [7]);
        assert_eq!(spread(0, 10, 1), [0]);
    }
}
