//! Synchronisation: the validation layer reports nothing, and reports an error if a barrier is missing.
use super::support::{SMALL, devices, evaluate, rig, take, validated};
use rhytid_core::plan::PlanLimits;
use rhytid_core::{BasisStorage, DeviceErrorKind, Error, HandleFrames, Session, Stage, UploadOptions};

#[test]
fn validation_is_silent() {
    let rig = rig(SMALL);
    for device in devices() {
        let Some(vulkan) = validated(&device) else { continue };
        let messages = vulkan.context.messages().unwrap();
        let whole = vulkan.context.limits;
        let split = PlanLimits { max_binding_bytes: 8448, max_workgroups: 2 };
        for (limits, basis) in
            [(whole, BasisStorage::F32), (whole, BasisStorage::F16), (split, BasisStorage::F32)]
        {
            let mut session =
                vulkan.upload_within(&rig, UploadOptions { max_frames: 31, basis }, limits).unwrap();
            for frames in [1, 2, 31] {
                evaluate(&mut session, &rig, &take(&rig, frames, 1));
                session.stage_times().unwrap();
            }
            // The session is dropped while the device computes.
            session.evaluate(HandleFrames { positions: &take(&rig, 31, 2), frames: 31 }).unwrap();
        }
        drop(vulkan);
        assert_eq!(messages.all(), [""; 0]);
    }
}

#[test]
fn validation_reports_a_missing_barrier() {
    let rig = rig(SMALL);
    for device in devices() {
        // The next stage reads each of these stages.
        for stage in [Stage::LargeScale, Stage::Detail, Stage::Positions] {
            let Some(vulkan) = validated(&device) else { continue };
            let mut session =
                vulkan.upload_within(&rig, UploadOptions::frames(2), vulkan.context.limits).unwrap();
            evaluate(&mut session, &rig, &take(&rig, 2, 1));
            session.no_barrier_after = Some(stage);
            let hazard = session.evaluate(HandleFrames { positions: &take(&rig, 2, 1), frames: 2 });
            let Err(Error::Device { kind: DeviceErrorKind::Driver, message, .. }) = hazard else {
                panic!("no barrier after {stage:?}, and validation is silent")
            };
            assert!(message.contains("SYNC-HAZARD-READ-AFTER-WRITE"), "{message}");
            // After a message, every session keeps failing.
            session.no_barrier_after = None;
            assert!(session.read(Stage::Positions, &mut Vec::new()).is_err());
            assert!(vulkan.upload_within(&rig, UploadOptions::frames(2), vulkan.context.limits).is_err());
        }
    }
}
