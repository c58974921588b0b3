//! `rhytid._rhytid`, the compiled half of the Python package. The Python half in `rhytid/` has the names that
//! people use.
//!
//! Long work runs on a thread of its own, without Python's lock (`work`). Options are those of the command
//! line, in their own words (`words`), so that they have one list of names, defaults and checks.
#![forbid(unsafe_code)]

mod animation;
mod animator;
mod arrays;
mod command;
mod error;
mod face;
mod log_records;
mod receiver;
mod rig;
mod take;
mod work;

use pyo3::prelude::*;

/// The module.
#[pymodule]
mod _rhytid {
    #[pymodule_export]
    use crate::animation::{Animation, Frame, Frames};
    #[pymodule_export]
    use crate::animator::Animator;
    #[pymodule_export]
    use crate::command::{call, channel_kinds, decode_png, keyword, option_list, run, stages, started_by};
    #[pymodule_export]
    use crate::face::Face;
    #[pymodule_export]
    use crate::receiver::{LiveFrame, Receiver};
    #[pymodule_export]
    use crate::rig::Rig;
    #[pymodule_export]
    use crate::take::Take;
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
