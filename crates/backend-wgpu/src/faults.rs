//! All faults that wgpu reports, as [`Error::Device`].
use rhytid_core::{DeviceErrorKind, Error};
use std::pin::Pin;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::task::{Context, Poll, Waker};

/// An [`Error::Device`].
pub(crate) fn error(kind: DeviceErrorKind, device: &str, message: impl Into<String>) -> Error {
    Error::Device { kind, device: device.to_owned(), message: message.into() }
}

/// The meaning of an error of wgpu that occurred while `doing` something.
pub(crate) fn error_of(fault: &wgpu::Error, device: &str, doing: &str) -> Error {
    use DeviceErrorKind::{Driver, OutOfMemory};
    match fault {
        wgpu::Error::OutOfMemory { source } => {
            let message = format!(
                "out of memory while {doing} ({}); use smaller batches, a basis stored as fp16 or another device",
                sentence(&source.to_string())
            );
            error(OutOfMemory, device, message)
        }
        wgpu::Error::Validation { description, .. } => {
            error(Driver, device, format!("{doing} was refused: {}", sentence(description)))
        }
        wgpu::Error::Internal { description, .. } => {
            error(Driver, device, format!("{doing} failed: {}", sentence(description)))
        }
    }
}

/// One sentence from wgpu's message, which is a tree of indented lines under a heading.
fn sentence(message: &str) -> String {
    let lines = message.lines().map(str::trim);
    let lines: Vec<&str> = lines
        .filter(|line| !matches!(*line, "" | "Validation Error" | "Internal Error" | "Caused by:"))
        .collect();
    lines.join(": ")
}

/// The faults that a device reports outside the calls of this crate. A host application has its own handlers.
/// For its device there are only the faults that this crate detects.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    /// Why the device was lost.
    pub lost: OnceLock<String>,
    uncaptured: Mutex<Option<wgpu::Error>>,
}

impl Faults {
    /// Collects the faults of `device` from now on. By default wgpu would panic.
    pub(crate) fn new(device: &wgpu::Device) -> Arc<Self> {
        let faults = Arc::new(Self::default());
        let uncaptured = faults.clone();
        device.on_uncaptured_error(Arc::new(move |fault| {
            *uncaptured.uncaptured.lock().unwrap_or_else(PoisonError::into_inner) = Some(fault);
        }));
        let lost = faults.clone();
        device.set_device_lost_callback(move |reason, message| {
            let _ = lost.lost.set(format!("{reason:?}: {}", sentence(&message)));
        });
        faults
    }

    /// The last uncaptured error.
    pub(crate) fn take_uncaptured(&self) -> Option<wgpu::Error> {
        self.uncaptured.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

type ErrorFuture = Pin<Box<dyn Future<Output = Option<wgpu::Error>> + Send>>;

/// The errors of calls that were made within [`scoped`]. They are known at once, except in browsers.
#[derive(Default)]
pub(crate) struct Pending(Vec<ErrorFuture>);

/// Runs `calls`, and puts their errors into `pending`.
pub(crate) fn scoped<T>(device: &wgpu::Device, pending: &mut Pending, calls: impl FnOnce() -> T) -> T {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
    let result = calls();
    // The innermost scope comes first. But lack of memory is reported first, since the others follow from it.
    let [internal, validation]: [ErrorFuture; 2] = [Box::pin(internal.pop()), Box::pin(validation.pop())];
    pending.0.extend([Box::pin(memory.pop()) as ErrorFuture, internal, validation]);
    result
}

impl Pending {
    /// The first error that is known without waiting.
    pub(crate) fn known(&mut self) -> Option<wgpu::Error> {
        let mut first = None;
        self.0.retain_mut(|future| match future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(fault) => {
                first = first.take().or(fault);
                false
            }
            Poll::Pending => true,
        });
        first
    }

    /// The first error, as soon as all are known.
    pub(crate) async fn all(&mut self) -> Option<wgpu::Error> {
        let mut first = None;
        for future in std::mem::take(&mut self.0) {
            first = first.or(future.await);
        }
        first
    }
}

impl std::fmt::Debug for Pending {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Pending").field(&self.0.len()).finish()
    }
}
