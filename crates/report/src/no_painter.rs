//! The stand-in for the painter without the feature `render`, which draws nothing.

use crate::shot::{Drawn, Shot};
use rhytid_core::{Face, Result, Rig};
use std::path::Path;

/// The painter of the pages' pictures. There is none in a build without the feature `render`.
#[derive(Debug)]
pub enum Painter {}

impl Painter {
    pub(crate) fn draw(&self, _: &Rig, _: &[[u32; 3]], _: [u32; 2], _: &[Shot<'_>]) -> Result<Vec<Drawn>> {
        match *self {}
    }

    pub(crate) fn grey(&self) -> [u8; 3] {
        match *self {}
    }

    pub(crate) fn colour(&self, _: f32) -> [u8; 3] {
        match *self {}
    }
}

/// Draws handles on a mesh, with the feature `render`.
///
/// # Errors
/// None.
pub fn write_handles(_: &Path, _: &Face, _: &[bool], _: &[[f64; 3]], painter: &Painter) -> Result<()> {
    match *painter {}
}
