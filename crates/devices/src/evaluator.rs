//! Evaluation with fall-back: batches go to the first of several devices, and to the next one if it fails.

use crate::watch::Watch;
use rhytid_core::{
    Animator, Device, DeviceErrorKind, DeviceInfo, Error, Result, Rig, Session, Stage, UploadOptions,
};
use std::collections::VecDeque;
use std::iter;

/// Opens a device: [`crate::backends::open`], except in tests.
pub type Open<'a> = &'a (dyn Fn(&DeviceInfo) -> Result<Device> + Sync);

/// A rig on a device, and the devices to fall back on.
pub struct Evaluator<'a> {
    rig: &'a Rig,
    options: UploadOptions,
    open: Open<'a>,
    current: Current<'a>,
    next: VecDeque<DeviceInfo>,
}

impl<'a> Evaluator<'a> {
    /// Makes `rig` resident on the first of `devices` that has room for it. The devices behind it are kept
    /// for later.
    ///
    /// # Errors
    /// The last device's error, if none has room; [`Error::Internal`] if there are no devices.
    pub fn new(rig: &'a Rig, options: UploadOptions, devices: &[DeviceInfo], open: Open<'a>) -> Result<Self> {
        let mut next: VecDeque<DeviceInfo> = devices.iter().cloned().collect();
        let none = || Error::Internal("no device to evaluate on".into());
        let current = upload_to_next(rig, options, open, &mut next, none())?;
        Ok(Self { rig, options, open, current, next })
    }

    /// Makes a part of the rig, with all of its handles, resident on the present device. It has the same
    /// devices to fall back on.
    ///
    /// # Errors
    /// As [`Evaluator::new`].
    pub fn of_part<'b>(&self, part: &'b Rig) -> Result<Evaluator<'b>>
    where
        'a: 'b,
    {
        let devices: Vec<DeviceInfo> = iter::once(&self.current.info).chain(&self.next).cloned().collect();
        Evaluator::new(part, self.options, &devices, self.open)
    }

    /// The device that evaluates now.
    pub fn device(&self) -> &DeviceInfo {
        &self.current.info
    }

    /// Evaluates a batch of frames × H handle positions and reads `stages` of it into `results`, one each. If
    /// a device fails, the next one evaluates the whole batch again. So `results` comes from one device.
    ///
    /// # Errors
    /// As [`Animator::evaluate`], if there is no further device to fall back on.
    pub fn evaluate(
        &mut self,
        handle_positions: &[f32],
        stages: &[Stage],
        results: &mut [Vec<f32>],
    ) -> Result<()> {
        while let Err(error) = self.current.evaluate(handle_positions, stages, results) {
            if !is_of_the_device(&error) {
                return Err(error);
            }
            self.current = upload_to_next(self.rig, self.options, self.open, &mut self.next, error)?;
        }
        Ok(())
    }
}

/// A device that a rig is on.
struct Current<'a> {
    info: DeviceInfo,
    animator: Animator<Box<dyn Session>>,
    /// `None` for the processor.
    watch: Option<Watch<'a>>,
}

impl<'a> Current<'a> {
    /// Uploads `rig` to a device. The device must compute a frame of it as the processor does.
    fn new(rig: &'a Rig, options: UploadOptions, info: DeviceInfo, open: Open<'_>) -> Result<Self> {
        let mut animator = open(&info)?.upload(rig, options)?;
        let watch = Watch::begin(rig, options, &info, &mut animator)?;
        Ok(Self { info, animator, watch })
    }

    fn evaluate(
        &mut self,
        handle_positions: &[f32],
        stages: &[Stage],
        results: &mut [Vec<f32>],
    ) -> Result<()> {
        self.animator.evaluate(handle_positions)?;
        for (stage, out) in stages.iter().zip(&mut *results) {
            self.animator.read(*stage, out)?;
        }
        match &mut self.watch {
            Some(watch) => watch.batch(handle_positions, stages, results),
            None => Ok(()),
        }
    }
}

/// Whether another device may succeed: this one was lost, is full or is otherwise at fault.
fn is_of_the_device(error: &Error) -> bool {
    matches!(error, Error::Device { .. })
}

