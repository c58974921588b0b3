//! The CPU backend has the bits of the kernels' f32 references. The expected values are those of the kernels
//! in f64.
use crate::toy::Toy;
use rhytid_backend_cpu::Cpu;
use rhytid_conformance::Expected;
use rhytid_conformance::reference::{Found, reference};
use rhytid_conformance::{Case, Suite, cases, detail_params, evaluate, pivoted_weights, squared_differences};
use rhytid_core::plan::PlanLimits;
use rhytid_core::{Animator, Backend, BasisStorage, Stage, StrainEdgeId, VertexId};
use rhytid_kernels::{detail, fine_scale, normals};

fn cpu() -> Cpu {
    Cpu::open(&Cpu::devices().unwrap()[0]).unwrap()
}

/// All cases with an f32 basis, except the chapter's.
fn plain_cases() -> Vec<Case> {
    let mut cases = cases(Suite::Full);
    cases.retain(|case| !case.large && case.options.basis == BasisStorage::F32);
    assert!(cases.len() > 30);
    cases
}

#[test]
fn every_stage_has_the_bits_of_the_f32_reference() {
    let mut whole = 0;
    for case in plain_cases() {
        let built = case.build();
        let mut animator = Animator::new(&cpu(), &built.rig, case.options).unwrap();
        animator.evaluate(&built.handle_positions).unwrap();
        let reference = evaluate(&built.rig, built.handle_positions.as_chunks().0);
        // What the basis does beyond the reach is summed up in another order, so later stages differ by
        // rounding. The suite's bounds hold there.
        let stages = if built.rig.limits_basis() { &[Stage::Strain][..] } else { &Stage::ALL };
        whole += usize::from(stages.len() > 1);
        for &stage in stages {
            let mut found = Vec::new();
            animator.read(stage, &mut found).unwrap();
            let bits = |numbers: &[f32]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert!(
                bits(&found) == bits(reference.stage(stage)),
                "{}: {stage:?} differs from its reference",
                case.name
            );
        }
    }
    assert!(whole > 20, "{whole} cases with every stage");
}

/// The toy runs the references of the kernels `clusters` and `large_scale`.
#[test]
fn clusters_have_the_bits_of_their_references() {
    let mut cases = cases(Suite::Full);
    cases.retain(|case| case.options.basis == BasisStorage::Clustered);
    assert!(cases.len() > 8);
    let limits = PlanLimits { max_binding_bytes: u64::MAX, max_workgroups: u32::MAX };
    for case in cases {
        let built = case.build();
        let mut found = [Vec::new(), Vec::new()];
        let mut animator = Animator::new(&cpu(), &built.rig, case.options).unwrap();
        animator.evaluate(&built.handle_positions).unwrap();
        animator.read(Stage::LargeScale, &mut found[0]).unwrap();
        let mut animator = Animator::new(&Toy { limits }, &built.rig, case.options).unwrap();
        animator.evaluate(&built.handle_positions).unwrap();
        animator.read(Stage::LargeScale, &mut found[1]).unwrap();
        let [cpu, toy] = found.map(|numbers| numbers.into_iter().map(f32::to_bits).collect::<Vec<_>>());
        assert!(cpu == toy || built.rig.limits_basis(), "{}", case.name);
    }
}

/// Each kernel's f64 reference for the inputs that `found` has.
fn kernel_of(found: &Found, stage: Stage) -> Vec<f64> {
    let (rig, frames) = (&found.rig, found.frames());
    let vertices = rig.vertices();
    let widened = |stage| found.stage(stage).iter().map(|&x| f64::from(x)).collect::<Vec<_>>();
    let vectors = |stage| widened(stage).as_chunks::<3>().0.to_vec();
    let mut out = vec![[0.0; 3]; frames * vertices];
    let mut normals_of = |positions: Stage| {
        normals::normals(
            normals::Params::whole(frames, vertices),
            &vectors(positions),
            &rig.surface().triangles,
            &rig.surface().vertex_triangles(),
            &mut out,
        );
    };
    match stage {
        Stage::Strain | Stage::LargeScale => {
            return evaluate(rig, &found.handle_positions).stage(stage).to_vec();
        }
        Stage::LargeScaleNormals => normals_of(Stage::LargeScale),
        Stage::Normals => normals_of(Stage::Positions),
        Stage::Detail if rig.vector_wrinkles() => {
            return evaluate(rig, &found.handle_positions).stage(stage).to_vec();
        }
        Stage::Detail => {
            let params = detail_params(rig, frames);
            let (rbf_weights, pivots) = pivoted_weights(rig);
            let buffers = detail::Buffers {
                influences: rig.influences().per_vertex(),
                influence_edges: StrainEdgeId::numbers(rig.influences().edges.as_slice()),
                influence_weights: rig.influences().weights.as_slice(),
                rbf_weights: rbf_weights.as_slice(),
                pivots: &pivots,
            };
            let table = squared_differences(rig, &widened(Stage::Strain));
            detail::detail(params, &table, &buffers, &mut out);
        }
        Stage::Positions => fine_scale::fine_scale(
            fine_scale::Params::whole(frames, vertices, rig.vector_wrinkles()),
            &vectors(Stage::LargeScale),
            &vectors(Stage::LargeScaleNormals),
            &vectors(Stage::Detail),
            VertexId::numbers(&rig.surface().tangent_neighbors),
            &mut out,
        ),
    }
    out.into_flattened()
}

/// The expected values have sums of their own, for the bounds. Their values must still equal the kernels' f64
/// references.
#[test]
fn the_expected_values_are_those_of_the_f64_kernels() {
    for case in plain_cases() {
        let built = case.build();
        let results = evaluate(&built.rig, built.handle_positions.as_chunks().0);
        let stages = Stage::ALL.map(|stage| results.stage(stage).to_vec());
        let found = Found::new(built.rig, BasisStorage::F32, &built.handle_positions, stages).unwrap();
        for stage in Stage::ALL {
            let expected = reference(&found, stage);
            // Some sums have another order or form, which matters very little in f64.
            let same = |(e, value): (&Expected, &f64)| (e.value - value).abs() <= 1e-6 * e.bound;
            let values = kernel_of(&found, stage);
            assert_eq!(expected.len(), values.len());
            assert!(
                expected.iter().zip(&values).all(same),
                "{}: {stage:?} is not the reference's",
                case.name
            );
            assert!(
                expected.iter().all(|e| e.bound > 0.0 && e.bound.is_finite()),
                "{}: {stage:?}",
                case.name
            );
        }
    }
}
