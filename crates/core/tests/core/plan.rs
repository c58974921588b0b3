//! The plan for a GPU covers every vertex and every frame once, and stays within the device's limits. The
//! conformance tests check its results.

use rhytid_core::plan::{Dispatch, Plan, PlanLimits, Role};
use rhytid_core::{
    BasisStorage, DeviceErrorKind, Error, Faces, HandleFrames, NoProgress, Rig, RigParts, Stage, Table,
    UploadOptions, VertexId, WrinkleStrains,
};
use rhytid_kernels::table::{Buffer, Each, Kernel};
use rhytid_solve::solve;
use rhytid_test_support::changed;

fn rig() -> Rig {
    solve(&rhytid_test_support::sheet::face(), &NoProgress).unwrap().rounded().unwrap()
}

const NO_LIMITS: PlanLimits = PlanLimits { max_binding_bytes: u64::MAX, max_workgroups: u32::MAX };

/// The face repeated, so that it has at least `vertices` vertices.
fn large_rig(vertices: usize) -> Rig {
    let one = rig();
    let copies = vertices.div_ceil(one.vertices());
    let repeated = |r: &mut RigParts| {
        let surface = one.surface();
        let (triangles, neighbors) = (&surface.triangles, &surface.tangent_neighbors);
        r.surface.rest = surface.rest.repeat(copies);
        let firsts = || (0..copies).map(|copy| (copy * one.vertices()) as u32);
        let of_copy = |first: u32| triangles.iter().map(move |t| t.map(|v| v + first));
        r.surface.triangles = firsts().flat_map(of_copy).collect();
        r.surface.faces = Faces::default();
        r.surface.triangles.iter().for_each(|triangle| r.surface.faces.push(triangle));
        let of_copy = |first: u32| neighbors.iter().map(move |v| VertexId(v.0 + first));
        r.surface.tangent_neighbors = firsts().flat_map(of_copy).collect();
        r.basis = times(&r.basis, copies);
        r.influences.edges = times(&r.influences.edges, copies);
        r.influences.weights = times(&r.influences.weights, copies);
        r.fine_scale.rbf_weights = times(&r.fine_scale.rbf_weights, copies);
        if let Some(learned) = &mut r.learned {
            learned.anchors = times(&learned.anchors, copies);
            learned.anchor_weights = times(&learned.anchor_weights, copies);
            learned.feature_gains = times(&learned.feature_gains, copies);
            learned.example_weights = times(&learned.example_weights, copies);
            learned.variances = learned.variances.repeat(copies);
        }
    };
    changed(&one, repeated).unwrap()
}

/// The rows of a table, repeated `copies` times.
fn times<T: Copy>(table: &Table<T>, copies: usize) -> Table<T> {
    Table::new(table.height() * copies, table.columns(), table.as_slice().repeat(copies))
}

/// The rig with wrinkles of strain lengths.
fn of_lengths(rig: Rig) -> Rig {
    changed(&rig, |r| r.learned.as_mut().unwrap().wrinkle_strains = WrinkleStrains::Lengths).unwrap()
}

/// The same, whose handles turn.
fn turning(rig: &Rig) -> Rig {
    changed(rig, |r| r.handles.rotations = true).unwrap()
}

