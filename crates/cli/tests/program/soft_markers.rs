//! Soft markers: noise is warned of, taken out by choice, and stated in the file.

use crate::common::{demo, rhytid, stderr};
use rhytid::core::Take;
use rhytid::formats::{animation, tables, take};
use std::path::Path;

fn done(command: &str, folder: &Path) -> String {
    let output = rhytid(command).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{command}: {}", stderr(&output));
    stderr(&output)
}

/// The demo's performance with 0.3 mm of noise per axis, and without.
fn takes(folder: &Path) -> [Take; 2] {
    let labels = tables::read_handles(&demo().join("markers.csv")).unwrap().labels;
    let clean = take::read(&demo().join("performance.csv"), Some(&labels), take::Missing::Error).unwrap();
    let uniform = |i: usize| ((i as f64 * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0);
    // The sum of twelve uniform numbers is nearly normal. The unit is the centimetre.
    let normal = |i: usize| (0..12).map(|k| uniform(12 * i + k)).sum::<f64>() - 6.0;
    let mut noisy = clean.clone();
    for (i, x) in noisy.positions.as_flattened_mut().iter_mut().enumerate() {
        *x += 0.03 * normal(i);
    }
    take::write(&folder.join("noisy.csv"), &noisy).unwrap();
    [noisy, clean]
}

#[test]
fn noise_is_warned_of_and_taken_out() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let [noisy, clean] = takes(folder);
    let rig = demo().join("face.safetensors");
    let rig = if rig.exists() {
        rig.display().to_string()
    } else {
        done(&format!("solve {} -o face.safetensors", demo().join("face.toml").display()), folder);
        "face.safetensors".to_owned()
    };
    let handles = tables::read_handles(&demo().join("markers.csv")).unwrap();
    let mut errors = Vec::new();
    for (name, options, words) in
        [("exact.usdc", "", "mm of noise per axis"), ("soft.usdc", "--soft-markers", "")]
    {
        let said = done(&format!("animate {rig} noisy.csv -o {name} --device cpu:0 {options}"), folder);
        assert_eq!(said.contains("(see --soft-markers)"), options.is_empty(), "{said}");
        assert!(said.contains(words), "{said}");
        // The file states how its markers were treated, so the same is compared.
        done(&format!("verify {name} --rig {rig} --take noisy.csv"), folder);
        let mut reader = animation::open(&folder.join(name)).unwrap();
        let mut positions = Vec::new();
        let mut squares = 0.0;
        for (frame, truth) in clean.positions.chunks(handles.len()).enumerate() {
            reader.positions(frame, &mut positions).unwrap();
            let positions: Vec<[f64; 3]> =
                positions.as_chunks::<3>().0.iter().map(|x| x.map(f64::from)).collect();
            let found = handles.at(&positions);
            let pairs = found.as_flattened().iter().zip(truth.as_flattened());
            squares += pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        }
        errors.push(10.0 * (squares / (3 * clean.positions.len()) as f64).sqrt());
    }
    assert_eq!(noisy.positions.len(), clean.positions.len());
    assert!((errors[0] - 0.3).abs() < 0.01, "{errors:?}");
    assert!(errors[1] < 0.1, "{errors:?}");
}
