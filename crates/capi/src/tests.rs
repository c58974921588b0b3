//! What a C program cannot do: enumerations against the library's, panics, and a device that is lost.
use crate::animator::{
    RhytidAnimator, rhytid_animator_evaluate, rhytid_animator_free, rhytid_animator_options,
    rhytid_animator_read,
};
use crate::arguments::give;
use crate::enums::{RhytidBasis, RhytidDeviceKind, RhytidMissing, RhytidStage, basis, missing, stage};
use crate::held::Held;
use crate::status::{RhytidStatus, guarded, of_device, of_input, rhytid_last_error, told};
use rhytid::core::{Backend, DeviceErrorKind, DeviceInfo, DeviceKind, HandleFrames, UploadOptions};
use rhytid::{Animator, BasisStorage, InputErrorKind, Missing, Result, Rig, Session, Stage};
use rhytid_test_support::flaky::{Flaky, info};
use rhytid_test_support::triangle;
use std::ffi::CStr;
use std::time::Duration;

/// The sentence of the last error.
fn last() -> String {
    // SAFETY: the library gives a text.
    unsafe { CStr::from_ptr(rhytid_last_error()) }.to_str().unwrap().to_owned()
}

fn animator<B: Backend>(backend: &B, rig: &Rig) -> *mut RhytidAnimator {
    let animator = Animator::new(backend, rig, UploadOptions::frames(1)).unwrap();
    give(RhytidAnimator::new(Held::Any(animator.boxed()), "test:0", rig))
}

#[test]
fn each_value_of_the_library_has_its_own_in_c() {
    let stages =
        Stage::ALL.map(|of| (RhytidStage::of(of) as u32, stage(RhytidStage::of(of) as u32).unwrap()));
    assert_eq!(stages.map(|(_, stage)| stage), Stage::ALL);
    assert_eq!(stages.map(|(number, _)| number), [0, 1, 2, 3, 4, 5]);
    assert_eq!(BasisStorage::ALL.map(|of| basis(RhytidBasis::of(of) as u32).unwrap()), BasisStorage::ALL);
    assert_eq!(Missing::ALL.map(|of| missing(RhytidMissing::of(of) as u32).unwrap()), Missing::ALL);
    let kinds = DeviceKind::ALL.map(|kind| RhytidDeviceKind::of(kind).expect("C has each kind of device"));
    for (i, kind) in kinds.iter().enumerate() {
        assert!(!kinds[..i].contains(kind), "{kind:?}");
    }
    for unknown in [6, u32::MAX] {
        assert_eq!(stage(unknown).unwrap_err().status, RhytidStatus::Argument);
        assert_eq!(basis(unknown).unwrap_err().status, RhytidStatus::Argument);
        assert_eq!(missing(unknown).unwrap_err().status, RhytidStatus::Argument);
    }
}

/// The names of the statuses are those of the library's kinds, too.
#[test]
fn each_kind_of_error_has_its_own_status() {
    for name in InputErrorKind::NAMES {
        let status = of_input(name).unwrap_or_else(|| panic!("RhytidStatus has no value for {name}"));
        assert_eq!(format!("{status:?}"), format!("Input{name}"));
    }
    for kind in DeviceErrorKind::ALL {
        let status = of_device(kind).unwrap_or_else(|| panic!("RhytidStatus has no value for {kind:?}"));
        assert_eq!(format!("{status:?}"), format!("Device{kind:?}"));
    }
}

/// Each variant of RhytidStatus is one of the kinds, or one of the six of its own.
#[test]
fn no_status_is_left_from_a_kind_that_is_gone() {
    let source = include_str!("status.rs");
    let (_, list) = source.split_once("pub enum RhytidStatus {").unwrap();
    let variants = list.split_once("\n}").unwrap().0.lines().filter_map(|line| line.trim().split_once(" = "));
    let names: Vec<&str> = variants.map(|(name, _)| name).filter(|name| !name.starts_with("//")).collect();
    let own = ["Ok", "Argument", "Io", "Cancelled", "Internal", "LeftOut"];
    assert_eq!(
        names.len(),
        own.len() + DeviceErrorKind::ALL.len() + InputErrorKind::NAMES.len(),
        "{names:?}"
    );
}

