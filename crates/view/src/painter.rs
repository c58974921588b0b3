//! The thread that evaluates and draws. The window asks it for one thing at a time, and stays as it is until
//! the answer comes.

use crate::legend::Spread;
use crate::order::Order;
use crate::pace::Fineness;
use crate::scene::Times;
use crate::studio::Studio;
use crate::work::Work;
use eframe::egui;
use rhytid_core::{DeviceInfo, Result};
use std::collections::VecDeque;
#[cfg(not(target_arch = "wasm32"))]
use std::path::PathBuf;
use std::sync::Arc;
use web_time::Duration;

/// A request.
#[derive(Debug)]
pub(crate) enum Job {
    /// Draws a picture.
    Paint(Box<Order>, Fineness),
    /// Finds the vertex at a place of the picture, in pixels.
    Pick { order: Box<Order>, at: [f32; 2], then: Then },
    /// Evaluates on another device from now on. `None` for the device that draws.
    Device(Option<DeviceInfo>),
    /// Writes the frame as a mesh, beside the rig's file.
    #[cfg(not(target_arch = "wasm32"))]
    SaveMesh(Box<Order>, PathBuf),
    /// Writes the picture, drawn in full, beside the rig's file.
    #[cfg(not(target_arch = "wasm32"))]
    SavePicture(Box<Order>, PathBuf),
}

/// What a picked vertex is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Then {
    /// Says what drives it.
    Explain,
    /// Brings it to the middle.
    Focus,
}

/// The answer to a request.
#[derive(Debug)]
pub(crate) enum Answer {
    /// The rig is on its devices.
    Ready,
    Painted(Box<Painted>),
    /// The vertex and its position.
    Picked(Option<(usize, [f32; 3])>, Then),
    /// The device that evaluates.
    Device(Option<DeviceInfo>),
    #[cfg(not(target_arch = "wasm32"))]
    Saved(PathBuf),
}

/// A picture.
#[derive(Debug)]
pub(crate) struct Painted {
    pub order: Order,
    pub fineness: Fineness,
    pub times: Times,
    /// The numbers of the result's map.
    pub spread: Option<Spread>,
    /// The result, and the side that it is compared with, if there is one.
    pub textures: [Option<wgpu::Texture>; 2],
}

/// A request and what came of it. `job` is `None` for the beginning.
pub(crate) struct Done {
    pub job: Option<JobKind>,
    pub result: Result<Answer>,
}

/// What kind of request it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum JobKind {
    Paint,
    Pick,
    Device,
    #[cfg(not(target_arch = "wasm32"))]
    Save,
}

impl Job {
    fn kind(&self) -> JobKind {
        match self {
            Self::Paint(..) => JobKind::Paint,
            Self::Pick { .. } => JobKind::Pick,
            Self::Device(_) => JobKind::Device,
            #[cfg(not(target_arch = "wasm32"))]
            Self::SaveMesh(..) | Self::SavePicture(..) => JobKind::Save,
        }
    }
}

/// Makes a studio.
type Make = Box<dyn FnOnce() -> Result<Studio> + Send>;

/// What the thread has to do.
enum Errand {
    /// Makes a studio in place of the one before, which makes room first.
    Make(Make),
    Do(Job),
}

/// The other end of the thread. A browser has no threads: there, requests are answered at once.
pub(crate) struct Painter {
    context: egui::Context,
    end: End,
    /// The work that goes on. `None` while there is nothing to do.
    work: Option<Arc<Work>>,
    /// Requests that wait for it.
    waiting: VecDeque<Job>,
    /// Whether there is a studio, or may be one soon.
    is_alive: bool,
    /// The number of the studio. Answers of earlier ones are not for this window any longer.
    studio: u64,
}

impl Painter {
    /// Begins to `make` a studio. The first answer says whether it could be made. The painter `before` goes
    /// on with it, and forgets its own studio first, as a device may not have room for two rigs.
    pub(crate) fn new(
        context: &egui::Context,
        before: Option<Self>,
        make: impl FnOnce() -> Result<Studio> + Send + 'static,
    ) -> Self {
        let mut painter = match before {
            Some(before) if before.is_alive => before,
            _ => Self {
                context: context.clone(),
                end: End::new(),
                work: None,
                waiting: VecDeque::new(),
                is_alive: true,
                studio: 0,
            },
        };
        if let Some(work) = &painter.work {
            work.stop();
        }
        painter.waiting.clear();
        painter.studio += 1;
        painter.tell(Errand::Make(Box::new(make)));
        painter
    }

    /// Requests something. It is done after all that was requested before.
    pub(crate) fn request(&mut self, job: Job) {
        self.waiting.push_back(job);
        self.go_on();
    }

