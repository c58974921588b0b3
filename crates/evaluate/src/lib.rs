//! Measures how good a rig is, and where it is not:
//!
//! - the error of each example if the rig were solved without it,
//! - the effect of the noise of markers,
//! - the distance from the truth, if there is one,
//! - the frames of a take that would be worth a scan.
//!
//! `docs/evaluate.md` and `docs/coverage.md` explain the results.
//!
//! ```
//! use rhytid_core::NoProgress;
//! use rhytid_evaluate::{Regions, evaluate};
//!
//! # let face = rhytid_demo::face(1_000);
//! # let device = rhytid_devices::choose_devices("cpu:0", rhytid_devices::Guard::NONE, &NoProgress)?.devices;
//! // `face` from rhytid_formats::project::read.
//! let (_, found, _) = evaluate(&face, |rig| Ok((Regions::by_handles(rig), None)), &device, &NoProgress)?;
//! let left_out = found.leave_one_out.expect("it has examples");
//! println!("{:.2} mm, most in the region {}", left_out.all.rms_mm, left_out.all.regions[0].region);
//! assert_eq!(left_out.examples.len(), face.examples.len());
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod blendshapes;
pub mod coverage;
mod errors;
mod evaluation;
mod mixtures;
mod noise;
mod regions;
mod strain_curves;
mod truth;
mod wrinkle_masks;

pub use errors::{Errors, RegionError, SkinErrors};
pub use evaluation::{Evaluation, Faded, LeaveOneOut, LeftOut, Map, NoiseAnswer, Subject, evaluate};
pub use noise::NOISE_MM;
pub use regions::Regions;
pub use strain_curves::StrainCurves;
pub use truth::{Comparison, Truth};
pub use wrinkle_masks::WrinkleMasks;
