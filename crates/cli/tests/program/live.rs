//! `send`, and `animate --listen`.

use crate::common::{Fixture, assert_refused, stderr};
use rhytid::Take;
use rhytid::formats::take::{self, Missing};
use std::io::{BufRead, BufReader, Read};
use std::net::UdpSocket;
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::Duration;

fn solved() -> Fixture {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f
}

/// A running `rhytid animate --listen`.
struct Listening {
    child: Child,
    stderr: BufReader<std::process::ChildStderr>,
    said: String,
    address: String,
}

fn listen(f: &Fixture, options: &str) -> Listening {
    let args = format!("animate face.safetensors --listen 127.0.0.1:0 --device cpu:0 {options}");
    let mut child = Command::new(env!("CARGO_BIN_EXE_rhytid"))
        .args(args.split_whitespace())
        .current_dir(f.path("."))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    let address = loop {
        assert!(stderr.read_line(&mut said).unwrap() > 0, "{args}: {said}");
        if let Some(behind) = said.split("listening at ").nth(1) {
            break behind.split_whitespace().next().unwrap().to_owned();
        }
    };
    Listening { child, stderr, said, address }
}

impl Listening {
    fn end(mut self) -> Output {
        self.stderr.read_to_string(&mut self.said).unwrap();
        Output { stderr: self.said.into_bytes(), ..self.child.wait_with_output().unwrap() }
    }

    #[cfg(unix)]
    fn wait_for(&mut self, line: &str) {
        while !self.said.contains(line) {
            assert!(self.stderr.read_line(&mut self.said).unwrap() > 0, "{}", self.said);
        }
    }
}

/// The fixture's take with a given number of frames, as `name`.
/// Its times are those of `send --rate 240`, and its positions are exact in `f32`.
fn take_at_240(f: &Fixture, name: &str, frames: usize) -> Take {
    f.write(name, f.take(frames));
    let mut take = take::read(&f.path(name), None, Missing::Error).unwrap();
    take.times = (0..frames).map(|frame| frame as f64 / 240.0).collect();
    take.positions.as_flattened_mut().iter_mut().for_each(|x| *x = f64::from(*x as f32));
    take::write(&f.path(name), &take).unwrap();
    take
}

#[test]
fn a_take_that_is_sent_is_recorded_and_animated_as_its_file_is() {
    let f = solved();
    let sent = take_at_240(&f, "sent.csv", 720);
    let listening = listen(&f, "--frames 720 -o live.usd --record came.csv");
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let to = listening.address.clone();
    let junk = thread::spawn(move || {
        for size in 0..1_000 {
            socket.send_to(&vec![b'/'; size], &to).unwrap();
            thread::sleep(Duration::from_millis(2));
        }
    });
    let said = f.done(&format!("send sent.csv --rate 240 --to {}", listening.address));
    assert!(said.contains("720 frames of 5 markers"), "{said}");
    junk.join().unwrap();
    let output = listening.end();
    assert!(output.status.success(), "{}", stderr(&output));
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("720 frames over 2.996 s, 0 lost, 0 late, 1000 bad; latency "), "{said}");

    let came = take::read(&f.path("came.csv"), None, Missing::Error).unwrap();
    assert_eq!(came, sent);
    f.done("animate face.safetensors sent.csv --device cpu:0 -o sent.usd");
    assert!(f.read("live.usd") == f.read("sent.usd"), "another animation");
    f.done("verify live.usd --rig face.safetensors --take came.csv --device cpu:0");
}

#[test]
fn what_a_sender_lacks_is_held_and_said() {
    let f = solved();
    let sent = take_at_240(&f, "sent.csv", 40);
    let fewer = Take {
        labels: sent.labels[..4].to_vec(),
        positions: sent.positions.chunks(5).flat_map(|frame| &frame[..4]).copied().collect(),
        ..sent.clone()
    };
    take::write(&f.path("fewer.csv"), &fewer).unwrap();
    let listening = listen(&f, "--frames 100 --timeout 1 -o live.usd --record came.csv --fade-detail");
    f.done(&format!("send fewer.csv --frames 10.. --to {}", listening.address));
    let output = listening.end();
    let said = stderr(&output);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("no frame arrived for 1 s: the recording lacks the last 70 frames"), "{said}");
    assert!(said.contains("1 of the rig's 5 handles were in no frame and stay at rest: middle"), "{said}");
    let came = take::read(&f.path("came.csv"), None, Missing::Error).unwrap();
    assert_eq!((came.frames(), came.labels.len()), (30, 5));
    let confidence = came.confidence.unwrap();
    assert!(confidence.chunks(5).all(|frame| frame == [1.0, 1.0, 1.0, 1.0, 0.0]));
    assert_eq!(came.positions[..4], sent.positions[50..54]);
}

