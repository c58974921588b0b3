//! Where the vertices are: on WebGPU, on the processor in the browser, and here.
use super::*;
use rhytid_core::BasisStorage;

/// Frames of the take that are compared.
const FRAMES: [usize; 3] = [0, 17, 44];

/// The largest difference on WebGPU, as a part of the face's height.
const TOLERANCE: f32 = 2e-5;

struct Case {
    file: &'static str,
    rig: &'static Rig,
    basis: BasisStorage,
}

fn cases() -> Vec<Case> {
    let faces = &package().faces;
    let f32 = BasisStorage::F32;
    let case = |file, rig, basis| Case { file, rig, basis };
    vec![
        case("learned.safetensors", &faces.learned, f32),
        case("learned.safetensors.gz", &faces.learned, BasisStorage::F16),
        case("learned.safetensors", &faces.learned, BasisStorage::Clustered),
        case("packed.safetensors", &faces.packed, f32),
        case("chapter.safetensors", &faces.chapter, f32),
        case("turning.safetensors", &faces.turning, f32),
        case("seams.safetensors", &faces.seams, f32),
    ]
}

/// What a page draws and reads for each case and frame. `options` are for `open`.
fn found(page: &str, options: &str) -> Value {
    let faces = &package().faces;
    let frames: Vec<Vec<f32>> = FRAMES.iter().map(|&frame| faces.frame(frame)).collect();
    let cases: Vec<Value> =
        cases().iter().map(|case| json!({ "file": case.file, "basis": case.basis.name() })).collect();
    let body = format!(
        "const results = [];
        for (const {{ file, basis }} of {}) {{
            const opened = await open(file, {{ basis, ...{options} }});
            for (const positions of {}) {{
                opened.face.pose(positions);
                opened.draw();
                const result = {{ on: opened.face.evaluatedOn, stages: {{}} }};
                result.positions = await opened.drawn('position');
                result.normals = await opened.drawn('normal');
                for (const stage of player.STAGES) result.stages[stage] = Array.from(await opened.face.read(stage));
                results.push(result);
            }}
            opened.close();
        }}
        return results;",
        Value::from(cases),
        json!(frames)
    );
    run(page, &body)
}

/// The numbers of vertices and of the copies at seams, from those of vertices.
fn drawn(rig: &Rig, numbers: &[f32]) -> Vec<f32> {
    let mut numbers = numbers.to_vec();
    rhytid_player::Drawing::new(rig.surface()).unwrap().add_copies(&mut numbers);
    numbers
}

/// Compares what a page found with what the processor computes here.
fn agree(results: &Value, evaluated_on: &str) {
    let mut results = results.as_array().unwrap().iter();
    for Case { file, rig, basis } in cases() {
        let mut largest = 0.0_f32;
        for frame in FRAMES {
            let result = results.next().unwrap();
            assert_eq!(result["on"], evaluated_on, "{file}");
            let expected = expected(rig, basis, &package().faces.frame(frame));
            let height = height(rig);
            let most = |stage| match stage {
                // A ratio, and directions.
                Stage::Strain => 1e-5,
                Stage::Normals | Stage::LargeScaleNormals => 2e-3,
                _ => TOLERANCE * height,
            };
            for (stage, expected) in Stage::ALL.into_iter().zip(&expected) {
                let off = off(&floats(&result["stages"][stage.name()]), expected);
                assert!(off <= most(stage), "{file}, {basis:?}, frame {frame}, {stage:?}: {off}");
            }
            for (name, stage) in [("positions", Stage::Positions), ("normals", Stage::Normals)] {
                let off = off(&floats(&result[name]), &drawn(rig, &expected[stage as usize]));
                assert!(off <= most(stage), "{file}, {basis:?}, frame {frame}, {name} as drawn: {off}");
                if stage == Stage::Positions {
                    largest = largest.max(off / height);
                }
            }
        }
        println!("{evaluated_on}, {file}, {basis:?}: {largest:e} of the face's height off");
    }
    assert!(results.next().is_none());
}

#[test]
fn three_draws_what_webgpu_computes_and_that_is_what_the_processor_computes() {
    agree(&found("gpu.html", "{}"), "webgpu");
}

/// WebAssembly has no fused multiplication, so the last bits are others than here.
#[test]
fn without_webgpu_the_processor_evaluates_for_both_renderers() {
    let results = found("gpu.html", "{ gpu: false }");
    agree(&results, "cpu");
    assert!(found("gl.html", "{}") == results, "the renderers show other numbers");
}