/// Uploads to the first device of `next` that accepts the rig. Devices are removed from the queue. `error` is
/// the failure of the last device.
fn upload_to_next<'a>(
    rig: &'a Rig,
    options: UploadOptions,
    open: Open<'_>,
    next: &mut VecDeque<DeviceInfo>,
    mut error: Error,
) -> Result<Current<'a>> {
    while let Some(info) = next.pop_front() {
        if let Error::Device { .. } = error {
            log::warn!("{error}; going on with {} ({})", info.id(), info.name);
        }
        match Current::new(rig, options, info, open) {
            Ok(current) => return Ok(current),
            Err(e) if is_of_the_device(&e) => error = e,
            Err(e) => return Err(e),
        }
    }
    Err(advised(error))
}

/// Adds what the user can do, if no other device is left.
fn advised(error: Error) -> Error {
    match error {
        Error::Device { kind: kind @ DeviceErrorKind::OutOfMemory, device, message } => {
            let message = format!("{message}; use a device with more memory");
            Error::Device { kind, device, message }
        }
        Error::Device { kind: kind @ DeviceErrorKind::Lost, device, message } => {
            let message = format!("{message}; start again, or use another device");
            Error::Device { kind, device, message }
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::NoProgress;

    use rhytid_solve::solve;
    use rhytid_test_support::flaky::{Flaky, info, watched};

    const STAGES: [Stage; 2] = [Stage::Positions, Stage::Normals];

    /// All frames of the demo's performance in batches of five, evaluated with fall-back by these devices.
    fn play(devices: &[&str]) -> (Result<[Vec<f32>; 2]>, String) {
        let face = rhytid_demo::face(1_000);
        let rig = solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let handles =
            rhytid_demo::performance(&face).slice(0..23).handle_positions(&rig.handles().labels).unwrap();
        let devices: Vec<DeviceInfo> = devices.iter().map(|name| watched(name)).collect();
        let open: Open<'_> = &Device::open::<Flaky>;
        let mut evaluator = match Evaluator::new(&rig, UploadOptions::frames(5), &devices, open) {
            Ok(evaluator) => evaluator,
            Err(error) => return (Err(error), String::new()),
        };
        let mut all = [Vec::new(), Vec::new()];
        let mut results = [Vec::new(), Vec::new()];
        for batch in handles.chunks(5 * 3 * rig.handles().len()) {
            if let Err(error) = evaluator.evaluate(batch, &STAGES, &mut results) {
                return (Err(error), evaluator.device().name.clone());
            }
            all.iter_mut().zip(&results).for_each(|(all, results)| all.extend_from_slice(results));
        }
        (Ok(all), evaluator.device().name.clone())
    }

    #[test]
    fn no_frame_is_lost_or_repeated_when_devices_fail() {
        let (whole, _) = play(&["sound"]);
        let whole = whole.unwrap();
        assert!(!whole[0].is_empty());
        for (devices, last) in [
            (&["evaluate:0", "sound"][..], "sound"),
            (&["evaluate:3", "sound"], "sound"),
            (&["read:4", "sound"], "sound"),
            (&["upload", "read:1", "upload", "evaluate:1", "sound"], "sound"),
            (&["sound", "upload"], "sound"),
            (&["nothing", "sound"], "sound"),
            (&["dark:3", "flipped:2", "late:1", "sound"], "sound"),
        ] {
            let (found, on) = play(devices);
            assert!(found.unwrap() == whole, "{devices:?}");
            assert_eq!(on, last, "{devices:?}");
        }
    }

    #[test]
    fn the_last_device_is_an_error() {
        for (devices, expected, words) in [
            (&["read:2"][..], DeviceErrorKind::Lost, "unplugged; start again"),
            (&["evaluate:1", "upload"], DeviceErrorKind::OutOfMemory, "full; use a device with more memory"),
        ] {
            let Err(Error::Device { kind, message, .. }) = play(devices).0 else { panic!("{devices:?}") };
            assert!(kind == expected && message.contains(words), "{kind:?}: {message}");
        }
    }

    #[test]
    fn a_mistake_of_the_input_is_no_reason_to_change_the_device() {
        let face = rhytid_demo::face(1_000);
        let rig = solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let devices = [info("sound"), info("sound")];
        let mut evaluator =
            Evaluator::new(&rig, UploadOptions::frames(1), &devices, &Device::open::<Flaky>).unwrap();
        let error = evaluator.evaluate(&[0.0; 4], &STAGES, &mut [Vec::new(), Vec::new()]).unwrap_err();
        assert!(matches!(error, Error::Input(_)), "{error}");
        assert_eq!(evaluator.next.len(), 1);
    }
}