#[test]
#[cfg(unix)]
fn ctrl_c_ends_a_recording_and_keeps_what_has_come() {
    let f = solved();
    take_at_240(&f, "sent.csv", 240);
    let mut listening = listen(&f, "--frames 100000 -o live.usd --record came.csv");
    f.done(&format!("send sent.csv --to {}", listening.address));
    let kill = |child: &Child| {
        let kill = Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status();
        assert!(kill.unwrap().success());
    };
    kill(&listening.child);
    listening.wait_for("the recording ends");
    let output = listening.end();
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(take::read(&f.path("came.csv"), None, Missing::Error).unwrap().frames(), 240);
    f.done("verify live.usd --rig face.safetensors --take came.csv --device cpu:0");
    // Before the first frame there is nothing to keep.
    let listening = listen(&f, "--frames 10 -o out/live.usd --record out/came.csv");
    kill(&listening.child);
    assert_refused(&listening.end(), &["stopped before the end"]);
    f.assert_nothing_written();

    let mut sending = Command::new(env!("CARGO_BIN_EXE_rhytid"))
        .args(["send", "sent.csv", "--loop", "--to", "127.0.0.1:9"])
        .current_dir(f.path("."))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = String::new();
    BufReader::new(sending.stderr.take().unwrap()).read_line(&mut said).unwrap();
    assert!(said.contains("until Ctrl-C"), "{said}");
    kill(&sending);
    assert!(sending.wait().unwrap().success());
}

#[test]
fn what_cannot_be_listened_to_or_sent_is_one_sentence() {
    let f = solved();
    let listen = "animate face.safetensors -o out/face.usd --device cpu:0";
    let short = "--listen 127.0.0.1:0 --timeout 0.2";
    f.refused(
        &format!("{listen} {short} --frames 5"),
        &["no frame came within 0.2 s", "no datagram arrived"],
    );
    f.refused(&format!("{listen} {short}"), &["--frames N"]);
    f.refused(&format!("{listen} {short} --frames 0"), &["from 1 to 1000000"]);
    f.refused(&format!("{listen} take.csv --frames 5"), &["--frames 5 is for --listen", "..5"]);
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    // A port without an address is one of this machine.
    f.refused(
        &format!("{listen} --listen {port} --frames 5"),
        &["127.0.0.1", "another program listens there"],
    );
    f.refused(&format!("{listen} --frames 5 --record out/face.usd {short}"), &["face.usd"]);
    f.refused("send face.safetensors", &["is a rig", "rhytid send TAKE"]);
    f.refused("send take.csv --frames 50..", &["the take has 20 frames"]);
    f.write("raw.trc", "PathFileType\t4\t(X/Y/Z)\traw.trc\n");
    f.refused("send raw.trc", &["is a raw take", "rhytid prepare raw.trc"]);
    f.write("other.csv", f.read_text("take.csv").replace("left_", "there_"));
    f.refused("send other.csv --rig face.safetensors", &["left"]);
}

