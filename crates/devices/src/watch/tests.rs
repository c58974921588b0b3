use super::*;
use rhytid_backend_cpu::Cpu;
use rhytid_core::{BasisStorage, ClusteredBasis, Method, NoProgress, VertexId};
use rhytid_test_support::flaky::{Flaky, watched};

fn rig(method: Method) -> Rig {
    let mut face = rhytid_demo::face(2_000);
    face.settings.method = method;
    rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap()
}

fn evaluated(rig: &Rig, options: UploadOptions, handles: &[f32]) -> [Vec<f32>; 2] {
    read(rig, options, handles, [Stage::LargeScale, Stage::Positions])
}

fn read<const N: usize>(
    rig: &Rig,
    options: UploadOptions,
    handles: &[f32],
    stages: [Stage; N],
) -> [Vec<f32>; N] {
    let mut animator = Animator::new(&Cpu, rig, options).unwrap();
    animator.evaluate(handles).unwrap();
    stages.map(|stage| {
        let mut out = Vec::new();
        animator.read(stage, &mut out).unwrap();
        out
    })
}

fn smile(rig: &Rig) -> Vec<f32> {
    let second = rig.examples().handles.row(1);
    second.iter().flat_map(|x| x.map(|x| x + 0.1)).collect()
}

#[test]
fn a_part_goes_where_it_goes_in_the_whole() {
    for method in [Method::default(), Method::Chapter] {
        let rig = rig(method);
        let handles = smile(&rig);
        let v = rig.vertices() as u32;
        for basis in [BasisStorage::F32, BasisStorage::F16] {
            let options = UploadOptions { max_frames: 1, basis };
            // The tiles of a part are other ones. Each rounds its weights within the bound.
            let rounding = 2.0 * ClusteredBasis::LARGEST_ERROR * BasisStorage::motion(&rig);
            let allowed = if basis == BasisStorage::F32 { 1e-5 } else { rounding as f32 };
            let whole = evaluated(&rig, options, &handles);
            for vertices in [vec![v / 2], vec![v - 1, 0, 17], (0..v).step_by(7).collect(), (0..v).collect()] {
                let part = rig.part(&vertices.iter().copied().map(VertexId).collect::<Vec<_>>());
                assert!(vertices.len() < v as usize / 2 || part.vertices() == v as usize);
                for (whole, part) in whole.iter().zip(evaluated(&part, options, &handles)) {
                    for (&v, x) in vertices.iter().zip(part.as_chunks::<3>().0) {
                        let expected = &whole[3 * v as usize..][..3];
                        let apart = (0..3).map(|c| (x[c] - expected[c]).abs()).fold(0.0, f32::max);
                        assert!(apart < allowed, "vertex {v} of {}: {apart}", vertices.len());
                    }
                }
            }
        }
    }
}

fn watch_of(rig: &Rig, options: UploadOptions) -> Watch<'_> {
    let open = Device::open::<Flaky>(&watched("sound")).unwrap();
    Watch::begin(rig, options, &watched("sound"), &mut open.upload(rig, options).unwrap()).unwrap().unwrap()
}

/// Checks positions only.
fn look(watch: &mut Watch<'_>, handles: &[f32], found: &[f32]) -> Result<()> {
    watch.batch(handles, &[Stage::Positions], &[found.to_vec()])
}

fn sentence(result: Result<()>) -> String {
    result.unwrap_err().to_string()
}

#[test]
fn what_is_nowhere_near_is_found_at_once_and_what_is_wrong_within_seconds() {
    let rig = rig(Method::default());
    let options = UploadOptions::frames(4);
    let mut watch = watch_of(&rig, options);
    let handles = smile(&rig);
    let [_, right] = evaluated(&rig, options, &handles);
    look(&mut watch, &handles, &right).unwrap();
    for wrong in [f32::NAN, f32::INFINITY, -1e6, 500.0] {
        let mut found = right.clone();
        found[3 * 100 + 1] = wrong;
        let said = sentence(look(&mut watch, &handles, &found));
        assert!(said.contains("computes wrongly: vertex 100 is at"), "{wrong}: {said}");
    }
    // One vertex of a thousand is off by a tenth of a millimetre. There is one check a second, of other
    // vertices each time.
    let mut found = right.clone();
    found.chunks_exact_mut(3 * 1000).for_each(|many| many[0] += 0.1);
    look(&mut watch, &handles, &found).unwrap();
    let v = rig.vertices();
    let looks = (0..v.div_ceil(LATER)).position(|_| {
        watch.last = Instant::now().checked_sub(2 * PAUSE).unwrap();
        look(&mut watch, &handles, &found).is_err()
    });
    assert!(looks.is_some(), "never found");
}