/// A device that does not take a kernel: the processor evaluates, and a warning says so.
#[test]
fn where_webgpu_refuses_the_face_the_processor_takes_over() {
    let frame = package().faces.frame(17);
    let body = format!(
        "const {{ face, draw, drawn }} = await open('seams.safetensors');
        face.pose({frame:?});
        draw();
        for (let i = 0; i < 100 && face.evaluatedOn === 'webgpu'; i += 1) {{
            await new Promise((done) => setTimeout(done, 20));
            draw();
        }}
        return {{ on: face.evaluatedOn, positions: await drawn('position') }};"
    );
    let spoil = "const { createShaderModule } = GPUDevice.prototype;
        GPUDevice.prototype.createShaderModule = function (descriptor) {
            const isOurs = descriptor.label === 'fine_scale';
            return createShaderModule.call(this, isOurs ? { ...descriptor, code: 'no shader' } : descriptor);
        };";
    let (found, said) = heard("gpu.html", &body, json!({ "before": spoil }));
    assert_eq!(found["on"], "cpu");
    let warnings = said.as_array().unwrap().iter().filter_map(Value::as_str);
    let warning = "rhytid: WebGPU refuses the face, so the processor evaluates it: ";
    assert_eq!(warnings.filter(|said| said.starts_with(warning)).count(), 1, "{said}");
    let rig = &package().faces.seams;
    let expected = expected(rig, BasisStorage::F32, &frame);
    let off = off(&floats(&found["positions"]), &drawn(rig, &expected[Stage::Positions as usize]));
    assert!(off <= TOLERANCE * height(rig), "{off}");
}

#[test]
fn handles_are_posed_by_number_or_by_name_and_meshes_share_the_pose() {
    let faces = &package().faces;
    let handles = faces.learned.handles();
    let (name, frame) = (&handles.labels[3], faces.frame(17));
    let found = run(
        "gpu.html",
        &format!(
            "const {{ face, mesh, scene, draw, drawn, look }} = await open('learned.safetensors');
            const second = face.mesh3js(THREE);
            second.position.x = 100;
            scene.add(second);
            const found = {{ shared: second.geometry === mesh.geometry, names: face.handles.map((h) => h.name) }};
            face.pose({frame:?});
            face.pose({{ '{name}': [1, 2, 3] }});
            found.byObject = Array.from(face.positions);
            face.pose(new Map([['{name}', [4, 5, 6]]]));
            found.byMap = Array.from(face.positions);
            found.unknown = await refused(() => face.pose({{ nose: [0, 0, 0] }}));
            found.flat = await refused(() => face.pose({{ '{name}': [0, 0] }}));
            found.short = await refused(() => face.pose([1, 2, 3, 4]));
            found.infinite = await refused(() => face.pose(face.positions.fill(Infinity)));
            found.kept = Array.from(face.positions);
            found.unknownStage = await refused(() => face.read('wrinkles'));
            draw();
            found.memory = face.memory;
            mesh.geometry.dispose();
            draw();
            found.again = await drawn('position');
            return found;"
        ),
    );
    assert_eq!(found["shared"], true);
    assert_eq!(found["names"], json!(handles.labels));
    let moved = |to: [f32; 3]| {
        let mut moved = frame.clone();
        moved[9..12].copy_from_slice(&to);
        moved
    };
    assert_eq!(floats(&found["byObject"]), moved([1.0, 2.0, 3.0]));
    assert_eq!(floats(&found["byMap"]), moved([4.0, 5.0, 6.0]));
    assert_eq!(floats(&found["kept"]), moved([4.0, 5.0, 6.0]), "a refused pose changes nothing");
    for (what, kind, words) in [
        ("unknown", "UnknownMarkers", "there is no handle “nose”"),
        ("flat", "Mismatch", "has 2 coordinates, expected 3"),
        ("short", "Mismatch", "a batch of handle positions has 4 numbers, expected a multiple of"),
        ("infinite", "OutOfRange", "expected a finite position"),
        ("unknownStage", "UnknownName", "there is no stage “wrinkles”, expected one of strain"),
    ] {
        let refused = &found[what];
        assert_eq!((&refused["kind"], &refused["isOurs"]), (&json!(kind), &json!(true)), "{what}: {refused}");
        assert!(refused["sentence"].as_str().unwrap().contains(words), "{what}: {refused}");
    }
    // All buffers hold at least the basis.
    let basis = faces.learned.basis().as_slice().len() * 4;
    assert!(found["memory"]["device"].as_u64().unwrap() > basis as u64, "{found}");
    // A geometry that was disposed of is drawn again.
    let expected = expected(&faces.learned, BasisStorage::F32, &moved([4.0, 5.0, 6.0]));
    let off = off(&floats(&found["again"]), &expected[Stage::Positions as usize]);
    assert!(off < TOLERANCE * height(&faces.learned), "{off}");
}
