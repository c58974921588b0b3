//! `rhytid view`: a window on a display of its own, and the message where there is no display.
//!
//! Xvfb is a display whose picture is a file; xdotool moves its pointer and presses its keys.

use crate::common::{Fixture, assert_refused, demo, rhytid, stderr};
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// The longest wait for the window, on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

struct Display {
    server: Child,
    name: String,
    folder: TempDir,
}

/// The display's picture: rows of blue, green, red and nothing.
struct Screen {
    width: usize,
    pixels: Vec<[u8; 4]>,
}

impl Display {
    /// `None` without Xvfb, or without a program that presses keys.
    fn start() -> Option<Self> {
        if Command::new("xdotool").arg("version").output().is_err() {
            rhytid_test_support::skip("there is no xdotool; `cargo xtask setup` installs it");
            return None;
        }
        let folder = TempDir::new().unwrap();
        let mut server = Command::new("Xvfb");
        server.args(["-displayfd", "1", "-screen", "0", "1240x880x24", "-nolisten", "tcp", "-fbdir"]);
        server.arg(folder.path()).stdout(Stdio::piped()).stderr(Stdio::null());
        let Ok(mut server) = server.spawn() else {
            rhytid_test_support::skip("there is no Xvfb; `cargo xtask setup` installs it");
            return None;
        };
        // Xvfb prints its display's number once it is ready.
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        assert!(number.trim().parse::<u32>().is_ok(), "Xvfb did not start: {number:?}");
        Some(Self { server, name: format!(":{}", number.trim()), folder })
    }

    /// The display's picture. An XWD file has a header of numbers of 4 bytes, colours of 12, and the rows.
    fn screen(&self) -> Screen {
        let file = std::fs::read(self.folder.path().join("Xvfb_screen0")).unwrap();
        let number = |i: usize| u32::from_be_bytes(file[4 * i..][..4].try_into().unwrap()) as usize;
        let [size, width, height, order, bits, row, colours] = [0, 4, 5, 7, 11, 12, 19].map(number);
        assert_eq!((order, bits, row), (0, 32, 4 * width));
        let rows = &file[size + 12 * colours..][..row * height];
        Screen { width, pixels: rows.as_chunks::<4>().0.to_vec() }
    }

    /// Lets xdotool do something. Returns whether it could.
    fn act(&self, what: &str) -> bool {
        let mut act = Command::new("xdotool");
        act.args(what.split_whitespace()).env("DISPLAY", &self.name).stderr(Stdio::null());
        act.output().unwrap().status.success()
    }

    /// `rhytid view` with more arguments, on this display.
    fn view(&self, arguments: &[&std::path::Path]) -> Child {
        let mut view = Command::new(env!("CARGO_BIN_EXE_rhytid"));
        view.arg("view").args(arguments).env("DISPLAY", &self.name).env_remove("RUST_LOG");
        view.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        // Chromium's SwiftShader has no windows, and ends a program that asks it for them.
        view.env_remove("VK_ADD_DRIVER_FILES");
        view.env("XDG_CACHE_HOME", concat!(env!("CARGO_TARGET_TMPDIR"), "/cache"));
        view.env("XDG_CONFIG_HOME", concat!(env!("CARGO_TARGET_TMPDIR"), "/config"));
        view.env("MESA_SHADER_CACHE_DIR", env!("CARGO_TARGET_TMPDIR"));
        let child = view.stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        // Without a window manager nothing else gives the window the keys.
        wait("the window", || self.act("search --onlyvisible --name Rhytid$ windowfocus"));
        child
    }

