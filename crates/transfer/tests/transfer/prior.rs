//! A prior from another face: what it is worth, when it is refused, and how it is read.
use crate::support::{face, minus, played, processor, rig, rms};
use glam::{DQuat, DVec3};
use rhytid_core::{Example, Face, NoProgress, Prior, Reach, rig_file};
use rhytid_formats::export::OutputStage;
use rhytid_formats::mesh;
use rhytid_solve::{TakenPrior, solve_in_full};
use rhytid_test_support::shared;
use rhytid_transfer::{Settings, read_face, transfer};
use std::path::Path;

/// The same expressions on another person: every displacement is changed by about a third, smoothly over the
/// face.
fn another_person(face: &Face) -> Vec<Example> {
    let rest = &face.neutral.positions;
    let changed = |x: &[f64; 3], rest: &[f64; 3]| {
        let (a, b) = (0.35 * rest[0] + 0.2 * rest[1], 0.3 * rest[1] - 0.25 * rest[2]);
        let d = DVec3::from_array(*x) - DVec3::from_array(*rest);
        let across = DVec3::new(0.25 * d.y * b.cos(), -0.2 * d.x * a.sin(), 0.2 * d.y * (a + b).sin());
        (DVec3::from_array(*rest) + d * (1.0 + 0.3 * a.sin()) + across).to_array()
    };
    let person = |example: &Example| Example {
        positions: example.positions.iter().zip(rest).map(|(x, rest)| changed(x, rest)).collect(),
        ..example.clone()
    };
    face.examples.iter().map(person).collect()
}

/// The person with the first `count` of the scans, and the RMS error in millimetres in the others.
fn with(face: &Face, person: &[Example], count: usize, prior: Option<Prior>) -> (Option<TakenPrior>, f64) {
    let face = Face { examples: person[..count].to_vec(), prior, ..face.clone() };
    let solved = solve_in_full(&face, false, &NoProgress).unwrap();
    let rig = solved.rig.rounded().unwrap();
    let handles: Vec<f32> =
        person.iter().flat_map(|scan| face.handles.at(&scan.positions)).flatten().map(|x| x as f32).collect();
    let found = played(&rig, &handles, OutputStage::Full);
    let error = |(found, scan): (&Vec<[f64; 3]>, &Example)| {
        10.0 * rms(found.iter().zip(&scan.positions).map(|(a, b)| minus(a, b)))[0]
    };
    let errors: Vec<f64> = found.iter().zip(person).map(error).collect();
    for (scan, error) in person.iter().zip(&errors).take(count) {
        assert!(*error < 0.02, "{}: {error}", scan.name);
    }
    let others: Vec<f64> = errors[count..].iter().map(|error| error.powi(2)).collect();
    (solved.report.prior, (others.iter().sum::<f64>() / others.len() as f64).sqrt())
}

#[test]
fn three_scans_of_a_person_and_a_generic_face() {
    let Some(shared) = shared("") else { return };
    let generic = face(&shared, "face");
    let person = another_person(&generic);
    let prior = Prior { expressions: generic.examples.clone(), weight: None };
    for (count, at_most) in [(1, 0.5), (3, 0.7)] {
        let (_, without) = with(&generic, &person, count, None);
        let (taken, found) = with(&generic, &person, count, Some(prior.clone()));
        println!("{count} scans: {found:.3} mm with the prior, {without:.3} without; {taken:?}");
        assert!(found < at_most * without, "{count}: {found} of {without}");
        assert!(taken.is_some_and(|taken| taken.expressions == 8 && taken.weight > 0.5), "{taken:?}");
    }
    // Without any scan, the prior is better than the shell alone.
    let (taken, found) = with(&generic, &person, 0, Some(prior));
    let (_, shell) = with(&generic, &person, 0, None);
    assert!(found < 0.7 * shell && taken.is_some_and(|taken| taken.weight == 1.0), "{found} of {shell}");
}

#[test]
fn a_prior_that_is_wrong_changes_nothing() {
    let Some(shared) = shared("") else { return };
    let face = face(&shared, "face");
    let rest = &face.neutral.positions;
    // The markers move as they should, and the skin between them the other way.
    let held: Vec<usize> = face.handles.points.iter().map(|point| point.nearest_vertex().index()).collect();
    let opposite = |example: &Example| {
        let against = |(v, (x, rest)): (usize, (&[f64; 3], &[f64; 3]))| {
            let sign = if held.contains(&v) { 1.0 } else { -1.0 };
            [0, 1, 2].map(|c| rest[c] + sign * (x[c] - rest[c]))
        };
        let positions = example.positions.iter().zip(rest).enumerate().map(against).collect();
        Example { positions, ..example.clone() }
    };
    let prior = Prior { expressions: face.examples.iter().map(opposite).collect(), weight: None };
    let without = solve_in_full(&face, false, &NoProgress).unwrap();
    let with = solve_in_full(&Face { prior: Some(prior), ..face }, false, &NoProgress).unwrap();
    assert_eq!(with.report.prior, Some(TakenPrior { expressions: 8, weight: 0.0 }));
    assert_eq!(with.rig, without.rig);
}

