//! Live streams: datagrams that the bridge of the examples passes on to a page.
use super::*;
use rhytid_live::Frame;
use std::io::{BufRead, BufReader};
use std::net::UdpSocket;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// The bridge, which ends with the test.
struct Bridge {
    process: Child,
    udp: u16,
    web: u16,
}

impl Bridge {
    /// Starts it. Port 0 is any free one.
    fn start(udp: u16, web: u16) -> Self {
        // node looks for packages beside the program.
        let program = root().join("target/node/bridge.mjs");
        std::fs::copy(root().join("examples/three/bridge.mjs"), &program).unwrap();
        let mut command = Command::new("node");
        command.arg(program).args([udp.to_string(), web.to_string()]).stdout(Stdio::piped());
        let mut process = command.spawn().expect("node starts: run `cargo xtask setup`");
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let ports: Vec<u16> =
            line.split([' ', ',', ':']).filter_map(|word| word.trim().parse().ok()).collect();
        let [udp, web] = ports[..] else { panic!("the bridge says {line:?}; run `cargo xtask setup`") };
        Self { process, udp, web }
    }

    fn restart(&mut self) {
        let (udp, web) = (self.udp, self.web);
        self.stop();
        *self = Self::start(udp, web);
    }

    fn stop(&mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Whether the sender ends.
#[derive(Default)]
struct Done(AtomicBool);

/// Lets the sender end when it goes.
struct Ends<'a>(&'a Done);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.0.store(true, Ordering::Relaxed);
    }
}

/// Frame `number` of the take as a datagram, at 25 frames per second.
fn datagram(number: usize) -> Vec<u8> {
    let faces = &package().faces;
    let positions = faces.frame(number);
    let (positions, _) = positions.as_chunks::<3>();
    let markers = faces.learned.handles().labels.iter().cloned().zip(positions.iter().copied()).collect();
    Frame { number: number as i64, seconds: number as f64 / 25.0, markers }.encode().unwrap()
}

/// A page follows the stream. The sender breaks off, sends garbage, and comes back.
#[test]
fn a_page_follows_a_stream_and_finds_it_again() {
    let faces = &package().faces;
    let mut bridge = Bridge::start(0, 0);
    let (udp, web) = (bridge.udp, bridge.web);
    let done = Done::default();
    let (found, _) = std::thread::scope(|scope| {
        scope.spawn(|| {
            let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
            let send = |bytes: &[u8]| socket.send_to(bytes, (Ipv4Addr::LOCALHOST, udp)).unwrap();
            let is_done = || done.0.load(Ordering::Relaxed);
            // The page may come at any time, so frames 0 to 19 are sent again and again.
            let mut round = 0;
            while !is_done() {
                round += 1;
                for number in 0..20 {
                    send(&datagram(number));
                    if number == 7 {
                        send(b"garbage");
                    }
                    std::thread::sleep(Duration::from_millis(10));
                }
                // Longer than a stream is silent before it begins anew.
                std::thread::sleep(Duration::from_millis(1300));
                if round % 3 == 0 {
                    bridge.restart();
                }
            }
        });
        // However the visit ends, the sender ends, too.
        let _end = Ends(&done);
        heard(
            "gpu.html",
            &format!(
                "const {{ face, draw }} = await open('learned.safetensors');
                const live = face.follow('ws://127.0.0.1:{web}/');
                const found = {{ states: [], shown: [] }};
                const end = Date.now() + 40000;
                let lastNumber = null;
                while (Date.now() < end) {{
                    face.update();
                    draw();
                    if (live.state !== found.states.at(-1)) found.states.push(live.state);
                    const number = live.frame?.number ?? null;
                    if (number !== null && number !== lastNumber) {{
                        lastNumber = number;
                        found.shown.push([number, ...face.positions.slice(0, 3)]);
                    }}
                    const opened = found.states.filter((state) => state === 'open').length;
                    if (opened >= 2 && live.frame?.number === 19 && live.counts.frames > 40) break;
                    await new Promise((done) => setTimeout(done, 4));
                }}
                found.counts = live.counts;
                found.positions = Array.from(face.positions);
                found.confidence = live.frame.confidence;
                found.warnings = live.warnings;
                live.close();
                found.after = [live.state, live.counts.frames];
                found.wrong = await refused(() => face.follow('nowhere:9001'));
                return found;"
            ),
            json!({}),
        )
    });
    let states: Vec<&str> = found["states"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(states.iter().filter(|state| **state == "open").count() >= 2, "{states:?}");
    assert!(states.contains(&"waiting"), "{states:?}");
    assert_eq!(floats(&found["positions"]), faces.frame(19));
    assert!(found["confidence"].as_array().unwrap().iter().all(|confidence| *confidence == 1.0));
    for shown in found["shown"].as_array().unwrap() {
        let shown = floats(shown);
        let frame = faces.frame(shown[0] as usize);
        assert_eq!(shown[1..], frame[..3], "frame {}", shown[0]);
    }
    let counts = &found["counts"];
    assert!(counts["frames"].as_u64().unwrap() > 40 && counts["bad"].as_u64().unwrap() >= 1, "{counts}");
    assert_eq!(found["after"], json!(["closed", counts["frames"]]));
    let warnings = found["warnings"].to_string();
    assert!(warnings.contains("the connection ended (code 1006); it is tried again"), "{warnings}");
    assert_eq!(found["wrong"]["kind"], "Network", "{found}");
}
