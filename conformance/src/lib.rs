//! Conformance: a device's results, compared stage by stage with the kernels' `f64` reference.
//!
//! [`run_case`] runs one of the [`cases()`], and [`run_device`] runs all of them. Each [`Outcome`] is one
//! stage of one case on one device. Each kernel's reference gets the same inputs as the device's kernel. A
//! difference therefore belongs to one kernel, and may be no larger than the rounding of that kernel alone
//! ([`mod@tolerance`]). [`Report`] writes the results down. In a browser, where nothing may block,
//! [`run_device_async`] runs an [`AsyncDevice`].
//!
//! ```
//! use rhytid_conformance::{Suite, run_device};
//! use rhytid_core::{Backend, Device};
//! use rhytid_backend_cpu::Cpu;
//!
//! // Any backend's device; yours too.
//! let device = Device::open::<Cpu>(&Cpu::devices()?[0])?;
//! let report = run_device(&device, Suite::Quick, |_name, _done, _total| true);
//! assert!(report.outcomes.iter().all(|outcome| outcome.is_acceptable()));
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod bandwidth;
mod case;
mod compare;
mod distances;
mod driven;
mod evaluation;
pub mod expectations;
mod expected;
mod must_pass;
mod mutant;
mod numbers;
mod outcome;
mod recipe;
pub mod reference;
pub mod report;
mod run;
mod suite;
pub mod tolerance;

pub use bandwidth::{Memory, read_bandwidth};
pub use case::{Built, Case, Suite, TIMED_VERTICES, cases, timing_case};
pub use compare::{Difference, worst_difference};
pub use driven::{AsyncDevice, AsyncSession, WaitingSession};
pub use evaluation::{Results, detail_params, evaluate, pivoted_weights, squared_differences};
pub use expected::Expected;
pub use must_pass::{check_must_pass, must_pass};
pub use mutant::{run_mutants, run_mutants_against};
pub use numbers::Numbers;
pub use outcome::{Measured, Outcome, StageName, Verdict, device_label, kernel_name, stage_name};
pub use report::Report;
pub use run::{ReferenceOf, run_case, run_case_against};
pub use suite::{
    DeviceReport, StageTime, missing_devices, no_device, required_backends, run_device, run_device_async,
    unknown_backends,
};

/// The commit that this program was built from, or `unknown`.
pub const COMMIT: &str = env!("RHYTID_COMMIT");