    /// Waits for a picture that stays the same and satisfies `is_so`. A coarse picture stays for less than a
    /// second.
    fn still(&self, what: &str, is_so: impl Fn(&Screen) -> bool) -> Screen {
        wait(what, || {
            let screen = self.screen();
            sleep(Duration::from_secs(1));
            is_so(&screen) && screen.pixels == self.screen().pixels
        });
        self.screen()
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Screen {
    /// The pixels of a colour: their centre and their number.
    fn find(&self, is: impl Fn([u8; 3]) -> bool) -> ([f64; 2], usize) {
        let (mut sum, mut count) = ([0.0; 2], 0);
        for (i, _) in self.pixels.iter().enumerate().filter(|(_, [b, g, r, _])| is([*r, *g, *b])) {
            sum = [sum[0] + (i % self.width) as f64, sum[1] + (i / self.width) as f64];
            count += 1;
        }
        (sum.map(|x| x / count.max(1) as f64), count)
    }

    /// Where the selected marker is.
    fn taken(&self) -> [f64; 2] {
        self.find(is_orange).0
    }
}

/// The colour of shaded skin, in light and in shadow.
fn is_skin([r, g, b]: [u8; 3]) -> bool {
    r > 90 && r > g && g > b && (15..90).contains(&(r - b))
}

/// The colour of the selected marker.
fn is_orange([r, g, b]: [u8; 3]) -> bool {
    r > 240 && (120..190).contains(&g) && b < 20
}

fn wait(what: &str, mut is_so: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !is_so() {
        assert!(begin.elapsed() < PATIENCE, "{what}: waited for nothing");
        sleep(Duration::from_millis(100));
    }
}

/// Exit code and messages, once it has ended.
fn ended(mut child: Child) -> (Option<i32>, String) {
    wait("the end", || child.try_wait().unwrap().is_some());
    let output = child.wait_with_output().unwrap();
    (output.status.code(), stderr(&output))
}

/// Ticks of the processor that a process has used, of 10 ms each.
fn ticks(child: &Child) -> u64 {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap();
    let after_name = stat.rsplit_once(')').unwrap().1;
    after_name.split_whitespace().skip(11).take(2).map(|ticks| ticks.parse::<u64>().unwrap()).sum()
}

#[test]
fn a_marker_is_dragged_in_a_window_and_keys_close_it() {
    let Some(display) = Display::start() else { return };
    let files = ["face.safetensors", "performance.csv"].map(|name| demo().join(name));
    let mut child = display.view(&[&files[0], &files[1]]);
    // The face, in the left part of the window. It plays at first, so that no two pictures are the same.
    wait("the face", || {
        assert!(child.try_wait().unwrap().is_none(), "it ended");
        let (middle, skin) = display.screen().find(is_skin);
        skin > 60_000 && (300.0..620.0).contains(&middle[0]) && (200.0..560.0).contains(&middle[1])
    });
    // The pointer leaves the face, where it would enlarge a marker.
    assert!(display.act("mousemove 1150 840") && display.act("key space") && display.act("key Home"));
    let before = display.still("a face that stays", |screen| screen.find(is_skin).1 > 60_000);
    assert_eq!(before.find(is_orange).1, 0, "no marker is taken");

    // At rest the window uses no time.
    let used = ticks(&child);
    sleep(Duration::from_secs(2));
    let used = ticks(&child) - used;
    assert!(used < 20, "{} ms of the processor in two seconds at rest", 10 * used);

    // A marker is selected and dragged.
    assert!(display.act("key n"));
    let taken = display.still("a marker that is taken", |screen| screen.find(is_orange).1 > 30);
    let [x, y] = taken.taken().map(f64::round);
    assert!(display.act(&format!("mousemove {x} {y} mousedown 1")));
    // In steps, like a hand.
    for step in 1..=4 {
        assert!(display.act(&format!("mousemove {} {} sleep 0.1", x + 6.0 * f64::from(step), y + 4.0)));
    }
    assert!(display.act("mouseup 1 mousemove 1150 840"));
    let goal = [x + 24.0, y + 4.0];
    let near = |at: [f64; 2], other: [f64; 2]| (at[0] - other[0]).hypot(at[1] - other[1]) < 2.5;
    let dragged = display.still("the marker where the pointer was", |screen| near(screen.taken(), goal));
    let face = |screen: &Screen| -> Vec<[u8; 4]> {
        screen.pixels.chunks(screen.width).take(800).flat_map(|row| &row[..900]).copied().collect()
    };
    let changed = face(&dragged).iter().zip(face(&taken)).filter(|(a, b)| **a != *b).count();
    assert!(changed > 2_000, "{changed} pixels of the face changed");

    // Undo restores the picture.
    assert!(display.act("key ctrl+z"));
    let undone = display.still("the marker where it was", |screen| near(screen.taken(), [x, y]));
    let differ = face(&undone).iter().zip(face(&taken)).filter(|(a, b)| **a != *b).count();
    assert!(differ < 100, "{differ} pixels differ after the undo");

    assert!(display.act("key ctrl+q"));
    assert_eq!(ended(child), (Some(0), String::new()));
}

#[test]
fn ctrl_c_closes_the_window_without_a_word() {
    let Some(display) = Display::start() else { return };
    let child = display.view(&[]);
    display.still("an empty window", |screen| screen.find(|p| p[0] > 20).1 > 1_000);
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.unwrap().success());
    assert_eq!(ended(child), (Some(0), String::new()));
}

#[test]
fn without_a_display_it_is_one_sentence() {
    for (display, words) in [("", "neither WAYLAND_DISPLAY nor DISPLAY"), (":97531", "DISPLAY=:97531")] {
        let mut command = rhytid("view");
        command.env("DISPLAY", display).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        let output = command.output().unwrap();
        let said = stderr(&output);
        assert_eq!((output.status.code(), said.lines().count()), (Some(1), 1), "{said}");
        assert!(said.starts_with("error: window: it did not open: ") && said.contains(words), "{said}");
        assert!(said.contains("`rhytid render` draws without one") && !said.contains(".rs"), "{said}");
    }
}

#[test]
fn what_it_cannot_show_is_refused_before_there_is_a_window() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    for (arguments, words) in [
        ("view take.csv", &["take.csv: is a take, expected a rig", "rhytid view RIG"][..]),
        ("view take.csv face.safetensors", &["take.csv: is a take, expected a rig"]),
        ("view face.toml", &["face.toml: is a project file, expected a rig"]),
        ("view face.safetensors neutral.obj", &["neutral.obj: is a mesh, expected a take"]),
        ("view nowhere.safetensors", &["nowhere.safetensors", "no such file"]),
        ("view face.safetensors nowhere.csv", &["nowhere.csv", "no such file"]),
        ("view face.safetensors --device cpu:9", &["cpu:9", "no such device"]),
        ("view face.safetensors --draw-on cpu:0", &["--draw-on cpu:0", "a device of the backend wgpu"]),
        ("view face.safetensors --draw-on wgpu:77", &["wgpu:77", "rhytid devices"]),
        ("view face.safetensors --listen elsewhere", &["elsewhere"]),
    ] {
        let mut command = f.rhytid(arguments);
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        assert_refused(&command.output().unwrap(), words);
    }
    let help = f.done("view --help");
    for words in ["--listen", "--draw-on", "docs/viewing.md", "rhytid view FACE.safetensors TAKE.csv"] {
        assert!(help.contains(words), "{words} is not in: {help}");
    }
}