/// Writes the neutral and the examples of a face.
fn write(folder: &Path, face: &Face) {
    std::fs::create_dir_all(folder).unwrap();
    mesh::write_obj(&folder.join("neutral.obj"), &face.neutral).unwrap();
    for example in &face.examples {
        let mesh = rhytid_core::Mesh { positions: example.positions.clone(), ..face.neutral.clone() };
        mesh::write_obj(&folder.join(format!("{}.obj", example.name)), &mesh).unwrap();
    }
}

#[test]
fn it_is_a_folder_of_meshes_or_a_rig() {
    let folder = tempfile::tempdir().unwrap();
    let mut first = rhytid_demo::face(3_000);
    first.examples.truncate(2);
    // The other neutral is turned, half as large again, and elsewhere.
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.2, 0.5);
    let moved =
        |x: &[f64; 3]| (1.5 * (turn * DVec3::from_array(*x)) + DVec3::new(3.0, -40.0, 7.0)).to_array();
    let mut generic = first.clone();
    generic.neutral.positions = first.neutral.positions.iter().map(moved).collect();
    for example in &mut generic.examples {
        example.positions = example.positions.iter().map(moved).collect();
    }
    write(&folder.path().join("generic"), &generic);
    write(folder.path(), &Face { examples: Vec::new(), ..first.clone() });
    let rows: Vec<String> = first
        .handles
        .labels
        .iter()
        .zip(&first.handles.points)
        .map(|(label, point)| format!("{label},{}\n", point.vertex().unwrap()))
        .collect();
    std::fs::write(folder.path().join("markers.csv"), format!("label,vertex\n{}", rows.concat())).unwrap();
    let project = folder.path().join("face.toml");
    let read = |section: &str| {
        let text = format!(
            "[mesh]\nneutral = \"neutral.obj\"\nunits = \"cm\"\n[handles]\nvertices = \"markers.csv\"\n{section}\n"
        );
        std::fs::write(&project, text).unwrap();
        read_face(&project, Reach::Below, &processor(), &NoProgress)
    };
    let apart = |found: &Face, expected: &[Example]| {
        let found = &found.prior.as_ref().unwrap().expressions;
        assert_eq!(found.len(), expected.len());
        let pairs = found.iter().flat_map(|e| &e.positions).zip(expected.iter().flat_map(|e| &e.positions));
        pairs.map(|(a, b)| DVec3::from_array(*a).distance(DVec3::from_array(*b))).fold(0.0, f64::max)
    };
    let found = read("[prior]\nfrom = \"generic\"\nweight = 0.5").unwrap();
    assert_eq!(found.prior.as_ref().unwrap().weight, Some(0.5));
    assert!(apart(&found, &first.examples) < 1e-5, "{}", apart(&found, &first.examples));

    let of_first = rig(&first);
    rig_file::write(&folder.path().join("first.safetensors"), &of_first).unwrap();
    let found = read("[prior]\nfrom = \"first.safetensors\"").unwrap();
    let settings = Settings { linear_band: true, landmarks: None };
    let bare = Face { examples: Vec::new(), ..first.clone() };
    let expected = transfer(&of_first, &bare, &settings, &processor(), &NoProgress).unwrap();
    assert!(apart(&found, &expected.face.examples) < 1e-5);
    assert!(apart(&found, &first.examples) < 0.03);

    let error = |section: &str| read(section).unwrap_err().to_string();
    let text = error("[prior]\nfrom = \"nothing\"");
    assert!(text.contains("[prior] from names nothing, which is no folder"), "{text}");
    std::fs::rename(folder.path().join("generic/neutral.obj"), folder.path().join("rest.obj")).unwrap();
    let text = error("[prior]\nfrom = \"generic\"");
    assert!(text.contains("has no mesh called neutral") && text.contains("neutral = FILE"), "{text}");
    let found = read("[prior]\nfrom = \"generic\"\nneutral = \"rest.obj\"").unwrap();
    assert!(apart(&found, &first.examples) < 1e-5);
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    let text = error("[prior]\nfrom = \"empty\"\nneutral = \"rest.obj\"");
    assert!(text.contains("has no expression in it"), "{text}");
}
