//! The options of `rhytid animate`, for a program that holds the rig and the take itself.

use crate::args::Animate;
use crate::call::{Caller, parse_animate};
use crate::cmd::animate::{onto, options, perform};
use crate::inputs;
use crate::progress::Ui;
use rhytid::core::{DeviceInfo, rig_file};
use rhytid::formats::animation::Format;
use rhytid::formats::export::Options;
use rhytid::playback::Performance;
use rhytid::{Result, Rig, Take};
use std::ffi::OsString;
use std::path::Path;

/// The options of `rhytid animate` in their own words, with their checks and defaults.
pub struct Animation(Box<Animate>);

impl Animation {
    /// From words such as `--fps` and `24`. `take` is the take's file, if there is one. `output` is the file
    /// that is written, if there is one: its format decides which options are allowed.
    ///
    /// # Errors
    /// [`rhytid::Error::Input`] for an unknown option, for a wrong value, and for an option that does not
    /// suit the format.
    pub fn parse(words: Vec<OsString>, take: Option<&Path>, output: Option<&Path>) -> Result<Self> {
        let take = take.unwrap_or(Path::new("take.csv"));
        let output = output.unwrap_or(Path::new("frames.usd"));
        let places = ["animate".into(), "rig.safetensors".into(), take.into(), "-o".into(), output.into()];
        let words = places.into_iter().chain(words).collect();
        let args = parse_animate(words)?;
        options::check(&args, Format::from_extension(output)?)?;
        Ok(Self(args))
    }

    /// The take in a file, in full, as `animate` reads it.
    ///
    /// # Errors
    /// As [`rhytid::playback::read_take`].
    pub fn take(&self, path: &Path, rig: &Rig, caller: Caller) -> Result<Take> {
        inputs::take(path, rig, &self.0.reading, &Ui::for_program(caller))
    }

    /// The frames that are asked for, of a take that was read.
    ///
    /// # Errors
    /// As [`Performance::new`].
    pub fn perform(&self, rig: Rig, take: Take) -> Result<Performance> {
        let layers = inputs::layers(self.0.edit.as_deref(), &rig, &self.0.reading)?;
        let format = Format::from_extension(&self.0.output)?;
        let recipe = options::recipe(&self.0, rig_file::hash_of(&rig)?, format, layers.as_ref())?;
        perform(&self.0, rig, layers, recipe, take)
    }

    /// The devices that are asked for, the first to be taken first.
    ///
    /// # Errors
    /// As [`rhytid::devices::choose_devices`].
    pub fn devices(&self, caller: Caller) -> Result<Vec<DeviceInfo>> {
        inputs::devices(inputs::named_device(&self.0.device)?, &Ui::for_program(caller))
    }

    /// What the exporter of the file is told.
    ///
    /// # Errors
    /// As reading the shapes of `--onto`.
    pub fn export_options(&self, performance: &Performance, caller: Caller) -> Result<Options> {
        let rig = &performance.rig;
        let onto = onto(&self.0, rig, &performance.recipe, &Ui::for_program(caller))?;
        Ok(options::export_options(&self.0, rig.surface().metres_per_unit, onto))
    }
}
