//! `rhytid animate --listen`: the take that arrives.

use super::recording_file::RecordingFile;
use crate::args::{Animate, FramesChoice};
use crate::progress::Ui;
use crate::{interrupt, output, start};
use rhytid::capture::{Target, misfit};
use rhytid::core::human;
use rhytid::formats::take;
use rhytid::live::{Counts, Receiver, Recording, Stream, record};
use rhytid::playback::read_raw_take;
use rhytid::{Error, Result, Rig, Take};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How long to wait for a frame.
const PATIENCE: Duration = Duration::from_secs(30);
/// The number of labels that a warning lists.
const LABELS: usize = 8;

/// How many frames to record; `None` where there is a take.
///
/// # Errors
/// [`Error::Input`] if `--frames` is of the other kind, or out of range.
pub(super) fn count(args: &Animate) -> Result<Option<usize>> {
    let most = Take::MAX_RESAMPLED;
    match (args.live.listen, args.frames) {
        (None, FramesChoice::Range(_)) => Ok(None),
        (None, FramesChoice::Count(n)) => Err(Error::out_of_range(format!(
            "--frames {n} is for --listen; of a take, give A..B, A.. or ..B, such as ..{n}"
        ))),
        (Some(_), FramesChoice::Count(n)) if (1..=most).contains(&n) => Ok(Some(n)),
        (Some(_), _) => Err(Error::out_of_range(format!(
            "--listen needs to know how many frames to record: give --frames N, from 1 to {most}; Ctrl-C \
             ends the recording earlier"
        ))),
    }
}

/// A recording that is kept until its output is written.
pub(super) struct Kept {
    /// The file with the frames. It grows while they come.
    path: PathBuf,
    /// Whether the user asked for it, so that it stays.
    is_asked_for: bool,
    rig: PathBuf,
    /// Whether its positions are in world space.
    is_in_the_world: bool,
}

impl Kept {
    /// The output is there, and the recording is not needed any more.
    pub(super) fn remove(&self) {
        if !self.is_asked_for {
            let _ = std::fs::remove_file(&self.path);
        }
    }

    /// What to do if the output could not be written.
    pub(super) fn advice(&self) -> String {
        let words = start::arguments();
        if self.is_in_the_world {
            return format!(
                "the recording is in {}, in world space; clean it with `{}`",
                self.path.display(),
                prepare(words, &self.rig, &self.path)
            );
        }
        format!(
            "the recording is in {}; make the output from it with `rhytid {}`",
            self.path.display(),
            with_take(words, &self.rig, &self.path)
        )
    }

    /// Writes the recording elsewhere if its folder has vanished, or if its file has only a part of it. The
    /// part stays until the whole is written.
    fn keep(&mut self, take: &Take, is_whole: bool) -> Result<()> {
        if is_whole && self.path.exists() {
            return Ok(());
        }
        let elsewhere = free(&std::env::temp_dir().join(self.path.file_name().unwrap_or_default()));
        if let Err(error) = take::write(&elsewhere, take) {
            if self.path.exists() {
                log::warn!("{}: has the recording's first frames", self.path.display());
            }
            return Err(error);
        }
        self.remove();
        self.path = elsewhere;
        Ok(())
    }
}

/// The command line of `animate --listen` as one that plays the take in a file, with all its other options.
fn with_take(words: Vec<String>, rig: &Path, take: &Path) -> String {
    let mut command = Vec::new();
    let mut words = words.into_iter().peekable();
    while let Some(word) = words.next() {
        let option = word.split('=').next().unwrap_or_default();
        if ["--frames", "--record", "--timeout", "--listen", "--address"].contains(&option) {
            // Its value is in the same word, or there is none: `--listen` may stand without an address.
            let is_alone = word != option
                || option == "--listen"
                    && words.peek().is_none_or(|next| next.parse::<u16>().is_err() && !next.contains(':'));
            if !is_alone {
                words.next();
            }
            continue;
        }
        let is_rig = Path::new(&word) == rig;
        command.push(output::word(Path::new(&word)));
        if is_rig {
            command.push(output::word(take));
        }
    }
    command.join(" ")
}

