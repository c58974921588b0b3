//! Broken backends must fail in the stage that is broken. A suite that is blind must fail too.

mod faulty;

use crate::toy::{Toy, ToySession};
use faulty::{Fault, Faulty};
use rhytid_conformance::Expected;
use rhytid_conformance::reference::{Found, reference};
use rhytid_conformance::{
    Case, Outcome, Suite, Verdict, cases, run_case, run_case_against, run_mutants, run_mutants_against,
    stage_name,
};
use rhytid_core::plan::{Dispatch, PlanLimits};
use rhytid_core::{Backend, Device, Stage};
use rhytid_kernels::table::Kernel;
use std::sync::Arc;

const NO_LIMITS: PlanLimits = PlanLimits { max_binding_bytes: u64::MAX, max_workgroups: u32::MAX };

fn device(fault: Fault) -> Device {
    Device::new(Toy::devices().unwrap().remove(0), Faulty { limits: NO_LIMITS, fault })
}

fn quick(name: &str) -> Case {
    cases(Suite::Quick).into_iter().find(|case| case.name == name).unwrap()
}

/// A batch of 31 frames after an upload for 32.
fn batch() -> Case {
    quick("learned-v129-h89-f243-p6-k16-b31-of-32")
}

/// The same for the chapter's method, whose detail depends on strain lengths.
fn chapter_batch() -> Case {
    quick("v129-h89-f243-p6-k16-b31-of-32")
}

fn failed(outcomes: &[Outcome]) -> Vec<&'static str> {
    outcomes.iter().filter(|o| o.verdict == Verdict::Fail).filter_map(|o| o.stage).collect()
}

/// The stages that fail in the first quick case that notices the fault.
fn noticed(fault: &Fault) -> Option<(String, Vec<&'static str>)> {
    let device = device(fault.clone());
    cases(Suite::Quick).iter().find_map(|case| {
        let outcomes = run_case(&device, case);
        let failed = failed(&outcomes);
        (!failed.is_empty()).then(|| (case.name.clone(), failed))
    })
}

fn dispatch(change: impl Fn(&mut Vec<Dispatch>) + Send + Sync + 'static) -> Fault {
    Fault::Run(Arc::new(change))
}

/// A stage, and a kernel that runs for it.
type Step = (Stage, Kernel);

fn of_step(step: Step, change: impl Fn(&mut Dispatch) + Send + Sync + 'static) -> Fault {
    dispatch(move |dispatches| dispatches.iter_mut().filter(|d| is_of(d, step)).for_each(&change))
}

fn is_of(dispatch: &Dispatch, (stage, kernel): Step) -> bool {
    (dispatch.stage, dispatch.kernel) == (stage, kernel)
}

#[test]
fn the_backend_without_a_fault_passes() {
    assert_eq!(noticed(&dispatch(|_| ())), None);
    assert_eq!(noticed(&Fault::Read(|_, _, _| ())), None);
}

/// The steps that run for any of the batches.
fn steps() -> Vec<Step> {
    let mut steps = Vec::new();
    for case in [batch(), chapter_batch(), quick("clustered-learned")] {
        let session = ToySession::new(&case.build().rig, case.options, NO_LIMITS).unwrap();
        steps.extend(session.dispatches(1).iter().map(|d| (d.stage, d.kernel)));
    }
    steps.sort_unstable_by_key(|(stage, kernel)| (*stage, *kernel as usize));
    steps.dedup();
    steps
}

#[test]
fn any_two_bindings_swapped_fail() {
    let mut swaps = 0;
    for (stage, kernel) in steps() {
        let bindings = kernel.entry().bindings;
        for j in 0..bindings.len() {
            for i in 0..j {
                swaps += 1;
                let [of_i, of_j] = [i, j].map(|b| bindings[b].buffer.name());
                let what = format!("{}: {of_i} for {of_j}", kernel.name());
                let noticed = noticed(&of_step((stage, kernel), move |d| d.buffers.swap(i, j)));
                println!("{what}: {noticed:?}");
                let (_, failed) = noticed.unwrap_or_else(|| panic!("{what} passes"));
                let inputs_alone = j + 1 < bindings.len();
                assert!(
                    !inputs_alone || failed[0] == stage_name(stage) || failed.len() == 6,
                    "{what} is blamed on {failed:?}"
                );
            }
        }
    }
    assert_eq!(swaps, 10 + 15 + 21 + 10 + 3 + 15 + 6 + 3 + 21 + 10 + 6);
}

