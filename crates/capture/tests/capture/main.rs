//! The clean-up of raw takes and the coverage of clean ones.

mod coverage;
mod handles;
mod heads;
mod neutral;
mod online;
mod rates;
mod real_take;
mod repairs;
mod shuffles;
mod spread;
mod steps;
mod upright;
mod video;