    fn go_on(&mut self) {
        if self.work.is_none()
            && self.is_alive
            && let Some(job) = self.waiting.pop_front()
        {
            self.tell(Errand::Do(job));
        }
    }

    fn tell(&mut self, errand: Errand) {
        let work = Work::new(&self.context);
        self.work = Some(work.clone());
        self.end.send(Told { errand, work, studio: self.studio });
    }

    /// The work that goes on.
    pub(crate) fn work(&self) -> Option<&Work> {
        self.work.as_deref()
    }

    /// The next answer. Waits for it up to `patience`.
    pub(crate) fn answer(&mut self, patience: Duration) -> Option<Done> {
        self.work.as_ref()?;
        let done = loop {
            let (studio, done) = self.end.wait(patience)?;
            if studio.is_none_or(|studio| studio == self.studio) {
                break done;
            }
        };
        self.work = None;
        self.is_alive = done.job.is_some() || done.result.is_ok();
        self.go_on();
        Some(done)
    }

    /// Whether requests are answered.
    pub(crate) fn is_alive(&self) -> bool {
        self.is_alive
    }

    /// The studio.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn studio(&self) -> Option<&Studio> {
        self.end.studio.as_ref()
    }
}

impl Drop for Painter {
    fn drop(&mut self) {
        if let Some(work) = &self.work {
            work.stop();
        }
        self.end.finish();
    }
}

/// An errand, with the number of the studio that it is for.
struct Told {
    errand: Errand,
    work: Arc<Work>,
    studio: u64,
}

/// Does an errand. `None` where there is no studio for it.
fn run(studio: &mut Option<Studio>, errand: Errand, work: &Work) -> Option<Done> {
    match errand {
        Errand::Make(make) => {
            *studio = None;
            let result = make().map(|made| {
                *studio = Some(made);
                Answer::Ready
            });
            Some(Done { job: None, result })
        }
        Errand::Do(job) => {
            let kind = job.kind();
            Some(Done { job: Some(kind), result: studio.as_mut()?.work(job, work) })
        }
    }
}

#[cfg(not(target_arch = "wasm32"))]
struct End {
    /// `None` at the end.
    errands: Option<std::sync::mpsc::Sender<Told>>,
    done: std::sync::mpsc::Receiver<(u64, Done)>,
    thread: Option<std::thread::JoinHandle<()>>,
}

#[cfg(not(target_arch = "wasm32"))]
impl End {
    fn new() -> Self {
        use std::sync::mpsc::channel;
        let (errands, requested) = channel::<Told>();
        let (answered, done) = channel();
        let thread = std::thread::spawn(move || {
            let mut studio = None;
            while let Ok(Told { errand, work, studio: number }) = requested.recv() {
                if let Some(done) = run(&mut studio, errand, &work) {
                    // The window is gone where nobody waits for the answer.
                    let _ = answered.send((number, done));
                }
                work.wake();
            }
        });
        Self { errands: Some(errands), done, thread: Some(thread) }
    }

    fn send(&mut self, told: Told) {
        if let Some(errands) = &self.errands {
            // If the thread has ended, `wait` says so.
            let _ = errands.send(told);
        }
    }

    /// Ends the thread. Some drivers crash if the program ends while a thread uses them.
    fn finish(&mut self) {
        self.errands = None;
        if let Some(thread) = self.thread.take() {
            // If it panicked, this has been reported.
            let _ = thread.join();
        }
    }

    /// An answer, and the number of the studio that gave it. Without a number, the thread has ended.
    fn wait(&mut self, patience: Duration) -> Option<(Option<u64>, Done)> {
        use std::sync::mpsc::RecvTimeoutError;
        match self.done.recv_timeout(patience) {
            Ok((studio, done)) => Some((Some(studio), done)),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => {
                let ended = rhytid_core::Error::Internal("the thread that draws has ended".to_owned());
                Some((None, Done { job: None, result: Err(ended) }))
            }
        }
    }
}

#[cfg(target_arch = "wasm32")]
struct End {
    studio: Option<Studio>,
    done: VecDeque<(u64, Done)>,
}

#[cfg(target_arch = "wasm32")]
impl End {
    fn new() -> Self {
        Self { studio: None, done: VecDeque::new() }
    }

    fn send(&mut self, told: Told) {
        let done = run(&mut self.studio, told.errand, &told.work);
        self.done.extend(done.map(|done| (told.studio, done)));
    }

    fn finish(&mut self) {}

    fn wait(&mut self, _: Duration) -> Option<(Option<u64>, Done)> {
        self.done.pop_front().map(|(studio, done)| (Some(studio), done))
    }
}