#[test]
fn the_last_workgroup_dropped_fails_in_its_stage() {
    for (stage, kernel) in steps() {
        let (case, failed) =
            noticed(&of_step((stage, kernel), |d| d.workgroups[0] -= 1)).expect("it is noticed");
        println!("{stage:?} without its last workgroup fails {case} in {failed:?}");
        assert_eq!(failed[0], stage_name(stage));
    }
}

#[test]
fn the_last_frame_dropped_fails_in_its_stage() {
    for (stage, kernel) in steps() {
        let (_, failed) =
            noticed(&of_step((stage, kernel), |d| d.workgroups[1] -= 1)).expect("it is noticed");
        assert_eq!(failed[0], stage_name(stage));
    }
}

#[test]
fn handles_that_do_not_turn_or_turn_about_another_vertex_fail() {
    for what in ["rotating", "center"] {
        let at = Kernel::LargeScale.entry().params.iter().position(|param| *param == what).unwrap();
        let step = (Stage::LargeScale, Kernel::LargeScale);
        // `rotating` becomes 0 instead of 1. The centre becomes the next of 201 vertices.
        let fault = move |x: &mut u32| *x = if what == "rotating" { 0 } else { (*x + 1) % 201 };
        let device = device(of_step(step, move |d| fault(&mut d.params[at])));
        for case in ["turning", "turning-learned-f16"] {
            let outcomes = run_case(&device, &quick(case));
            assert_eq!(failed(&outcomes).first(), Some(&"large_scale"), "{what} of {case}");
        }
        // Handles that do not turn are not affected.
        assert_eq!(failed(&run_case(&device, &batch())), [""; 0], "{what}");
    }
}

#[test]
fn a_kernel_left_out_fails_in_its_stage() {
    for (stage, kernel) in steps() {
        let fault = dispatch(move |dispatches| dispatches.retain(|d| !is_of(d, (stage, kernel))));
        assert_eq!(noticed(&fault).expect("it is noticed").1[0], stage_name(stage));
    }
}

#[test]
fn stale_results_fail() {
    for fault in [Fault::Late, Fault::OnlyFirst, Fault::EveryThird] {
        let failed = failed(&run_case(&device(fault.clone()), &batch())).len();
        assert!(failed > 0, "{fault:?} passes");
        assert!(noticed(&fault).is_some());
    }
    // Stage by stage: the results of the batch before.
    for stage in Stage::ALL {
        let case = if stage == Stage::Detail { chapter_batch() } else { batch() };
        let outcomes = run_case(&device(Fault::StaleStage(stage)), &case);
        assert!(failed(&outcomes).contains(&stage_name(stage)), "{stage:?}");
    }
}

#[test]
fn normals_of_the_wrong_stage_fail() {
    // Read from the wrong buffer of the two, or computed from the wrong positions.
    let swapped: fn(Stage) -> Fault = |of| match of {
        Stage::Normals => Fault::Read(|session, stage, out| {
            if stage == Stage::Normals {
                faulty::read(session, Stage::LargeScaleNormals, out);
            }
        }),
        _ => Fault::Read(|session, stage, out| {
            if stage == Stage::LargeScaleNormals {
                faulty::read(session, Stage::Normals, out);
            }
        }),
    };
    for stage in [Stage::LargeScaleNormals, Stage::Normals] {
        let failed = noticed(&swapped(stage)).expect("it is noticed").1;
        assert!(failed.contains(&stage_name(stage)), "{stage:?}: {failed:?}");
    }
    let fault = dispatch(|dispatches| {
        let smooth = dispatches.iter().position(|d| d.stage == Stage::LargeScaleNormals).unwrap();
        let positions = dispatches[smooth].buffers[0];
        let last = dispatches.iter_mut().find(|d| d.stage == Stage::Normals).unwrap();
        last.buffers[0] = positions;
    });
    assert_eq!(noticed(&fault).expect("it is noticed").1, ["normals"]);
}

