//! A small face as files, and the checks that every refused command shares.
#![allow(dead_code, reason = "each test binary uses its own part")]

pub(crate) mod raw;

use assert_cmd::Command;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::OnceLock;
use tempfile::TempDir;

/// A bumpy square sheet with five handles, one example and a take of 20 frames at 30 frames per second, in a
/// folder of its own. `out/` is empty.
pub(crate) struct Fixture {
    dir: TempDir,
    side: usize,
}

/// Handles of the sheet: label, column and row in twentieths of its side.
const HANDLES: [(&str, usize, usize); 5] =
    [("left", 2, 10), ("right", 18, 10), ("top", 10, 18), ("bottom", 10, 2), ("middle", 10, 10)];

pub(crate) const PROJECT: &str = r#"
[mesh]
neutral = "neutral.obj"
units = "cm"
up = "y"
[handles]
vertices = "markers.csv"
[[example]]
name = "pinch"
mesh = "poses/pinch.obj"
[large_scale]
bending_length = 3.0
[strain]
edges = "auto"
[fine_scale]
max_influences = 16
"#;

impl Fixture {
    pub(crate) fn new() -> Self {
        Self::with_side(21)
    }

    /// A sheet of `side` × `side` vertices, 10 cm wide.
    pub(crate) fn with_side(side: usize) -> Self {
        let fixture = Self { dir: TempDir::new().unwrap(), side };
        std::fs::create_dir(fixture.path("poses")).unwrap();
        std::fs::create_dir(fixture.path("out")).unwrap();
        fixture.write("neutral.obj", fixture.obj(0.0));
        fixture.write("poses/pinch.obj", fixture.obj(0.3));
        let markers: String = (0..5)
            .fold("label,vertex\n".into(), |s, h| format!("{s}{},{}\n", HANDLES[h].0, fixture.handle(h)));
        fixture.write("markers.csv", markers);
        fixture.write("face.toml", PROJECT);
        fixture.write("take.csv", fixture.take(20));
        fixture
    }