#[test]
fn handles_that_are_nowhere_are_no_fault_of_the_device() {
    let rig = rig(Method::Chapter);
    let options = UploadOptions::frames(1);
    let mut watch = watch_of(&rig, options);
    let mut handles = smile(&rig);
    handles[4] += 1e5;
    let [_, found] = evaluated(&rig, options, &handles);
    look(&mut watch, &handles, &found).unwrap();
}

#[test]
fn a_device_that_computes_nothing_is_refused_at_the_upload() {
    let rig = rig(Method::default());
    let options = UploadOptions::frames(1);
    let info = watched("nothing");
    let mut animator = Device::open::<Flaky>(&info).unwrap().upload(&rig, options).unwrap();
    let error = Watch::begin(&rig, options, &info, &mut animator).err().unwrap().to_string();
    assert!(error.contains("computes wrongly"), "{error}");
}

#[test]
fn normals_that_are_not_those_of_the_positions_are_found() {
    for (method, stages) in [
        (Method::default(), [Stage::Positions, Stage::Normals]),
        (Method::Chapter, [Stage::Positions, Stage::Normals]),
        (Method::Chapter, [Stage::LargeScale, Stage::LargeScaleNormals]),
    ] {
        let rig = rig(method);
        let options = UploadOptions::frames(2);
        let mut watch = watch_of(&rig, options);
        let rest = rig.handles().rest.iter().flatten().copied();
        let handles: Vec<f32> = smile(&rig).into_iter().chain(rest).collect();
        let [positions, right] = read(&rig, options, &handles, stages);
        let mut look = |normals: Vec<f32>| watch.batch(&handles, &stages, &[positions.clone(), normals]);
        for _ in 0..200 {
            look(right.clone()).unwrap();
        }
        // A single normal of another length in the second frame is found at once.
        let frame = right.len() / 2;
        for factor in [0.0, 0.9, 1.1, f32::NAN, f32::INFINITY] {
            let mut found = right.clone();
            found[frame + 300..][..3].iter_mut().for_each(|x| *x *= factor);
            let said = sentence(look(found));
            assert!(said.contains("vertex 100 has the normal ["), "{factor}: {said}");
        }
        // These are found at once: no normals, all inside out, all of the other frame, and wrong ones in a
        // frame that is not the last.
        let flipped: Vec<f32> = right.iter().map(|x| -x).collect();
        let others = [&right[frame..], &right[..frame]].concat();
        let of_the_last = right[frame..].repeat(2);
        for found in [vec![0.0; right.len()], flipped, others, of_the_last] {
            assert!(sentence(look(found)).contains("its triangles have"));
        }
        // Every fiftieth normal is inside out. Other vertices are checked each time.
        let mut found = right.clone();
        found.chunks_exact_mut(3 * 50).for_each(|many| many[..3].iter_mut().for_each(|x| *x = -*x));
        assert!((0..rig.vertices() / NORMALS).any(|_| look(found.clone()).is_err()), "never found");
    }
}

#[test]
fn a_look_leaves_no_vertex_out() {
    for vertices in [1, 60, 64, 65, 1000, 24_000] {
        let (mut looks, mut seen) = (Looks::default(), vec![false; vertices]);
        for _ in 0..3 * vertices.div_ceil(LATER) {
            let vertices: Vec<usize> = looks.next(vertices, LATER).collect();
            assert!(vertices.len() <= LATER);
            vertices.into_iter().for_each(|v| seen[v] = true);
        }
        assert!(seen.iter().all(|seen| *seen), "of {vertices}");
    }
}
