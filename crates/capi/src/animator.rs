//! Animators: a rig on a device, frames in, stages out.
use crate::arguments::{array, array_mut, free, give, object_mut, out, text};
use crate::enums::{self, RHYTID_STAGE_COUNT, RhytidBasis};
use crate::held::Held;
use crate::rig::{RhytidRig, rig_of};
use crate::status::{Failure, Result, RhytidStatus, c_text, guarded, told};
use rhytid::{AnimatorOptions, Rig, Stage, UploadOptions};
use std::ffi::{CString, c_char};
use std::ptr::{null, null_mut};

/// A rig on a device, and the results of the last batch. One thread at a time uses it, and any thread may.
/// Threads that evaluate at the same time have an animator each.
pub struct RhytidAnimator {
    pub(crate) held: Held,
    /// Numbers of a frame, in the order of [`Stage::ALL`].
    values: [usize; RHYTID_STAGE_COUNT],
    handles: usize,
    device: CString,
    /// Frames of the last batch.
    pub(crate) frames: usize,
    /// A stage that was read.
    copy: Vec<f32>,
}

/// How an animator is made. rhytid_animator_options() gives the defaults, which a program then changes.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct RhytidAnimatorOptions {
    /// A device such as "vulkan:0", or a backend such as "wgpu" for its first device. NULL for the first GPU,
    /// or for the processor if there is none. The text is read during the call alone.
    pub device: *const c_char,
    /// The most frames of a batch, at least 1. The animator has memory for so many. By default 1.
    pub max_frames: usize,
    /// How the device keeps the basis: a RhytidBasis. By default RHYTID_BASIS_F32.
    pub basis: u32,
}

impl RhytidAnimatorOptions {
    /// The library's own defaults. A new option of the library does not compile here until C has it.
    fn library() -> Self {
        let AnimatorOptions { device, upload: UploadOptions { max_frames, basis } } =
            AnimatorOptions::default();
        debug_assert!(device.is_none());
        Self { device: null(), max_frames, basis: RhytidBasis::of(basis) as u32 }
    }

    pub(crate) fn upload(&self) -> Result<UploadOptions> {
        Ok(UploadOptions { max_frames: self.max_frames, basis: enums::basis(self.basis)? })
    }
}

impl RhytidAnimator {
    pub(crate) fn new(held: Held, device: &str, rig: &Rig) -> Self {
        Self {
            held,
            values: Stage::ALL.map(|stage| stage.values_per_frame(rig)),
            handles: rig.handles().len(),
            device: c_text(device),
            frames: 0,
            copy: Vec::new(),
        }
    }

    /// The id of its device.
    #[cfg(feature = "vulkan")]
    pub(crate) fn device_name(&self) -> String {
        self.device.to_string_lossy().into_owned()
    }

    fn numbers(&self, stage: Stage) -> usize {
        self.frames * self.values[stage as usize]
    }

    /// The last batch's number of frames, after `evaluated`.
    pub(crate) fn keep_frames(&mut self, positions: &[f32], evaluated: rhytid::Result<()>) -> Result {
        // After an error of the input, the results of the last batch are kept.
        evaluated?;
        self.frames = positions.len() / (3 * self.handles);
        Ok(())
    }
}

/// The options that rhytid_animator_new() takes for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhytid_animator_options() -> RhytidAnimatorOptions {
    RhytidAnimatorOptions::library()
}

/// Uploads a rig to a device. This takes a while; after it, only positions of handles go to the device.
///
/// options may be NULL for the defaults. *animator becomes the animator, to be freed by
/// rhytid_animator_free(), or NULL after an error.
///
/// Errors: RHYTID_STATUS_DEVICE_… if there is no such device or the rig does not fit on it,
/// RHYTID_STATUS_INPUT_… if the options do not fit the rig.
///
/// # Safety
/// `rig` leads to a rig, `options` is null or leads to options, and `animator` leads to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_animator_new(
    rig: *const RhytidRig,
    options: *const RhytidAnimatorOptions,
    animator: *mut *mut RhytidAnimator,
) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees all of them.
        let (animator, rig) = unsafe { (out(animator, "animator", null_mut())?, &rig_of(rig)?.rig) };
        // SAFETY: the caller guarantees this.
        let options = unsafe { options_of(options) };
        // SAFETY: the caller guarantees that the options' text is one.
        let device = unsafe { text(options.device, "the device of the options") }?;
        let (held, device) = Held::new(rig, device, options.upload()?)?;
        *animator = give(RhytidAnimator::new(held, &device, rig));
        Ok(())
    })
}

/// The options of an argument, or the defaults.
///
/// # Safety
/// `options` is null or leads to options.
pub(crate) unsafe fn options_of(options: *const RhytidAnimatorOptions) -> RhytidAnimatorOptions {
    // SAFETY: the caller guarantees this.
    unsafe { options.as_ref() }.copied().unwrap_or_else(RhytidAnimatorOptions::library)
}

/// Frees an animator, after waiting for its device. NULL is ignored.
///
/// # Safety
/// `animator` is null or an animator that nobody uses any more, nor memory that it lent.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_animator_free(animator: *mut RhytidAnimator) {
    // SAFETY: the caller guarantees this.
    unsafe { free(animator) };
}

/// The id of the animator's device, such as "vulkan:0". The memory is the animator's. NULL for NULL.
///
/// # Safety
/// `animator` is null or a live animator.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_animator_device(animator: *const RhytidAnimator) -> *const c_char {
    // SAFETY: the caller guarantees this.
    told(null(), || Some(unsafe { animator.as_ref() }?.device.as_ptr()))
}