#[test]
fn an_ordinary_rig_is_one_part_and_one_slice() {
    let (vectors, lengths) = (rig(), of_lengths(rig()));
    let chapter = changed(&vectors, |r| r.learned = None).unwrap();
    let without_limit = changed(&vectors, |r| r.learned.as_mut().unwrap().reach = f64::INFINITY).unwrap();
    let without_detail: Vec<Stage> = Stage::ALL.into_iter().filter(|stage| *stage != Stage::Detail).collect();
    // Nothing is made for kernels that do not run: the bands in the chapter's method, and the detail where
    // the bands have the wrinkles.
    let dense = UploadOptions::frames(31);
    let clustered = UploadOptions { basis: BasisStorage::Clustered, ..dense };
    for (rig, options, kernels, buffers, in_order) in [
        (vectors.clone(), dense, 8, 28, &without_detail[..]),
        (lengths, dense, 10, 32, &Stage::ALL[..]),
        // Without a limit, nothing is taken back.
        (without_limit, dense, 7, 26, &without_detail[..]),
        // Where handles turn, only the bands read displacements.
        (turning(&vectors), dense, 8, 29, &without_detail[..]),
        (turning(&chapter), dense, 7, 24, &Stage::ALL[..]),
        (chapter.clone(), dense, 7, 24, &Stage::ALL[..]),
        // Clusters have a factor for the handles, and motions.
        (vectors.clone(), clustered, 9, 30, &without_detail[..]),
        (turning(&vectors), clustered, 9, 31, &without_detail[..]),
        (chapter, clustered, 8, 26, &Stage::ALL[..]),
    ] {
        let plan = Plan::new(&rig, options, NO_LIMITS, "test:0").unwrap();
        assert_eq!(plan.slices(31).count(), 1);
        let dispatches = plan.dispatches(31);
        let mut stages: Vec<Stage> = dispatches.iter().map(|d| d.stage).collect();
        assert_eq!(stages.len(), kernels);
        // Two kernels for the detail, and up to five for the large scale.
        stages.dedup();
        assert_eq!(stages, in_order);
        // Each kernel runs, and each buffer is planned, once.
        let runs =
            Kernel::ALL.iter().filter(|kernel| dispatches.iter().any(|d| d.kernel == **kernel)).count();
        assert_eq!(runs, kernels - 1, "the normals run twice");
        let planned = |buffer| plan.buffers().iter().filter(|planned| planned.buffer == buffer).count();
        let planned = Buffer::ALL.map(planned);
        assert_eq!((planned.iter().max(), planned.iter().sum()), (Some(&1), buffers));
        let bytes: u64 = plan.buffers().iter().map(|b| b.bytes).sum();
        assert_eq!(plan.bytes(), bytes);
    }
}

