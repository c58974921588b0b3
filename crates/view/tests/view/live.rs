//! Frames that arrive over the network.

use super::*;
use egui_kittest::kittest::NodeT;
use rhytid_live::{Frame, Sender};
use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

/// Listens at a port that the system chooses.
fn listen(view: &mut View) -> SocketAddr {
    view.state_mut().listen("127.0.0.1:0".parse().unwrap());
    view.step();
    view.state().listens_at().expect("a rig is open")
}

/// The panel's status of it.
fn said(view: &View) -> String {
    let node = view.get_by_label_contains("listening at").accesskit_node();
    node.label().or(node.value()).expect("words")
}

/// Draws until `what` is true.
fn until(view: &mut View, what: impl Fn(&View) -> bool) {
    let begin = Instant::now();
    while !what(view) {
        assert!(begin.elapsed() < Duration::from_secs(30), "it is not so: {}", said(view));
        std::thread::sleep(Duration::from_millis(2));
        view.step();
    }
}

fn says(words: &'static str) -> impl Fn(&View) -> bool {
    move |view| view.query_by_label_contains(words).is_some()
}

#[test]
fn a_take_that_is_sent_at_240_hz_is_followed_to_its_last_frame() {
    let folder = Folder::new();
    let mut view = opened(&folder, [1000.0, 900.0]);
    let take = rhytid_demo::performance(&demo().0);
    let in_take = take.handle_positions(&demo().1.handles().labels).unwrap();
    let h = 3 * demo().1.handles().len();
    let address = listen(&mut view);
    let frames = 3 * take.frames() as u64;
    let sending = std::thread::spawn(move || {
        Sender::new(&take, Some(240.0), address).unwrap().send(Some(3), &NoProgress).unwrap()
    });
    let junk = UdpSocket::bind("127.0.0.1:0").unwrap();
    let (mut seen, mut bad) = (Vec::new(), 0);
    while !sending.is_finished() {
        junk.send_to(&vec![b'#'; bad], address).unwrap();
        bad += 1;
        view.step();
        let handles = document(&view).handles(true);
        if document(&view).is_live() && seen.last() != Some(&handles) {
            assert!(
                in_take.chunks_exact(h).any(|frame| frame == handles.as_flattened()),
                "what is shown is no frame of the take"
            );
            seen.push(handles);
        }
    }
    assert_eq!(sending.join().unwrap().frames, frames);
    assert!(seen.len() > 2, "{} frames were shown in three seconds", seen.len());
    let counts = format!("{frames} frames, 0 lost, 0 late, {bad} bad; latency");
    until(&mut view, |view| view.query_by_label_contains(&counts).is_some());
    let last = &in_take[in_take.len() - h..];
    assert_eq!(document(&view).handles(true).as_flattened(), last, "not the frame that was sent last");
    let latency = said(&view);
    let milliseconds = latency.split("latency ").nth(1).and_then(|words| words.split(' ').next()).unwrap();
    assert!((0.0..5_000.0).contains(&milliseconds.parse::<f64>().unwrap()), "{latency}");
}