/// The numbers of one frame of a stage, a RhytidStage. A batch has so many for each of its frames. 0 if there
/// is no such stage, and for NULL.
///
/// # Safety
/// `animator` is null or a live animator.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_animator_values(animator: *const RhytidAnimator, stage: u32) -> usize {
    // SAFETY: the caller guarantees this.
    told(0, || Some(unsafe { animator.as_ref() }?.values[enums::stage(stage).ok()? as usize]))
}

/// Evaluates a batch of frames. The results replace those of the last batch, and memory that was lent by
/// rhytid_animator_map() is not valid any more.
///
/// positions has count numbers: frames × H × 3, mesh units, in the order of rhytid_rig_handle_label(). It may
/// be changed after the call. On a GPU the batch may still be running after the call.
///
/// Errors: RHYTID_STATUS_INPUT_MISMATCH for a count that is no multiple of 3 H above 0,
/// RHYTID_STATUS_INPUT_TOO_LARGE for too many frames, RHYTID_STATUS_INPUT_OUT_OF_RANGE for a number that is
/// not finite, RHYTID_STATUS_DEVICE_… if the device fails. After the first three, the results of the last
/// batch are kept.
///
/// # Safety
/// `animator` leads to an animator, and from `positions` on there are `count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_animator_evaluate(
    animator: *mut RhytidAnimator,
    positions: *const f32,
    count: usize,
) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees both.
        let (animator, positions) =
            unsafe { (animator_of(animator)?, array(positions, count, "positions")?) };
        let evaluated = animator.held.evaluate(positions);
        animator.keep_frames(positions, evaluated)
    })
}

/// Waits for the last batch, and copies a stage of it, a RhytidStage, to numbers: frames ×
/// rhytid_animator_values(). capacity says how many numbers have room there.
///
/// Errors: RHYTID_STATUS_ARGUMENT if there is too little room, RHYTID_STATUS_INPUT_EMPTY if no batch was
/// evaluated, RHYTID_STATUS_DEVICE_…. Then numbers are as they were.
///
/// # Safety
/// `animator` leads to an animator, and from `numbers` on there is room for `capacity` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_animator_read(
    animator: *mut RhytidAnimator,
    stage: u32,
    numbers: *mut f32,
    capacity: usize,
) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees both.
        let (animator, out) = unsafe { (animator_of(animator)?, array_mut(numbers, capacity, "numbers")?) };
        let stage = enums::stage(stage)?;
        let needed = animator.numbers(stage);
        let Some(out) = out.get_mut(..needed) else {
            let frames = animator.frames;
            let sentence = format!("capacity is {capacity}, expected {needed} at least for {frames} frames");
            return Err(Failure::argument(sentence));
        };
        Ok(animator.held.stage(stage, &mut animator.copy, |numbers| out.copy_from_slice(numbers))?)
    })
}

/// Waits for the last batch, and lends a stage of it, a RhytidStage: *numbers becomes the address of frames ×
/// rhytid_animator_values() numbers, and *count how many there are. No memory of the program is needed. The
/// memory is the animator's, and valid until the next call with this animator other than of a fact. On the
/// processor, strains, positions and normals are not copied. With Vulkan, the device writes into this memory.
/// Other stages and backends are copied once.
///
/// Errors: as rhytid_animator_read(). Then *numbers is NULL and *count is 0.
///
/// # Safety
/// `animator` leads to an animator, `numbers` to a pointer, and `count` to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_animator_map(
    animator: *mut RhytidAnimator,
    stage: u32,
    numbers: *mut *const f32,
    count: *mut usize,
) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees both.
        let (numbers, count) = unsafe { (out(numbers, "numbers", null())?, out(count, "count", 0)?) };
        // SAFETY: the caller guarantees this.
        let animator = unsafe { animator_of(animator) }?;
        let lent = |lent: &[f32]| (*numbers, *count) = (lent.as_ptr(), lent.len());
        Ok(animator.held.stage(enums::stage(stage)?, &mut animator.copy, lent)?)
    })
}

/// Waits for the last batch, and says how long the device computed on each stage of it: seconds has
/// RHYTID_STAGE_COUNT places, in the order of RhytidStage. A stage that was computed together with another
/// one has 0. Each is -1 where the device cannot measure.
///
/// Errors: RHYTID_STATUS_INPUT_EMPTY if no batch was evaluated, RHYTID_STATUS_DEVICE_….
///
/// # Safety
/// `animator` leads to an animator, and from `seconds` on there is room for `RHYTID_STAGE_COUNT` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_animator_stage_times(
    animator: *mut RhytidAnimator,
    seconds: *mut f64,
) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees both.
        let (animator, seconds) =
            unsafe { (animator_of(animator)?, array_mut(seconds, RHYTID_STAGE_COUNT, "seconds")?) };
        let times = animator.held.stage_times()?;
        for (i, seconds) in seconds.iter_mut().enumerate() {
            *seconds = times.map_or(-1.0, |times| times[i].as_secs_f64());
        }
        Ok(())
    })
}

/// The animator of an argument.
///
/// # Safety
/// `animator` is null or an animator that no other thread uses meanwhile.
pub(crate) unsafe fn animator_of<'a>(animator: *mut RhytidAnimator) -> Result<&'a mut RhytidAnimator> {
    // SAFETY: the caller guarantees this.
    unsafe { object_mut(animator, "animator", "rhytid_animator_new()") }
}
