//! What is there without the feature `vulkan`: errors that say so.
use super::{RhytidVulkanHost, RhytidVulkanSlice};
use crate::animator::{RhytidAnimator, RhytidAnimatorOptions};
use crate::status::{Failure, Result};
use rhytid::{Rig, Stage};

/// There is none.
pub(crate) enum Device {}

pub(super) unsafe fn device(_: &RhytidVulkanHost) -> Result<Device> {
    Err(Failure::left_out("vulkan"))
}

pub(super) fn animator(device: &Device, _: &Rig, _: &RhytidAnimatorOptions) -> Result<*mut RhytidAnimator> {
    match *device {}
}

pub(super) fn with_queue(device: &Device, _: impl FnOnce()) -> Result {
    match *device {}
}

pub(super) unsafe fn evaluate(
    _: &mut RhytidAnimator,
    _: &[f32],
    _: &[u64],
    _: &[u64],
) -> Result<rhytid::Result<()>> {
    Err(Failure::left_out("vulkan"))
}

pub(super) fn results(_: &mut RhytidAnimator, _: Stage) -> Result<Vec<RhytidVulkanSlice>> {
    Err(Failure::left_out("vulkan"))
}