/// A name, the stage that is spoilt, and how.
type Spoilt = (&'static str, Stage, fn(&mut ToySession, Stage, &mut Vec<f32>));

const SPOILT: [Spoilt; 6] = [
    ("an edge too few", Stage::Strain, |_, stage, out| {
        if stage == Stage::Strain {
            out.pop();
        }
    }),
    ("strain four millionths too large", Stage::Strain, |_, stage, out| {
        if stage == Stage::Strain {
            out.iter_mut().for_each(|x| *x += 4e-6 + 4e-6 * x.abs());
        }
    }),
    ("the first frame returned for the last", Stage::Positions, |session, stage, out| {
        if stage == Stage::Positions {
            let frame = out.len() / session.frames();
            let last = out.len() - frame;
            out.copy_within(0..frame, last);
        }
    }),
    ("normals turned inside out", Stage::LargeScaleNormals, |_, stage, out| {
        if stage == Stage::LargeScaleNormals {
            out.iter_mut().for_each(|x| *x = -*x);
        }
    }),
    ("detail with two axes swapped", Stage::Detail, |_, stage, out| {
        if stage == Stage::Detail {
            out.chunks_exact_mut(3).for_each(|d| d.swap(0, 1));
        }
    }),
    ("one normal that is not a number", Stage::Normals, |_, stage, out| {
        if stage == Stage::Normals {
            out[0] = f32::NAN;
        }
    }),
];

#[test]
fn what_is_spoilt_on_the_way_out_is_pinned_to_its_stage() {
    for (name, stage, spoil) in SPOILT {
        let outcomes = run_case(&device(Fault::Read(spoil)), &batch());
        let failed = failed(&outcomes);
        println!("{name}: fails in {failed:?}");
        assert!(failed.contains(&stage_name(stage)), "{name} passes");
        assert!(failed[0] == stage_name(stage) || failed.len() == 6, "{name} is blamed on {failed:?}");
    }
}

fn doubled(found: &Found, stage: Stage) -> Vec<Expected> {
    let mut expected = reference(found, stage);
    expected.iter_mut().for_each(|e| e.bound *= 2.0);
    expected
}

#[test]
fn what_passes_only_with_a_doubled_tolerance_fails() {
    for case in [batch(), quick("learned-f16"), quick("f16"), quick("large-units"), quick("small-units")] {
        for stage in Stage::ALL {
            // Every number of the stage is off by a part of its own bound.
            let inside = run_case(&device(Fault::Off(stage, 0.4)), &case);
            assert_eq!(inside[stage as usize].verdict, Verdict::Pass, "{}", inside[stage as usize].reason);
            let outside = device(Fault::Off(stage, 1.6));
            let outcome = &run_case(&outside, &case)[stage as usize];
            assert_eq!(outcome.verdict, Verdict::Fail, "{}", outcome.name);
            let part = outcome.measured.unwrap().part_of_bound;
            assert!((1.0..=2.2).contains(&part), "{}: {part}", outcome.name);
            let outcome = &run_case_against(&outside, &case, doubled)[stage as usize];
            let part = outcome.measured.unwrap().part_of_bound;
            assert!((0.5..=1.1).contains(&part), "{}: {part} of the doubled bound", outcome.name);
        }
    }
}

/// A blind suite: the device is its own reference.
fn itself(found: &Found, stage: Stage) -> Vec<Expected> {
    let values = found.stage(stage).iter().map(|&x| f64::from(x));
    reference(found, stage).into_iter().zip(values).map(|(e, value)| Expected { value, ..e }).collect()
}

#[test]
fn a_device_compared_with_itself_is_noticed() {
    let fault = Fault::Read(|_, stage, out| {
        if stage == Stage::Detail {
            out.iter_mut().for_each(|x| *x *= 2.0);
        }
    });
    let broken = device(fault);
    assert_eq!(failed(&run_case_against(&broken, &batch(), itself)), [""; 0], "it is blind indeed");

    let sound = Device::new(Toy::devices().unwrap().remove(0), Toy { limits: NO_LIMITS });
    let verdicts = |outcomes: Vec<Outcome>| outcomes.iter().map(|o| o.verdict).collect::<Vec<_>>();
    assert_eq!(verdicts(run_mutants(&sound)), [Verdict::Pass; 6]);
    assert_eq!(verdicts(run_mutants_against(&sound, itself)), [Verdict::Fail; 6]);
    // Bounds that allow everything are blind too.
    let anything = |found: &Found, stage| {
        reference(found, stage).into_iter().map(|e| Expected { bound: f64::INFINITY, ..e }).collect()
    };
    assert_eq!(verdicts(run_mutants_against(&sound, anything)), [Verdict::Fail; 6]);
}
