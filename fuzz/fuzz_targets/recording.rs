//! Any frames, recorded as they come, are a sound take at every moment. A file that was cut short is a take
//! of the frames before, or an error.
#![no_main]
use libfuzzer_sys::arbitrary::{self, Arbitrary};
use libfuzzer_sys::fuzz_target;
use rhytid_core::{Error, Take};
use rhytid_formats::take::{Missing, TakeStream, decode, read};

#[derive(Debug, Arbitrary)]
struct Recording {
    labels: Vec<String>,
    frames: Vec<(u16, Vec<f32>, u8)>,
    cut: u16,
}

fuzz_target!(|recording: Recording| {
    let folder = std::env::temp_dir().join(format!("rhytid-fuzz-recording-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("take.csv");
    // Tables carry no blanks around a label. A rig's labels are distinct.
    let labels = recording.labels.iter().take(8).enumerate();
    let mut labels: Vec<String> = labels.map(|(i, label)| format!("{}{i}", label.trim_start())).collect();
    if labels.is_empty() {
        labels.push("brow".to_owned());
    }
    let mut stream = TakeStream::create(&path, &labels).expect("a new folder");
    let mut sent = Take { labels: labels.clone(), confidence: Some(Vec::new()), ..Take::default() };
    for (later, numbers, confidence) in recording.frames.iter().take(20) {
        let time = sent.times.last().unwrap_or(&0.0) + (1.0 + f64::from(*later)) / 1000.0;
        let number = |i: usize| numbers.get(i).copied().filter(|x| x.is_finite()).unwrap_or(0.5);
        let markers = 0..labels.len();
        let positions: Vec<[f32; 3]> = markers.map(|m| [0, 1, 2].map(|axis| number(3 * m + axis))).collect();
        // At least one confidence is below 1, so that the reader keeps them.
        let confidence = vec![f32::from(*confidence) / 256.0; labels.len()];
        stream.frame(time, &positions, &confidence).expect("a new folder");
        sent.times.push(time);
        sent.positions.extend(positions.iter().map(|p| p.map(f64::from)));
        sent.confidence.as_mut().unwrap().extend(confidence);
        assert_eq!(read(&path, None, Missing::Error).expect("a sound take"), sent);
    }
    let bytes = std::fs::read(&path).unwrap();
    match decode(&bytes[..usize::from(recording.cut).min(bytes.len())], "fuzz", None, Missing::Leave) {
        Ok(take) => assert!(take.frames() <= sent.frames()),
        Err(Error::Input(sentence)) => assert!(sentence.sentence().starts_with("fuzz"), "{sentence}"),
        Err(other) => panic!("expected an input error, found {other:?}"),
    }
});
