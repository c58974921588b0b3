//! The backend of `docs/adding-a-backend.md` passes conformance with any limits. That shows that `Plan` is
//! sound.

use crate::toy::Toy;
use rhytid_conformance::{Suite, Verdict, cases, evaluate, run_case, run_device};
use rhytid_core::plan::{Plan, PlanLimits};
use rhytid_core::{Animator, Backend, BasisStorage, ClusteredBasis, Device, Stage};

fn device(limits: PlanLimits) -> Device {
    Device::new(Toy::devices().unwrap().remove(0), Toy { limits })
}

#[test]
fn the_toy_passes_the_quick_suite() {
    let info = Toy::devices().unwrap().remove(0);
    let report = run_device(&Device::open::<Toy>(&info).unwrap(), Suite::Quick, |_, _, _| true);
    for outcome in report.outcomes.iter().filter(|outcome| outcome.verdict != Verdict::Pass) {
        println!("{} {}: {}", outcome.full_name(), outcome.verdict, outcome.reason);
    }
    assert!(report.passed());
    assert_eq!(report.count(Verdict::Pass), report.outcomes.len());
}

/// The smallest binding in bytes that a device needs for `case`.
fn least_binding(case: &rhytid_conformance::Case) -> u64 {
    let rig = case.build().rig;
    let possible = |max_binding_bytes| {
        let limits = PlanLimits { max_binding_bytes, max_workgroups: u32::MAX };
        Plan::new(&rig, case.options, limits, "toy:0").is_ok()
    };
    let (mut low, mut high) = (0, 1 << 24);
    while low + 1 < high {
        let middle = (low + high) / 2;
        if possible(middle) { high = middle } else { low = middle }
    }
    high
}

#[test]
fn arrays_and_batches_split_to_the_least_that_is_possible_still_conform() {
    let mut split = 0;
    for case in cases(Suite::Full).iter().filter(|case| !case.large) {
        let max_binding_bytes = least_binding(case);
        let rig = case.build().rig;
        // These are never split.
        let rows = match case.options.basis {
            BasisStorage::Clustered => ClusteredBasis::new(&rig).rows(),
            BasisStorage::F32 | BasisStorage::F16 => 0,
        };
        let workgroups = (rig.handles().features().max(rows) as u32).div_ceil(64).max(1);
        for limits in [
            PlanLimits { max_binding_bytes, max_workgroups: u32::MAX },
            PlanLimits { max_binding_bytes: u64::MAX, max_workgroups: workgroups.max(2) },
        ] {
            // A buffer for each of 70,000 slices would take too long.
            if case.options.max_frames > 1000 {
                continue;
            }
            let plan = Plan::new(&rig, case.options, limits, "toy:0").unwrap();
            split += usize::from(plan.dispatches(case.options.max_frames).len() > 9);
            for outcome in run_case(&device(limits), case) {
                assert_eq!(outcome.verdict, Verdict::Pass, "{limits:?} {}: {}", outcome.name, outcome.reason);
            }
        }
    }
    assert!(split > 40, "only {split} cases were split at all");
}

/// All stages have the references' bits except the normals and what is made of them. A plan's fans have
/// another order than the reference's triangles, which conformance allows.
#[test]
fn the_toy_has_the_bits_of_the_references() {
    let limits = PlanLimits { max_binding_bytes: u64::MAX, max_workgroups: 6 };
    for case in cases(Suite::Quick).iter().filter(|case| case.options.basis == BasisStorage::F32) {
        let built = case.build();
        let mut animator = Animator::new(&Toy { limits }, &built.rig, case.options).unwrap();
        animator.evaluate(&built.handle_positions).unwrap();
        let reference = evaluate(&built.rig, built.handle_positions.as_chunks().0);
        for stage in [Stage::Strain, Stage::LargeScale, Stage::Detail] {
            let mut found = Vec::new();
            animator.read(stage, &mut found).unwrap();
            let bits = |numbers: &[f32]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert!(bits(&found) == bits(reference.stage(stage)), "{}: {stage:?}", case.name);
        }
    }
}

#[test]
fn a_device_that_is_too_small_says_so() {
    let limits = PlanLimits { max_binding_bytes: 1000, max_workgroups: 4 };
    let case = &cases(Suite::Quick)[4];
    let outcomes = run_case(&device(limits), case);
    assert_eq!(outcomes.len(), 6);
    for outcome in outcomes {
        assert_eq!(outcome.verdict, Verdict::NotSupported, "{}", outcome.reason);
        assert!(!outcome.is_acceptable(), "every device can hold the quick cases");
    }
}

/// Whether `file` contains all of the lines in their order. Other lines may stand between them, and
/// indentation does not matter.
fn shows(file: &str, mut lines: impl Iterator<Item = impl AsRef<str>>) -> bool {
    let mut file = file.lines().map(str::trim);
    lines.all(|line| file.any(|of_file| of_file == line.as_ref()))
}

/// Comments, and the parts that the page leaves out with “…”, are not compared.
#[test]
fn the_page_shows_the_toy_s_own_lines() {
    let page = include_str!("../../../docs/adding-a-backend.md");
    let toy = [include_str!("toy/device.rs"), include_str!("toy/session.rs")];
    let blocks: Vec<&str> =
        page.split("\n```rust\n").skip(1).map(|rest| rest.split("\n```\n").next().unwrap()).collect();
    assert_eq!(blocks.len(), 4);
    for block in blocks {
        let code = |line: &'static str| line.split("//").next().unwrap().split('…').next().unwrap().trim();
        let lines = || block.lines().map(code).filter(|line| !line.is_empty());
        assert!(toy.iter().any(|file| shows(file, lines())), "{block}");
    }
}
