//! Files that arrive while the page keeps running.

use eframe::egui;
use std::sync::{Arc, Mutex, PoisonError};

/// A file's name, and its contents or the reason why they cannot be read.
pub type Read = (String, Result<Vec<u8>, String>);

/// A place for files that have been read. The viewer opens them together.
#[derive(Debug, Clone)]
pub struct Inbox {
    files: Arc<Mutex<Vec<Read>>>,
    context: egui::Context,
}

impl Inbox {
    pub(crate) fn new(context: &egui::Context) -> Self {
        Self { files: Arc::default(), context: context.clone() }
    }

    /// Adds files, and wakes the viewer.
    pub fn put(&self, files: Vec<Read>) {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).extend(files);
        self.context.request_repaint();
    }

    pub(crate) fn take(&self) -> Vec<Read> {
        std::mem::take(&mut self.files.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
