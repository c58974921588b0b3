//! The CPU backend has the bits of the kernels' f32 twins, and the reference is the f64 twin.
use rhytid_backend_cpu::Cpu;
use rhytid_conformance::reference::{Found, reference};
use rhytid_conformance::{Case, Suite, cases, evaluate};
use rhytid_core::{Animator, Backend, BasisStorage, Rig, Stage};

fn cpu() -> Cpu {
    Cpu::open(&Cpu::devices().unwrap()[0]).unwrap()
}

/// All cases whose basis is stored as it is, but the chapter's.
fn plain_cases() -> Vec<Case> {
    let mut cases = cases(Suite::Full);
    cases.retain(|case| !case.timed && case.options.basis == BasisStorage::F32);
    assert!(cases.len() > 30);
    cases
}

#[test]
fn every_stage_has_the_bits_of_the_f32_twin() {
    for case in plain_cases() {
        let built = case.build();
        let mut animator = Animator::new(&cpu(), &built.rig, case.options).unwrap();
        animator.evaluate(&built.handle_positions).unwrap();
        let twin = evaluate(&built.rig, built.handle_positions.as_chunks().0);
        for stage in Stage::ALL {
            let mut found = Vec::new();
            animator.read(stage, &mut found).unwrap();
            let bits = |numbers: &[f32]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert!(
                bits(&found) == bits(twin.stage(stage)),
                "{}: {stage:?} differs from its twin",
                case.name
            );
        }
    }
}

/// The twin's own results, rounded, are inputs like any device's: what the reference makes of them is what the twin does.
#[test]
fn the_reference_is_the_f64_twin() {
    for case in plain_cases() {
        let built = case.build();
        let rig: Rig<f64> = built.rig.cast();
        let handle_positions: Vec<[f64; 3]> =
            built.handle_positions.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect();
        let twin = evaluate(&rig, &handle_positions);
        let stages = Stage::ALL.map(|stage| twin.stage(stage).iter().map(|&x| x as f32).collect());
        let found = Found { rig, basis: BasisStorage::F32, handle_positions, stages };
        for stage in [Stage::Strain, Stage::LargeScale] {
            let values: Vec<f64> = reference(&found, stage).iter().map(|e| e.value).collect();
            assert_eq!(values, twin.stage(stage), "{}: {stage:?}", case.name);
        }
        // The others get rounded inputs: as the twin, within what rounding does to them.
        for stage in Stage::ALL {
            let expected = reference(&found, stage);
            assert_eq!(expected.len(), twin.stage(stage).len());
            assert!(expected.iter().all(|e| e.value.is_finite() && e.bound.is_finite()), "{stage:?}");
        }
    }
}