/// The command that cleans a recording in world space, with the options for it of this command line.
pub(super) fn prepare(words: Vec<String>, rig: &Path, recording: &Path) -> String {
    let mut command =
        format!("rhytid prepare {} --rig {} --world", output::word(recording), output::word(rig));
    let mut words = words.into_iter();
    while let Some(word) = words.next() {
        let option = word.split('=').next().unwrap_or_default();
        if ["--force", "--allow-elsewhere"].contains(&option) {
            command += &format!(" {option}");
        } else if ["--rigid", "--unit", "--axes", "--neutral", "--setup"].contains(&option) {
            command += &format!(" {}", output::word(Path::new(&word)));
            if word == option {
                command += &words
                    .next()
                    .map_or(String::new(), |value| format!(" {}", output::word(Path::new(&value))));
            }
        }
    }
    format!("{command} -o {}", output::word(&recording.with_extension("clean.csv")))
}

/// The name for a recording that makes `output`: `face.recording.csv` for `face.usd`, or the next free one.
fn recording_of(output: &Path) -> PathBuf {
    free(&output.with_extension("recording.csv"))
}

/// `path`, or the next name that is free.
fn free(path: &Path) -> PathBuf {
    let stem = path.with_extension("");
    let numbered = (2_u32..).map(|i| stem.with_extension(format!("recording-{i}.csv")));
    let mut names = std::iter::once(path.to_owned()).chain(numbered);
    names.find(|path| path.symlink_metadata().is_err()).unwrap_or_else(|| path.to_owned())
}

/// Records a take of `rig`'s handles, and writes it if requested. Its frames are on disk as they come.
/// Positions in world space are recorded as they come, and then cleaned.
///
/// # Errors
/// [`Error::Input`] if the address cannot be listened at, or if nothing or nothing of this rig arrives;
/// [`Error::Io`]; [`Error::Cancelled`]. As [`read_raw_take`].
pub(super) fn take(args: &Animate, rig: &Rig, frames: usize, ui: &Ui) -> Result<(Take, Kept)> {
    let address = args.live.listen.ok_or_else(|| Error::Internal("nowhere to listen".into()))?;
    let sender = &args.live.sender;
    let mut world = sender.clean_up(args.reading.setup.as_deref(), args.reading.elsewhere.reach())?;
    if let Some(clean_up) = &mut world {
        clean_up.settings.force |= args.reading.force;
    }
    let handles = rig.handles();
    let stream = match &world {
        Some(_) => Stream::of_all_markers(),
        None => Stream::new(&handles.labels, &handles.rest),
    };
    let mut receiver =
        Receiver::listen(address, stream.with_pattern(sender.address.clone().unwrap_or_default()))?;
    let address = receiver.address();
    let patience = args.live.timeout.unwrap_or(PATIENCE);
    let ended = interrupt::recording_ended;
    let path = recording_of(args.live.record.as_ref().unwrap_or(&args.output));
    let mut kept =
        Kept { path, is_asked_for: false, rig: args.rig.clone(), is_in_the_world: world.is_some() };
    let mut file = match &world {
        Some(_) => RecordingFile::of_all_markers(&kept.path)?,
        None => RecordingFile::of_handles(&kept.path, &handles.labels)?,
    };
    if !ui.is_quiet() {
        ui.line(&format!("listening at {address} for {}", human::counted(frames, "frame")));
    }
    let recorded = interrupt::end_of_recording(|| {
        record(&mut receiver, frames, patience, &ended, &mut |frame, labels| file.frame(frame, labels), ui)
    });
    ui.clear();
    let is_whole = file.finish(receiver.stream().labels());
    let recording = recorded.inspect_err(|_| kept.remove())?;
    if world.is_none() && recording.unseen.len() == handles.labels.len() {
        kept.remove();
        let came = receiver.stream().other_labels();
        return Err(Error::network(format!(
            "{address}: no frame has a marker of the rig's {}: {}; see `rhytid info {}`",
            human::counted(handles.labels.len(), "handle"),
            came.unwrap_or_else(|| "no frame shows any marker".to_owned()),
            args.rig.display()
        )));
    }
    kept.keep(&recording.take, is_whole)?;
    if let Some(path) = &args.live.record {
        take::write(path, &recording.take).inspect_err(|_| ui.line(&format!("note: {}", kept.advice())))?;
        kept.remove();
        kept = Kept { path: path.clone(), is_asked_for: true, ..kept };
    }
    let received = format!("{address}: {}", summary(&recording, receiver.counts()));
    match (args.json.wanted, ui.is_quiet()) {
        (_, true) => {}
        // Standard output has the JSON alone.
        (true, false) => ui.line(&received),
        (false, false) => output::say(&received)?,
    }
    let shortfall = frames - recording.take.frames();
    if recording.timed_out && shortfall > 0 {
        log::warn!(
            "no frame arrived for {} s: the recording lacks the last {}",
            patience.as_secs_f64(),
            human::counted(shortfall, "frame")
        );
    }
    warn_of_bad(receiver.stream());
    let Some(clean_up) = world else {
        warn(&recording, rig);
        return Ok((recording.take, kept));
    };
    let cleaned = read_raw_take(&kept.path, rig, &clean_up, ui);
    let (cleaned, _) = cleaned.inspect_err(|_| ui.line(&format!("note: {}", kept.advice())))?;
    Ok((cleaned.take, kept))
}

