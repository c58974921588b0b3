//! Handle positions that arrive over the network.

use eframe::egui;
use rhytid_core::{Result, Rig};
use rhytid_live::{Counts, Receiver};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// The longest time until the thread notices that it has to end.
const WAIT: Duration = Duration::from_millis(50);

/// The newest frame, and the counts of all frames.
#[derive(Debug, Default, Clone)]
struct Newest {
    /// H × 3. `None` before the first frame.
    positions: Option<Vec<f32>>,
    /// The delay in seconds behind the fastest frame.
    latency: f64,
    /// H: 1 for a marker that is seen. For one that is not seen, it falls to 0.
    confidence: Vec<f32>,
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
    /// As [`Receiver::bind`].
    pub(crate) fn new(address: SocketAddr, rig: &Rig, context: &egui::Context) -> Result<Self> {
        let mut receiver = Receiver::bind(address, &rig.handles().labels, &rig.handles().rest)?;
        let (newest, ends) = (Arc::new(Mutex::new(Newest::default())), Arc::new(AtomicBool::new(false)));
        let (to, end, context) = (newest.clone(), ends.clone(), context.clone());
        let address = receiver.address();
        let listen = move || {
            while !end.load(Ordering::Relaxed) {
                let frame = receiver.next(WAIT).map(|frame| {
                    frame.map(|frame| {
                        let positions = frame.positions.as_flattened().to_vec();
                        (positions, frame.latency, frame.confidence.to_vec())
                    })
                });
                let mut newest = to.lock().unwrap_or_else(PoisonError::into_inner);
                let before = std::mem::replace(&mut newest.counts, receiver.counts());
                match frame {
                    Ok(Some((positions, latency, confidence))) => {
                        (newest.positions, newest.latency, newest.confidence) =
                            (Some(positions), latency, confidence);
                    }
                    // The panel also counts invalid packets.
                    Ok(None) if newest.counts == before => continue,
                    Ok(None) => {}
                    Err(error) => {
                        newest.fault = Some(error.to_string());
                        return;
                    }
                }
                drop(newest);
                context.request_repaint();
            }
        };
        Ok(Self { address, newest, ends, thread: Some(std::thread::spawn(listen)) })
    }

    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    fn newest(&self) -> Newest {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The newest frame: H × 3 positions, and the confidence of each handle. `None` before the first frame.
    pub(crate) fn frame(&self) -> Option<(Vec<f32>, Vec<f32>)> {
        let Newest { positions, confidence, .. } = self.newest();
        positions.map(|positions| (positions, confidence))
    }

    /// Its status, for the panel.
    pub(crate) fn status(&self) -> String {
        let Newest { positions, latency, confidence, counts, fault } = self.newest();
        let unseen = confidence.iter().filter(|c| **c < 1.0).count();
        let mut words = format!(
            "listening at {}: {} frames, {} lost, {} late, {} bad",
            self.address, counts.frames, counts.lost, counts.late, counts.bad
        );
        if positions.is_some() {
            words += &format!("; latency {:.1} ms", 1e3 * latency);
        }
        if unseen > 0 {
            words += &format!("; {unseen} of {} markers are not seen", confidence.len());
        }
        words + &fault.map(|fault| format!("; ended: {fault}")).unwrap_or_default()
    }
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