#[test]
fn parts_and_slices_cover_everything_once_and_keep_the_limits() {
    let (vectors, lengths) = (large_rig(1000), of_lengths(large_rig(1000)));
    let turning = turning(&vectors);
    let vertices = vectors.vertices();
    for (max_binding_bytes, max_workgroups, max_frames) in
        [(1 << 14, u32::MAX, 1), (100_000, u32::MAX, 31), (1 << 20, 3, 7), (40_000, 5, 100)]
    {
        for (rig, basis) in [&vectors, &lengths, &turning]
            .into_iter()
            .flat_map(|rig| BasisStorage::ALL.map(|basis| (rig, basis)))
        {
            let limits = PlanLimits { max_binding_bytes, max_workgroups };
            let options = UploadOptions { max_frames, basis };
            let plan = Plan::new(rig, options, limits, "test:0");
            let plan = plan.unwrap_or_else(|e| panic!("{limits:?}: {e}"));
            assert!(plan.buffers().iter().all(|b| b.bytes <= max_binding_bytes && b.bytes % 4 == 0));
            for (i, buffer) in plan.buffers().iter().enumerate() {
                let filled = plan.contents(rig, i).len() as u64;
                match buffer.role {
                    Role::Constant { .. } => {
                        assert!(filled == buffer.bytes || buffer.bytes == 16, "{buffer:?}");
                    }
                    _ => assert_eq!(filled, 0),
                }
            }
            for frames in [1, max_frames / 2 + 1, max_frames] {
                let mut covered = vec![0; frames];
                for slice in plan.slices(frames) {
                    covered[slice.frames.clone()].iter_mut().for_each(|n| *n += 1);
                }
                assert!(covered.iter().all(|&n| n == 1), "{covered:?}");
                let handles = rig.handles().len();
                let positions: Vec<f32> = (0..frames * handles * 3).map(|i| i as f32).collect();
                let mut written = [Vec::new(), Vec::new(), Vec::new(), Vec::new()];
                let mut motions = Vec::new();
                for input in plan.inputs(HandleFrames { positions: &positions, frames }) {
                    let buffer = &plan.buffers()[input.buffer];
                    assert!(buffer.bytes >= 4 * input.numbers.len() as u64);
                    let which = match buffer.buffer {
                        Buffer::HandlePositions => 0,
                        Buffer::Displacements => 1,
                        Buffer::Motions => 2,
                        _ => 3,
                    };
                    if which == 3 {
                        assert_eq!(buffer.buffer, Buffer::VectorExcess);
                    }
                    written[which].extend_from_slice(&input.numbers);
                }
                if rig.handles().rotations {
                    let of_rig = rig.handles().motions(positions.as_chunks().0);
                    motions = of_rig.vectors.into_iter().flat_map(|[x, y, z]| [x, y, z, 0.0]).collect();
                }
                assert_eq!(written[2], motions);
                // Three numbers of each feature, and in the first one whether any is beyond.
                let features = rig.handles().features();
                assert_eq!(written[3].len(), frames * features * 4);
                for of_frame in written[3].chunks_exact(4 * features) {
                    let is_beyond = of_frame.chunks_exact(4).any(|d| d[..3].iter().any(|x| *x != 0.0));
                    assert_eq!(of_frame[3] != 0.0, is_beyond);
                    assert!(is_beyond, "handles far from rest are beyond the only example");
                }
                assert_eq!(written[0], positions);
                for (i, u) in written[1].chunks_exact(4).enumerate() {
                    let rest = rig.handles().rest[i % handles];
                    assert_eq!(
                        u,
                        [0, 1, 2, 3].map(|c| if c < 3 { positions[3 * i + c] - rest[c] } else { 0.0 })
                    );
                }
                assert_eq!(written[1].len(), frames * handles * 4);

                // Any device has more than the four workgroups that a frame needs where handles turn.
                let dispatches = plan.dispatches(frames);
                let fits = |dispatch: &Dispatch| dispatch.workgroups.iter().all(|&n| n <= max_workgroups);
                assert!(max_workgroups < 4 || dispatches.iter().all(fits), "{basis:?}");

                let of_vertices = Kernel::ALL.map(Kernel::entry).map(|entry| (entry.name, entry.each));
                let runs = |name| plan.dispatches(frames).iter().any(|d| d.kernel.name() == name);
                let of_vertices =
                    of_vertices.into_iter().filter(|(name, each)| *each == Each::Vertex && runs(*name));
                for (name, _) in of_vertices {
                    let mut covered = vec![0; vertices * frames];
                    let mut first_frame = 0;
                    for dispatch in plan
                        .dispatches(frames)
                        .iter()
                        .filter(|d| d.kernel.name() == name && d.stage != Stage::LargeScaleNormals)
                    {
                        let [of_slice, v, first, part] = dispatch.params[..4].try_into().unwrap();
                        assert_eq!(v as usize, vertices);
                        let in_workgroup = 64 * dispatch.kernel.entry().at_once;
                        // Where handles turn, one frame has four vectors of each handle. They are summed like
                        // four frames.
                        let in_a_frame = if rig.handles().rotations && name == "large_scale" { 4 } else { 1 };
                        let workgroups = [
                            part.div_ceil(in_workgroup),
                            (in_a_frame * of_slice).div_ceil(dispatch.frames_at_once),
                        ];
                        assert_eq!(dispatch.workgroups, workgroups);
                        assert!(dispatch.workgroups.iter().all(|&n| n <= max_workgroups));
                        for frame in first_frame..first_frame + of_slice as usize {
                            let all = frame * vertices + first as usize..;
                            covered[all][..part as usize].iter_mut().for_each(|n| *n += 1);
                        }
                        if (first + part) as usize == vertices {
                            first_frame += of_slice as usize;
                        }
                    }
                    assert!(covered.iter().all(|&n| n == 1), "{name}");
                }
            }
        }
    }
}

#[test]
fn a_smaller_batch_runs_the_first_dispatches_of_a_larger_one() {
    let rig = large_rig(1000);
    let limits = PlanLimits { max_binding_bytes: 100_000, max_workgroups: 3 };
    let plan = Plan::new(&rig, UploadOptions::frames(40), limits, "test:0").unwrap();
    let all = plan.dispatches(40);
    for frames in 1..40 {
        let fewer = plan.dispatches(frames);
        assert!(fewer.len() <= all.len());
        for (a, b) in fewer.iter().zip(&all) {
            assert_eq!((a.kernel, a.stage, &a.buffers), (b.kernel, b.stage, &b.buffers));
        }
    }
}

#[test]
fn what_a_device_cannot_do_is_said() {
    let rig = large_rig(1000);
    let refused = |limits| match Plan::new(&rig, UploadOptions::frames(1), limits, "test:0") {
        Err(Error::Device { kind: DeviceErrorKind::Unsupported, device, message }) => {
            assert_eq!(device, "test:0");
            message
        }
        other => panic!("{other:?}"),
    };
    let message = refused(PlanLimits { max_binding_bytes: 11_999, ..NO_LIMITS });
    assert!(message.contains("11999"), "{message}");
    refused(PlanLimits { max_binding_bytes: 500, ..NO_LIMITS });
    refused(PlanLimits { max_workgroups: 0, ..NO_LIMITS });
}

