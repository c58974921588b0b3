//! The clean-up of raw takes and the coverage of clean ones.

mod coverage;
mod handles;
mod real_take;
mod repairs;
mod spread;
mod steps;
mod upright;