    pub(crate) fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.dir.path().join(name)
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    pub(crate) fn read_text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).unwrap()
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    }

    /// Rewrites a file with `from` replaced, which must be there.
    pub(crate) fn replace(&self, name: &str, from: &str, to: &str) {
        let text = self.read_text(name);
        assert!(text.contains(from), "{name} has no {from:?}");
        self.write(name, text.replacen(from, to, 1));
    }

    /// Vertex index of handle `h`.
    pub(crate) fn handle(&self, h: usize) -> usize {
        let (_, x, y) = HANDLES[h];
        let at = |twentieths: usize| (twentieths * (self.side - 1) + 10) / 20;
        at(y) * self.side + at(x)
    }

    fn position(&self, v: usize, pinch: f64) -> [f64; 3] {
        let unit = |i: usize| i as f64 / (self.side - 1) as f64;
        let (x, y) = (unit(v % self.side), unit(v / self.side));
        let bump = (x * 3.0).sin() * (y * 3.0).sin() * 2.0;
        let wrinkle = pinch * (x * 25.0).sin() * (-((y - 0.5) * 4.0).powi(2)).exp();
        [(x - 0.5) * 10.0 * (1.0 - pinch / 3.0), (y - 0.5) * 10.0, bump + wrinkle]
    }

    /// The sheet as OBJ with quads and texture coordinates.
    pub(crate) fn obj(&self, pinch: f64) -> String {
        let n = self.side;
        let mut obj = String::from("# a sheet\n");
        for v in 0..n * n {
            let [x, y, z] = self.position(v, pinch);
            writeln!(obj, "v {x:.6} {y:.6} {z:.6}").unwrap();
        }
        for v in 0..n * n {
            writeln!(obj, "vt {:.6} {:.6}", (v % n) as f64 / n as f64, (v / n) as f64 / n as f64).unwrap();
        }
        for row in 0..n - 1 {
            for column in 0..n - 1 {
                let a = row * n + column + 1;
                let [b, c, d] = [a + 1, a + n + 1, a + n];
                writeln!(obj, "f {a}/{a} {b}/{b} {c}/{c} {d}/{d}").unwrap();
            }
        }
        obj
    }

    /// The sheet's neutral as binary little-endian PLY.
    pub(crate) fn ply(&self) -> Vec<u8> {
        let n = self.side;
        let mut ply = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
             property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
            n * n,
            (n - 1) * (n - 1)
        )
        .into_bytes();
        for v in 0..n * n {
            ply.extend(self.position(v, 0.0).into_iter().flat_map(|x| (x as f32).to_le_bytes()));
        }
        for row in 0..n - 1 {
            for column in 0..n - 1 {
                let a = (row * n + column) as i32;
                ply.push(4);
                ply.extend([a, a + 1, a + n as i32 + 1, a + n as i32].into_iter().flat_map(i32::to_le_bytes));
            }
        }
        ply
    }

    /// A take in which the sheet is pinched and let go.
    pub(crate) fn take(&self, frames: usize) -> String {
        let mut csv = String::from("time");
        for (label, ..) in HANDLES {
            write!(csv, ",{label}_x,{label}_y,{label}_z").unwrap();
        }
        for frame in 0..frames {
            write!(csv, "\n{:.9}", frame as f64 / 30.0).unwrap();
            let pinch = 0.3 * (frame as f64 / 10.0).sin().abs();
            for h in 0..HANDLES.len() {
                let [x, y, z] = self.position(self.handle(h), pinch);
                write!(csv, ",{x:.6},{y:.6},{z:.6}").unwrap();
            }
        }
        csv + "\n"
    }

    /// `rhytid` with the fixture's folder as its working folder.
    pub(crate) fn rhytid(&self, args: &str) -> Command {
        let mut command = rhytid(args);
        command.current_dir(self.dir.path());
        command
    }

    /// Runs a command that must succeed; returns what it printed.
    pub(crate) fn done(&self, args: &str) -> String {
        let output = self.rhytid(args).output().unwrap();
        assert!(output.status.success(), "{args}: {}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs a command that must be refused: exit code 2, one sentence with all of `words`, `out/` still
    /// empty.
    pub(crate) fn refused(&self, args: &str, words: &[&str]) -> String {
        let output = self.rhytid(args).output().unwrap();
        let sentence = assert_refused(&output, words);
        self.assert_nothing_written();
        sentence
    }

    /// `solve` must be refused.
    pub(crate) fn solve_refused(&self, words: &[&str]) -> String {
        self.refused("solve face.toml -o out/face.safetensors", words)
    }

    /// Neither a file nor a temporary one.
    pub(crate) fn assert_nothing_written(&self) {
        assert_eq!(list(&self.path("out")), Vec::<String>::new());
    }
}

/// `rhytid` with arguments separated by blanks.
pub(crate) fn rhytid(args: &str) -> Command {
    let mut command = assert_cmd::cargo::cargo_bin_cmd!("rhytid");
    command.args(args.split_whitespace()).env_remove("RUST_LOG").env_remove("RUST_BACKTRACE");
    // The cache of `--device auto` is shared by the tests and is not the user's. The cache of compiled
    // drivers is the same even in tests with a cache of their own. Without it, trying all devices takes five
    // times as long.
    command.env("XDG_CACHE_HOME", concat!(env!("CARGO_TARGET_TMPDIR"), "/cache"));
    command.env("MESA_SHADER_CACHE_DIR", env!("CARGO_TARGET_TMPDIR"));
    command.env("POCL_CACHE_DIR", concat!(env!("CARGO_TARGET_TMPDIR"), "/pocl"));
    command
}

/// A folder with the files of the smallest demo, made once for all tests.
pub(crate) fn demo() -> &'static Path {
    static DEMO: OnceLock<TempDir> = OnceLock::new();
    DEMO.get_or_init(|| {
        let folder = TempDir::new().unwrap();
        let output = rhytid(&format!("demo {} --vertices 2000", folder.path().display())).output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        folder
    })
    .path()
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Asserts exit code 2 and exactly one `error:` sentence, in which all of `words` occur; returns it.
pub(crate) fn assert_refused(output: &Output, words: &[&str]) -> String {
    let text = stderr(output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(!text.contains("panicked") && !text.contains("internal error"), "{text}");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "");
    let errors: Vec<&str> = text.lines().filter(|line| line.starts_with("error: ")).collect();
    let [error] = errors[..] else { panic!("expected one error: sentence, found: {text}") };
    for word in words {
        assert!(error.contains(word), "{word:?} is not in: {error}");
    }
    error.to_owned()
}

/// The names in a folder, hidden ones too, in order.
pub(crate) fn list(dir: &Path) -> Vec<String> {
    let names = std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

/// Bytes without any structure, the same ones every time.
pub(crate) fn garbage(len: usize) -> Vec<u8> {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 32) as u8
    };
    std::iter::repeat_with(next).take(len).collect()
}

/// The keys that docs/cli.md promises for `what`: those in the first column of the table under that heading.
pub(crate) fn documented(what: &str) -> Vec<String> {
    let page = include_str!("../../../../../docs/cli.md");
    let heading = format!("\n#### {what}\n");
    let section = page.split_once(&heading).unwrap_or_else(|| panic!("no section {what}")).1;
    let section = section.split("\n#").next().unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    let keys = |row: &'static str| row.split('|').nth(1).unwrap().split('`').skip(1).step_by(2);
    rows.flat_map(keys).map(str::to_owned).collect()
}

/// Asserts that an object has exactly the documented keys.
pub(crate) fn assert_documented(value: &serde_json::Value, what: &str) {
    let mut promised = documented(what);
    promised.sort();
    let mut found: Vec<&String> = value.as_object().unwrap().keys().collect();
    found.sort();
    assert_eq!(found, promised.iter().collect::<Vec<_>>(), "{what}");
}

/// A PNG of one colour, 4 × 4 pixels.
pub(crate) fn image(colour: [u8; 3]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 4, 4);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&colour.repeat(16)).unwrap();
    file
}