/// A take in world space, in metres and with a turning head, sent as a capture system sends it.
#[test]
fn positions_in_world_space_are_recorded_and_cleaned_as_a_file_is() {
    let f = solved();
    f.write("still.csv", f.take(240));
    let still = take::read(&f.path("still.csv"), None, Missing::Error).unwrap();
    let cap = [[0.0, 1.4, 0.5], [0.7, 1.0, -0.1], [-0.7, 1.0, -0.1], [0.0, 1.6, -0.4]];
    let mut world = Take { labels: Vec::new(), positions: Vec::new(), ..still.clone() };
    world.labels.extend(still.labels.iter().map(|label| format!("Anna:{label}")));
    world.labels.extend((0..4).map(|i| format!("cap{i}")));
    world.times = (0..240).map(|frame| f64::from(frame) / 120.0).collect();
    for (frame, markers) in still.positions.chunks(still.labels.len()).enumerate() {
        let (sin, cos) = (0.4 * (frame as f64 / 40.0).sin()).sin_cos();
        let turned = |[x, y, z]: [f64; 3]| [cos * x + sin * z, y + 15.0, cos * z - sin * x];
        let in_f32 = |p: [f64; 3]| turned(p).map(|x| f64::from(x as f32));
        world.positions.extend(markers.iter().copied().chain(cap).map(in_f32));
    }
    take::write(&f.path("world.csv"), &world).unwrap();
    let options = "--world --rigid cap0,cap1,cap2,cap3 --neutral 0..10";
    let listening = listen(&f, &format!("--frames 240 -o live.usd --record raw.csv {options}"));
    f.done(&format!("send world.csv --to {}", listening.address));
    let output = listening.end();
    assert!(output.status.success(), "{}", stderr(&output));
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("240 frames over 1.992 s, 0 lost, 0 late, 0 bad"), "{said}");
    assert!(said.contains("rhytid prepare raw.csv --rig face.safetensors --world"), "{said}");
    let came = take::read(&f.path("raw.csv"), None, Missing::Error).unwrap();
    assert_eq!((came.labels, came.positions), (world.labels, world.positions));
    // The same from the file.
    f.done(&format!("prepare raw.csv --rig face.safetensors {options} -o clean.csv"));
    f.done("verify live.usd --rig face.safetensors --take clean.csv --device cpu:0");
    f.refused(
        "animate face.safetensors --listen 127.0.0.1:0 --frames 2 --shapes poses -o out/face.usd",
        &["--listen receives positions, so that --shapes poses changes nothing"],
    );
    f.write("setup.toml", "unit = \"mm\"\n");
    f.refused(
        "animate face.safetensors --listen 127.0.0.1:0 --frames 2 --setup setup.toml -o out/face.usd",
        &["--setup with --listen is for --world"],
    );
}

/// The noise of received markers is taken out as that of a file's.
#[test]
fn received_markers_are_softened() {
    let f = solved();
    f.write("noisy.csv", f.take(90));
    let mut noisy = take::read(&f.path("noisy.csv"), None, Missing::Error).unwrap();
    for (i, x) in noisy.positions.as_flattened_mut().iter_mut().enumerate() {
        *x += 0.05 * (i as f64 * i as f64 * 0.7).sin();
    }
    take::write(&f.path("noisy.csv"), &noisy).unwrap();
    let listening = listen(&f, "--frames 90 -o live.usd --record came.csv --soft-markers");
    f.done(&format!("send noisy.csv --to {}", listening.address));
    let output = listening.end();
    assert!(output.status.success(), "{}", stderr(&output));
    f.done("verify live.usd --rig face.safetensors --take came.csv --device cpu:0");
}

/// A recording that no face can be is kept if it is forced, whatever the format.
#[test]
fn a_torn_recording_in_world_space_is_forced() {
    let f = solved();
    f.write("still.csv", f.take(120));
    let mut torn = take::read(&f.path("still.csv"), None, Missing::Error).unwrap();
    torn.times = (0..120).map(|frame| f64::from(frame) / 120.0).collect();
    for frame in torn.positions.chunks_mut(5).skip(30) {
        frame[4][0] += 900.0;
    }
    take::write(&f.path("torn.csv"), &torn).unwrap();
    f.write("setup.toml", "unit = \"cm\"\nskip = [\"slides\", \"outliers\"]\nneutral = \"0..10\"\n");
    for (force, is_made) in [("", false), ("--force", true)] {
        let options = format!("--frames 120 -o live.usd --record raw.csv --world --setup setup.toml {force}");
        let listening = listen(&f, &options);
        f.done(&format!("send torn.csv --to {}", listening.address));
        let output = listening.end();
        let said = stderr(&output);
        assert_eq!(output.status.success(), is_made, "{said}");
        assert!(said.contains("cannot be a face's: middle is "), "{said}");
    }
}