#[test]
fn late_and_bad_datagrams_change_nothing_and_lost_markers_fade() {
    let folder = Folder::new();
    let mut view = opened(&folder, [1000.0, 900.0]);
    let (rig, of_take) = (&demo().1, document(&view).handles(true));
    let address = listen(&mut view);
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let rest = &rig.handles().rest;
    let frame = |number: i64, seconds: f64, by: f32, from: usize| {
        let moved = rig.handles().labels.iter().cloned().zip(rest.iter().map(|p| [p[0] + by, p[1], p[2]]));
        let frame = Frame { number, seconds, markers: moved.skip(from).collect() };
        socket.send_to(&frame.encode().unwrap(), address).unwrap();
    };
    let x = |view: &View, handle: usize| document(view).handles(true)[handle][0] - rest[handle][0];
    frame(10, 0.0, 0.5, 0);
    until(&mut view, |view| document(view).is_live());
    assert!((x(&view, 0) - 0.5).abs() < 1e-5 && (x(&view, 1) - 0.5).abs() < 1e-5);
    assert!(document(&view).live_confidence().iter().all(|c| *c == 1.0));
    // Without the time line there is more room for the face.
    view.run_steps(3);
    // A sender that was silent for long may begin anew, so a late frame comes soon after another.
    frame(11, 0.1, 0.5, 0);
    until(&mut view, says("2 frames"));
    let drawn = view.state().times().unwrap().1;

    frame(9, 0.2, 0.9, 0);
    socket.send_to(b"/rhytid/frame", address).unwrap();
    socket.send_to(b"#bundle\0", address).unwrap();
    until(&mut view, says("2 frames, 0 lost, 1 late, 2 bad"));
    assert!((x(&view, 0) - 0.5).abs() < 1e-5);
    assert_eq!(view.state().times().unwrap().1, drawn, "the face is not drawn again");

    // A quarter of a second later the first marker is not seen. It stays where it is, with half the
    // confidence.
    frame(12, 0.35, 0.7, 1);
    until(&mut view, says("1 of"));
    let moved = [x(&view, 0), x(&view, 1)];
    assert!((moved[0] - 0.5).abs() < 1e-5 && (moved[1] - 0.7).abs() < 1e-5, "{moved:?}");
    let confidence = document(&view).live_confidence();
    assert!((confidence[0] - 0.5).abs() < 1e-3 && confidence[1] == 1.0, "{:?}", &confidence[..2]);

    // Another rig listens at the same address. When listening ends, the take is shown again.
    open(&mut view, &[folder.path("FACE.safetensors"), folder.path("take.csv")]);
    assert_eq!(view.state().listens_at(), Some(address));
    frame(13, 0.4, 0.1, 0);
    until(&mut view, |view| document(view).is_live());
    view.key_press(egui::Key::Space);
    view.step();
    view.get_by_label("End").click();
    view.step();
    view.key_press(egui::Key::Home);
    view.run();
    assert_eq!((view.state().listens_at(), document(&view).is_live()), (None, false));
    assert_eq!(document(&view).handles(true), of_take);
    view.get_by_label("Listen");
    // The address is free again.
    UdpSocket::bind(address).unwrap();
}

/// Positions in millimetres and with a turning head, from which the window takes the head out.
#[test]
fn a_turning_head_is_taken_out_of_positions_in_world_space() {
    const HIDDEN: usize = 9;
    let folder = Folder::new();
    let mut view = opened(&folder, [1000.0, 900.0]);
    let (rig, rest) = (&demo().1, &demo().1.handles().rest);
    let listen = rhytid_view::Listen {
        address: "127.0.0.1:0".parse().unwrap(),
        world: Some(rhytid_capture::Settings::default()),
        ..rhytid_view::Listen::default()
    };
    view.state_mut().listen_for(listen);
    view.step();
    let address = view.state().listens_at().expect("a rig is open");
    let extent = rest.iter().map(|p| p[1]).fold(0.0, f32::max);
    let cap = [[0.0, 1.4, 0.5], [0.7, 1.0, -0.1], [-0.7, 1.0, -0.1], [0.0, 1.6, -0.4]]
        .map(|p| p.map(|x| x * extent));
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let lift = |frame: usize| if frame < 80 { 0.0 } else { 0.02 * extent };
    for frame in 0..90 {
        let (sin, cos) = (0.3 * (frame as f32 / 15.0).sin()).sin_cos();
        let turned =
            |[x, y, z]: [f32; 3]| [cos * x + sin * z, y + 3.0 * extent, cos * z - sin * x].map(|x| 10.0 * x);
        let face = rig.handles().labels.iter().cloned().zip(rest.iter().copied());
        let moved = face.enumerate().map(|(j, (label, [x, y, z]))| {
            let lift = if j == 0 { lift(frame) } else { 0.0 };
            (label, [x, y + lift, z])
        });
        let cap = cap.iter().enumerate().map(|(i, p)| (format!("cap{i}"), *p));
        let mut markers: Vec<(String, [f32; 3])> =
            moved.chain(cap).map(|(label, p)| (label, turned(p))).collect();
        // No camera sees this marker for 0.3 s, which its sender says with 0, 0, 0.
        if frame >= 60 {
            markers[HIDDEN].1 = [0.0; 3];
        }
        let frame = Frame { number: frame as i64, seconds: frame as f64 / 100.0, markers };
        socket.send_to(&frame.encode().unwrap(), address).unwrap();
        std::thread::sleep(Duration::from_millis(10));
        view.step();
    }
    until(&mut view, says("90 frames"));
    view.step();
    let shown = document(&view).handles(true);
    for (j, (found, rest)) in shown.iter().zip(rest).enumerate() {
        let lift = if j == 0 { lift(89) } else { 0.0 };
        let expected = [rest[0], rest[1] + lift, rest[2]];
        let off = (0..3).map(|k| (found[k] - expected[k]).abs()).fold(0.0, f32::max);
        assert!(off < 1e-3 * extent, "{j}: {found:?}, expected {expected:?}; {}", said(&view));
    }
}