/// Warns if many datagrams were no part of a frame.
fn warn_of_bad(stream: &Stream) {
    let counts = stream.counts();
    let Some(why) = stream.why_bad().filter(|_| counts.bad > counts.frames / 10) else { return };
    let others = stream.other_messages().map_or(String::new(), |others| format!("; {others}"));
    let bad = human::counted(usize::try_from(counts.bad).unwrap_or(usize::MAX), "datagram");
    log::warn!("{bad} were no part of a frame: the last {why}{others}; correct the sender if it meant them");
}

/// Warns about positions that were never received, and about positions in another space.
fn warn(recording: &Recording, rig: &Rig) {
    if !recording.unseen.is_empty() {
        let listed = recording.unseen.iter().take(LABELS).map(String::as_str).collect::<Vec<_>>().join(", ");
        let more = if recording.unseen.len() > LABELS { ", …" } else { "" };
        log::warn!(
            "{} of the rig's {} were in no frame and stay at rest: {listed}{more}",
            recording.unseen.len(),
            human::counted(rig.handles().labels.len(), "handle")
        );
    }
    if let Some(misfit) = misfit(&recording.take, &Target::from_rig(rig)) {
        log::warn!(
            "the received positions do not fit the rig: {misfit}; send positions in the mesh's unit and \
             axes, without the head's motion"
        );
    }
}

/// What was received, in one line.
fn summary(recording: &Recording, counts: Counts) -> String {
    let mut latency = recording.latency.clone();
    latency.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let latency = latency.get(((latency.len() - 1) as f64 * share).round() as usize);
        latency.map_or(f64::NAN, |seconds| 1e3 * seconds)
    };
    let times = &recording.take.times;
    let lasted = times.last().zip(times.first()).map_or(0.0, |(last, first)| last - first);
    format!(
        "{} over {lasted:.3} s, {} lost, {} late, {} bad; latency {:.2} ms in the median, {:.2} ms in 95 %, {:.2} ms at most, beyond the fastest frame's",
        human::counted(recording.take.frames(), "frame"),
        counts.lost,
        counts.late,
        counts.bad,
        at(0.5),
        at(0.95),
        at(1.0)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_for_a_recording_in_world_space_has_its_options() {
        let line = "animate face.safetensors --listen --frames 9 --world --unit mm --axes=+x+z-y -o a.glb --fps 30 --force \
                    --rigid a,b,c";
        let words = line.split_whitespace().map(str::to_owned).collect();
        assert_eq!(
            prepare(words, Path::new("face.safetensors"), Path::new("a.csv")),
            "rhytid prepare a.csv --rig face.safetensors --world --unit mm \"--axes=+x+z-y\" --force --rigid \"a,b,c\" -o a.clean.csv"
        );
    }

    #[test]
    fn the_command_for_a_recording_has_the_other_options() {
        let found = |line: &str| {
            let words = line.split(' ').map(str::to_owned).collect();
            with_take(words, Path::new("face.safetensors"), Path::new("a.recording.csv"))
        };
        let expected = "animate face.safetensors a.recording.csv -o a.glb --quantize --head bake";
        for line in [
            "animate face.safetensors --listen --frames 9 -o a.glb --quantize --head bake",
            "animate --listen=9000 face.safetensors -o a.glb --quantize --frames=9 --head bake --timeout 3",
            "animate face.safetensors --listen 127.0.0.1:9000 -o a.glb --record b.csv --quantize --frames 9 --head bake",
            "animate face.safetensors --listen 9000 --address /m/{label} -o a.glb --quantize --frames 9 --head bake",
        ] {
            assert_eq!(found(line), expected, "{line}");
        }
    }
}