/// The words of a constant buffer, for a rig with one part.
fn words(rig: &Rig, buffer: Buffer) -> Vec<u32> {
    let plan = Plan::new(rig, UploadOptions::frames(1), NO_LIMITS, "test:0").unwrap();
    let index = plan.buffers().iter().position(|planned| planned.buffer == buffer).unwrap();
    let contents = plan.contents(rig, index);
    contents.as_chunks().0.iter().map(|&bytes| u32::from_ne_bytes(bytes)).collect()
}

#[test]
fn a_tiles_influences_are_those_of_its_vertices() {
    let rig = changed(&rig(), |r| {
        r.influences.weights.row_mut(0).fill(0.0);
        r.influences.weights.row_mut(3)[1] = f32::from_bits(7);
        // One tile has no anchor at all.
        let weights = &mut r.learned.as_mut().unwrap().anchor_weights;
        (0..16).for_each(|v| weights.row_mut(v).fill(0.0));
    })
    .unwrap();
    let vertices = rig.vertices();
    let [offsets, features, weights] =
        [Buffer::InfluenceOffsets, Buffer::Influences, Buffer::InfluenceWeights].map(|b| words(&rig, b));
    let tiles = vertices.div_ceil(16);
    assert_eq!(offsets.len(), 2 * tiles + 1);
    assert_eq!((features.len() as u32, weights.len()), (offsets[2 * tiles], 16 * features.len()));
    let learned = rig.learned().unwrap();
    let edges = rig.handles().strain_edges.len() as u32;
    for (list, rows) in offsets.array_windows().map(|&[a, b]| a as usize..b as usize).enumerate() {
        let tile = list / 2;
        // First strain edges, then anchors, counted from F.
        let of_rig = |v: usize| -> Vec<(u32, f32)> {
            match list % 2 {
                _ if v >= vertices => Vec::new(),
                0 => rig.influences().at(v).map(|(e, weight)| (e.0, weight)).collect(),
                _ => learned.anchors_of(v).map(|(h, weight)| (edges + h.0, weight)).collect(),
            }
        };
        assert!(features[rows.clone()].is_sorted_by(|a, b| a < b), "{tile}");
        for lane in 0..16 {
            let row = |row: usize| (features[row], f32::from_bits(weights[16 * row + lane]));
            let found: Vec<(u32, f32)> = rows.clone().map(row).filter(|(_, weight)| *weight != 0.0).collect();
            let v = 16 * tile + lane;
            let expected: Vec<(u32, f32)> =
                of_rig(v).into_iter().filter(|(_, weight)| *weight != 0.0).collect();
            assert_eq!(found, expected, "vertex {v}");
        }
        // The first tile has no anchors, so its list has a single one with weight 0. Every other row has a
        // weight.
        let mut of_rows = rows.clone().map(|row| &weights[16 * row..][..16]);
        match list {
            1 => assert!(rows.len() == 1 && of_rows.all(|row| row.iter().all(|&weight| weight == 0))),
            _ => assert!(of_rows.all(|row| row.iter().any(|&weight| weight != 0)), "{tile}"),
        }
    }
}

#[test]
fn fans_have_every_triangle_at_each_of_its_vertices() {
    let rig = rig();
    let vertices = rig.vertices() as u32;
    let (offsets, fans) = (words(&rig, Buffer::FanOffsets), words(&rig, Buffer::Fans));
    assert_eq!(fans.len(), 16 * offsets[rig.vertices().div_ceil(16)] as usize);
    assert!(fans.iter().all(|&v| v < vertices));
    let mut found: Vec<[u32; 3]> = Vec::new();
    for v in 0..vertices {
        let tile = v as usize / 16;
        let rows = offsets[tile] as usize..offsets[tile + 1] as usize;
        let fan: Vec<u32> = rows.map(|row| fans[16 * row + v as usize % 16]).collect();
        let pairs = fan.array_windows().filter(|pair: &&[u32; 2]| !pair.contains(&v));
        found.extend(pairs.map(|&[a, b]| [v, a, b]));
    }
    let corners = |&[a, b, c]: &[u32; 3]| [[a, b, c], [b, c, a], [c, a, b]];
    let mut expected: Vec<[u32; 3]> = rig.surface().triangles.iter().flat_map(corners).collect();
    found.sort_unstable();
    expected.sort_unstable();
    assert!(found == expected, "{} for {} corners", found.len(), expected.len());
}
