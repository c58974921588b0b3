//! A layer that was opened, with its time samples still to be read.

use crate::layer::{Layer, Value};
use rhytid_core::Result;

/// How [`Opened::unread`] names a variant set: these words, and its name.
pub(crate) const VARIANT_SET: &str = "the variant set";

/// A layer, and its time samples to be read.
pub struct Opened {
    /// All but the samples. Attributes that have some are numbered from 0.
    pub layer: Layer,
    /// The samples by these numbers.
    pub samples: Box<dyn Samples>,
    /// What was left out, by name: fields and values of types that [`Value`] does not have, variants,
    /// classes.
    pub unread: Vec<String>,
}

/// The time samples of a layer. Memory does not grow with what they hold.
pub trait Samples: Send {
    /// The time codes of the attribute numbered `n`, ascending.
    fn times(&self, n: usize) -> &[f64];

    /// The value at the `i`-th of [`Samples::times`].
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if the value is blocked, of a type that [`Value`] does not have or
    /// damaged; [`rhytid_core::Error::Io`].
    fn read(&mut self, n: usize, i: usize) -> Result<Value>;
}