/// Positions of another program, which has its own address and no numbers.
#[test]
fn positions_at_another_address_are_recorded() {
    let f = solved();
    let labels = ["left", "right", "top", "bottom", "middle"];
    let send = |address: &str| {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        for frame in 0..20 {
            for label in labels {
                let mut bytes = Vec::new();
                for text in [format!("/marker/{label}"), ",fff".to_owned()] {
                    bytes.extend(text.bytes());
                    bytes.resize(bytes.len() / 4 * 4 + 4, 0);
                }
                (0..3).for_each(|axis| bytes.extend((frame as f32 / 16.0 + axis as f32).to_be_bytes()));
                socket.send_to(&bytes, address).unwrap();
            }
            thread::sleep(Duration::from_millis(10));
        }
    };
    let listening =
        listen(&f, "--frames 20 --timeout 2 -o live.usd --record came.csv --address /marker/{label}");
    send(&listening.address);
    let output = listening.end();
    assert!(output.status.success(), "{}", stderr(&output));
    let came = take::read(&f.path("came.csv"), None, Missing::Error).unwrap();
    let expected = (0..20).flat_map(|frame| [[0.0, 1.0, 2.0].map(|x| x + f64::from(frame) / 16.0); 5]);
    assert_eq!(came.positions, expected.collect::<Vec<_>>());
    // Without the address, it is named.
    let listening = listen(&f, "--frames 20 --timeout 1 -o out/live.usd");
    send(&listening.address);
    assert_refused(
        &listening.end(),
        &["the address \"/marker/left\" (20 of them)", "expected /rhytid/frame"],
    );
}

#[test]
fn frames_of_another_rig_are_no_recording() {
    let f = solved();
    let other = f.read_text("take.csv");
    let renamed = ["left", "right", "top", "bottom", "middle"]
        .into_iter()
        .fold(other, |text, label| text.replace(&format!("{label}_"), &format!("m{label}_")));
    f.write("other.csv", renamed);
    let listening = listen(&f, "--frames 5 -o out/face.usd --record out/came.csv");
    f.done(&format!("send other.csv --to {}", listening.address));
    assert_refused(&listening.end(), &["no frame has a marker of the rig's 5 handles", "left"]);
    f.assert_nothing_written();
}

/// What is refused of a file of so many frames is refused before they come.
#[test]
fn a_recording_that_no_file_can_hold_is_not_begun() {
    let f = solved();
    let command = "animate face.safetensors --listen 127.0.0.1:0 --device cpu:0 --frames 300 -o out/face.glb";
    f.refused(command, &["300 frames with a morph target each"]);
}

/// A recording is on disk while it is recorded, and stays when its output cannot be written.
#[cfg(unix)]
#[test]
fn a_recording_outlives_what_goes_wrong() {
    let f = solved();
    let sent = take_at_240(&f, "sent.csv", 30);
    // Killed while it records.
    let mut listening = listen(&f, "--frames 1000 -o live.usd");
    f.done(&format!("send sent.csv --rate 240 --to {}", listening.address));
    let recording = f.path("live.recording.csv");
    let frames = || take::read(&recording, None, Missing::Error).map_or(0, |take| take.frames());
    let since = std::time::Instant::now();
    while frames() < 30 && since.elapsed() < Duration::from_secs(60) {
        thread::sleep(Duration::from_millis(20));
    }
    listening.child.kill().unwrap();
    listening.child.wait().unwrap();
    let came = take::read(&recording, None, Missing::Error).unwrap();
    assert_eq!((came.positions, came.times.len()), (sent.positions.clone(), 30));
    f.done("animate face.safetensors live.recording.csv --device cpu:0 -o again.usd");

    // Its folder vanishes; or a position overflows. The earlier recording stays, too.
    let mut far = sent.clone();
    far.positions[7] = [3e38; 3];
    take::write(&f.path("far.csv"), &far).unwrap();
    for (name, out) in [("sent.csv", "gone/live.usd"), ("far.csv", "live.usd")] {
        std::fs::create_dir_all(f.path("gone")).unwrap();
        let listening = listen(&f, &format!("--frames 30 -o {out}"));
        let _ = std::fs::remove_dir_all(f.path("gone"));
        f.done(&format!("send {name} --rate 240 --to {}", listening.address));
        let output = listening.end();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        let (_, kept) = said.split_once("the recording is in ").unwrap_or_else(|| panic!("{said}"));
        let (kept, advice) = kept.split_once("; make the output from it with `").unwrap();
        assert!(advice.starts_with("rhytid animate face.safetensors "), "{advice}");
        let kept = f.path(kept);
        assert_eq!(take::read(&kept, None, Missing::Error).unwrap().frames(), 30);
        assert_ne!(kept, recording);
        std::fs::remove_file(kept).unwrap();
    }
    assert!(recording.exists() && !f.path("live.usd").exists());
}
