//! Sessions are made and dropped without leaving memory behind, and do not disturb each other. (This is a
//! process of its own, since its whole memory is measured.)
use rhytid_conformance::{Case, Suite, cases};
use rhytid_core::{Device, Stage};
use rhytid_devices::backends::BACKENDS;
use rhytid_test_support::{resident, skip};
use std::sync::{Mutex, PoisonError};

/// Sessions made and dropped.
const SESSIONS: usize = 1000;

/// The first sessions are not counted, since caches and pools fill.
const WARM_UP: usize = 100;

/// The most that memory may grow from the warm-up to the end, in bytes. If each session left its smallest
/// buffer behind, a page, it would grow by 3.6 MB.
const GROWTH: i64 = 3 << 20;

/// One test runs at a time, since the memory of others would be counted too.
static ALONE: Mutex<()> = Mutex::new(());

/// The first device of each backend.
fn first_devices() -> Vec<Device> {
    let found = rhytid_devices::backends::devices();
    let mut devices = Vec::new();
    for backend in BACKENDS {
        match found.devices.iter().find(|device| device.backend == backend.name) {
            Some(info) => {
                devices.push(rhytid_devices::backends::open(info).unwrap_or_else(|e| panic!("{e}")));
            }
            None => skip(&format!("{} has no device here", backend.name)),
        }
    }
    devices
}

fn case(name: &str) -> Case {
    cases(Suite::Full).into_iter().find(|case| case.name == name).unwrap()
}

#[test]
#[cfg(target_os = "linux")]
fn a_thousand_sessions_leave_no_memory_behind() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let case = case("v63-h8-f65-p6-k16-b1-of-2");
    let built = case.build();
    let mut out = Vec::new();
    for device in first_devices() {
        let name = device.info().id();
        let mut session = || {
            let mut animator = device.upload(&built.rig, case.options).unwrap_or_else(|e| panic!("{e}"));
            animator.evaluate(&built.handle_positions).unwrap();
            animator.read(Stage::Normals, &mut out).unwrap();
        };
        (0..WARM_UP).for_each(|_| session());
        let before = resident() as i64;
        (WARM_UP..SESSIONS).for_each(|_| session());
        let growth = resident() as i64 - before;
        println!("{name}: {growth} bytes more after {SESSIONS} sessions than after {WARM_UP}");
        assert!(
            growth < GROWTH,
            "{name}: {growth} bytes more after {SESSIONS} sessions than after {WARM_UP}"
        );
    }
}

/// The test above would see a leak like this one.
#[test]
#[cfg(target_os = "linux")]
fn sessions_that_are_never_dropped_are_noticed() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    // Large enough not to fit into free memory that other tests left on the heap.
    let case = case("v129-h89-f243-p6-k16-b31-of-32");
    let built = case.build();
    let device = first_devices().into_iter().find(|device| device.info().backend == "cpu").unwrap();
    let before = resident() as i64;
    for _ in WARM_UP..SESSIONS {
        std::mem::forget(device.upload(&built.rig, case.options).unwrap());
    }
    assert!(resident() as i64 - before > GROWTH);
}

/// Every stage of a case, in bits.
fn bits(device: &Device, case: &Case) -> Vec<Vec<u32>> {
    let built = case.build();
    let mut animator = device.upload(&built.rig, case.options).unwrap_or_else(|e| panic!("{e}"));
    let mut out = Vec::new();
    let mut bits = Vec::new();
    for _ in 0..10 {
        animator.evaluate(&built.handle_positions).unwrap();
        bits.clear();
        for stage in Stage::ALL {
            animator.read(stage, &mut out).unwrap();
            bits.push(out.iter().map(|x| x.to_bits()).collect());
        }
    }
    bits
}

#[test]
fn two_sessions_on_two_threads_give_what_each_gives_alone() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    // One long and one short batch, of the same sizes and of others.
    let pairs = [
        [case("v1025-h89-f243-p6-k16-b31-of-40"), case("v65-h8-f63-p6-k16-b2-of-3")],
        [case("holes"), case("isolated-vertices")],
    ];
    for device in first_devices() {
        for pair in &pairs {
            let alone = pair.each_ref().map(|case| bits(&device, case));
            for _ in 0..3 {
                let together = std::thread::scope(|scope| {
                    let threads = pair.each_ref().map(|case| scope.spawn(|| bits(&device, case)));
                    threads.map(|thread| thread.join().unwrap())
                });
                assert!(
                    together == alone,
                    "{}: {} and {} disturb each other",
                    device.info().id(),
                    pair[0].name,
                    pair[1].name
                );
            }
        }
    }
}