#[test]
fn the_defaults_are_the_librarys() {
    let options = rhytid_animator_options();
    let library = rhytid::AnimatorOptions::default();
    assert!(options.device.is_null() && library.device.is_none());
    assert_eq!(options.upload().unwrap(), library.upload);
    assert_eq!(missing(0).unwrap(), Missing::default());
    assert_eq!(basis(0).unwrap(), BasisStorage::default());
}

/// What the header says of threads holds by the types: this does not compile otherwise.
#[test]
fn objects_may_be_used_on_threads_as_the_header_says() {
    fn by_many_threads<T: Send + Sync>() {}
    fn by_any_thread<T: Send>() {}
    by_many_threads::<crate::rig::RhytidRig>();
    by_many_threads::<crate::take::RhytidTake>();
    by_many_threads::<crate::devices::RhytidDevices>();
    by_many_threads::<crate::vulkan::RhytidVulkan>();
    by_any_thread::<RhytidAnimator>();
}

#[test]
fn a_panic_becomes_an_error() {
    assert_eq!(guarded(|| panic!("at the {}", "seams")), RhytidStatus::Internal);
    assert!(last().contains("at the seams") && last().contains("report"), "{}", last());
    assert_eq!(guarded(|| panic!("plain")), RhytidStatus::Internal);
    assert!(last().contains("plain"), "{}", last());
    assert_eq!(told(7, || panic!("of a fact")), 7);
    // What succeeds keeps the last sentence.
    assert_eq!(guarded(|| Ok(())), RhytidStatus::Ok);
    assert!(last().contains("plain"), "{}", last());
}

/// A backend whose sessions panic.
struct Panicking;
struct PanickingSession;

impl Backend for Panicking {
    const NAME: &'static str = "panicking";
    type Session = PanickingSession;

    fn devices() -> Result<Vec<DeviceInfo>> {
        Ok(Vec::new())
    }

    fn open(_: &DeviceInfo) -> Result<Self> {
        Ok(Self)
    }

    fn upload(&self, _: &Rig, _: UploadOptions) -> Result<PanickingSession> {
        Ok(PanickingSession)
    }
}

impl Session for PanickingSession {
    fn evaluate(&mut self, _: HandleFrames<'_>) -> Result<()> {
        panic!("within a batch")
    }

    fn read(&mut self, _: Stage, _: &mut Vec<f32>) -> Result<()> {
        panic!("within a read")
    }

    fn stage_times(&mut self) -> Result<Option<[Duration; 6]>> {
        panic!("within the times")
    }
}

impl Drop for PanickingSession {
    fn drop(&mut self) {
        panic!("within the end")
    }
}

#[test]
fn no_panic_of_a_backend_crosses_the_border() {
    let animator = animator(&Panicking, &triangle());
    // SAFETY: the animator is alive until it is freed.
    unsafe {
        assert_eq!(rhytid_animator_evaluate(animator, [0.0; 3].as_ptr(), 3), RhytidStatus::Internal);
        assert!(last().contains("within a batch"), "{}", last());
        rhytid_animator_free(animator);
    }
}

#[test]
fn a_lost_device_is_an_error_of_its_own() {
    let rig = triangle();
    let flaky = Flaky::open(&info("evaluate:1")).unwrap();
    let animator = animator(&flaky, &rig);
    let mut numbers = [7.0; 9];
    let positions = RhytidStage::Positions as u32;
    // SAFETY: the animator is alive until it is freed, and all arrays have their lengths.
    unsafe {
        assert_eq!(rhytid_animator_evaluate(animator, [0.0, 0.0, 2.0].as_ptr(), 3), RhytidStatus::Ok);
        assert_eq!(rhytid_animator_read(animator, positions, numbers.as_mut_ptr(), 9), RhytidStatus::Ok);
        assert_eq!(numbers, [0.0, 0.0, 2.0, 4.0, 0.0, 1.0, 0.0, 4.0, 0.0]);
        assert_eq!(rhytid_animator_evaluate(animator, [0.0; 3].as_ptr(), 3), RhytidStatus::DeviceLost);
        assert!(last().contains("unplugged"), "{}", last());
        // Nothing is there to read, and what was read before is untouched.
        let before = numbers;
        let status = rhytid_animator_read(animator, positions, numbers.as_mut_ptr(), 9);
        assert_eq!((status, numbers), (RhytidStatus::InputEmpty, before));
        rhytid_animator_free(animator);
    }
}
