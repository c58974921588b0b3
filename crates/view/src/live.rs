//! Handle positions that arrive over the network.

use crate::world::World;
use eframe::egui;
use rhytid_capture::Settings;
use rhytid_core::{Result, Rig};
use rhytid_live::{Counts, Pattern, Receiver, Stream};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// The longest time until the thread notices that it has to end.
const WAIT: Duration = Duration::from_millis(50);

/// Where to listen, and for what.
#[derive(Debug, Clone, PartialEq)]
pub struct Listen {
    /// The address of this machine.
    pub address: SocketAddr,
    /// The address of the messages that have positions.
    pub pattern: Pattern,
    /// For positions in world space: what is known of the actor. The first half second shows the neutral
    /// face, or the neutral frames of the settings do. `None` for positions in head space.
    pub world: Option<Settings>,
}

impl Default for Listen {
    /// This machine alone, as [`rhytid_live::ADDRESS`] says, and positions in head space.
    fn default() -> Self {
        Self { address: rhytid_live::ADDRESS, pattern: Pattern::default(), world: None }
    }
}

/// A frame of the rig's handles.
#[derive(Debug, Clone)]
pub(crate) struct Shown {
    /// H × 3, in mesh units and head space.
    pub positions: Vec<f32>,
    /// H: 1 for a marker that is seen. For one that is not seen, it falls to 0.
    pub confidence: Vec<f32>,
}

/// The newest frame, and the counts of all frames.
#[derive(Debug, Default, Clone)]
struct Newest {
    /// `None` before the first frame.
    shown: Option<Shown>,
    /// The delay in seconds behind the fastest frame.
    latency: f64,
    /// What a user should read.
    notes: Vec<String>,
    counts: Counts,
    /// The fault that ended it.
    fault: Option<String>,
}

/// A thread that listens. It wakes the window when a frame arrives, and sleeps otherwise.
#[derive(Debug)]
pub(crate) struct Live {
    address: SocketAddr,
    newest: Arc<Mutex<Newest>>,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Live {
    /// Listens for the handles of `rig`.
    ///
    /// # Errors
    /// As [`Receiver::listen`] and [`World::new`].
    pub(crate) fn new(listen: &Listen, rig: &Rig, context: &egui::Context) -> Result<Self> {
        let stream = match &listen.world {
            Some(_) => Stream::of_all_markers(),
            None => Stream::new(&rig.handles().labels, &rig.handles().rest),
        };
        let mut receiver = Receiver::listen(listen.address, stream.with_pattern(listen.pattern.clone()))?;
        let mut world = listen.world.as_ref().map(|settings| World::new(rig, settings)).transpose()?;
        let (newest, ends) = (Arc::new(Mutex::new(Newest::default())), Arc::new(AtomicBool::new(false)));
        let (to, end, context) = (newest.clone(), ends.clone(), context.clone());
        let address = receiver.address();
        let run = move || {
            while !end.load(Ordering::Relaxed) {
                let came = receiver.next(WAIT).map(|frame| frame.is_some());
                let stream = receiver.stream();
                let frame = stream.newest().filter(|_| matches!(came, Ok(true)));
                let shown = frame.and_then(|frame| match &mut world {
                    Some(world) => world.frame(&frame, stream.labels()),
                    None => Some(Shown {
                        positions: frame.positions.as_flattened().to_vec(),
                        confidence: frame.confidence.to_vec(),
                    }),
                });
                let mut newest = to.lock().unwrap_or_else(PoisonError::into_inner);
                let before = std::mem::replace(&mut newest.counts, stream.counts());
                if let Err(error) = came {
                    newest.fault = Some(error.to_string());
                    return;
                }
                if frame.is_none() && newest.counts == before {
                    continue;
                }
                // The panel also counts invalid packets.
                newest.notes = notes(stream, world.as_ref());
                newest.latency = frame.map_or(newest.latency, |frame| frame.latency);
                newest.shown = shown.or(newest.shown.take());
                drop(newest);
                context.request_repaint();
            }
        };
        Ok(Self { address, newest, ends, thread: Some(std::thread::spawn(run)) })
    }

    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    fn newest(&self) -> Newest {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The newest frame: H × 3 positions, and the confidence of each handle. `None` before the first frame.
    pub(crate) fn frame(&self) -> Option<(Vec<f32>, Vec<f32>)> {
        self.newest().shown.map(|shown| (shown.positions, shown.confidence))
    }

    /// Its status, for the panel.
    pub(crate) fn status(&self) -> String {
        let Newest { shown, latency, notes, counts, fault } = self.newest();
        let mut words = format!(
            "listening at {}: {} frames, {} lost, {} late, {} bad",
            self.address, counts.frames, counts.lost, counts.late, counts.bad
        );
        if let Some(shown) = shown {
            words += &format!("; latency {:.1} ms", 1e3 * latency);
            let unseen = shown.confidence.iter().filter(|c| **c < 1.0).count();
            if unseen > 0 {
                words += &format!("; {unseen} of {} markers are not seen", shown.confidence.len());
            }
        }
        for note in notes {
            words += &format!("; {note}");
        }
        words + &fault.map(|fault| format!("; ended: {fault}")).unwrap_or_default()
    }
}

/// What a user should read: what is likely wrong with the sender, and with the calibration.
fn notes(stream: &Stream, world: Option<&World>) -> Vec<String> {
    let mut notes = Vec::new();
    if stream.counts().frames == 0 {
        notes.extend(stream.other_messages());
    }
    notes.extend(stream.other_labels());
    notes.extend(world.map(|world| world.note.clone()).filter(|note| !note.is_empty()));
    notes.extend(stream.warnings().iter().cloned());
    notes
}

impl Drop for Live {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // The thread ends within its wait. If it panicked, this has already been reported.
            let _ = thread.join();
        }
    }
}
