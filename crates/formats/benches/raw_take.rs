//! How fast capture files are read: ten minutes of 150 markers at 240 Hz, in each format, against reading the
//! file's bytes and no more: `cargo bench -p rhytid-formats --bench raw_take`.
use rhytid_formats::raw_take;
use std::error::Error;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::time::Instant;

const MARKERS: usize = 150;
const RATE: usize = 240;
const FRAMES: usize = 600 * RATE;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR"))?;
    println!("{FRAMES} frames of {MARKERS} markers");
    for name in ["take.c3d", "take.trc", "take.csv", "take.tsv"] {
        let path = folder.path().join(name);
        if name == "take.c3d" {
            write_c3d(&path)?;
        } else {
            write_text(&path)?;
        }
        // The first reading brings the file into the system's cache.
        let bytes = std::fs::read(&path)?.len();
        let start = Instant::now();
        std::fs::read(&path)?;
        let raw = start.elapsed();
        let start = Instant::now();
        let take = raw_take::read(&path, None)?;
        let taken = start.elapsed();
        if take.tracks.frames() != FRAMES || take.tracks.labels.len() != MARKERS {
            return Err(format!("{name}: {:?}", take.warnings).into());
        }
        println!("{name}: {:.0} MB, {taken:.2?}, its bytes alone {raw:.2?}", bytes as f64 / 1e6);
        std::fs::remove_file(&path)?;
    }
    Ok(())
}

fn position(frame: usize, marker: usize) -> [f32; 3] {
    let (i, j) = (frame as f32, marker as f32);
    [-70.1 * j + (i / 50.0).sin(), 1500.3 + (i / 70.0).cos() - j, j + i / 997.0]
}

/// A float C3D file for Intel, with the parameters that it takes.
fn write_c3d(path: &Path) -> Result<()> {
    let mut out = vec![2, 0x50];
    let words = |words: &[u16], out: &mut Vec<u8>| words.iter().for_each(|w| out.extend(w.to_le_bytes()));
    words(&[MARKERS as u16, 0, 1, u16::MAX, 0], &mut out);
    out.extend((-1_f32).to_le_bytes());
    words(&[3, 0], &mut out);
    out.extend((RATE as f32).to_le_bytes());
    out.resize(512, 0);
    out.extend([1, 0x50, 1, 84]);
    out.extend([5, 0xFF]);
    out.extend(b"POINT\x02\x00");
    out.extend([11, 1]);
    out.extend(b"LONG_FRAMES\x08\x00\x04\x00");
    out.extend((FRAMES as f32).to_le_bytes());
    out.resize(1024, 0);
    let mut file = BufWriter::new(File::create(path)?);
    file.write_all(&out)?;
    for frame in 0..FRAMES {
        for marker in 0..MARKERS {
            let [x, y, z] = position(frame, marker);
            let filled = f32::from(u8::from(!(frame + marker).is_multiple_of(40)));
            [x, y, z, filled].iter().try_for_each(|number| file.write_all(&number.to_le_bytes()))?;
        }
    }
    Ok(file.flush()?)
}

/// A text file of the format that the ending of `path` names.
fn write_text(path: &Path) -> Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    let columns = |separator: &str, cell: &dyn Fn(usize, usize) -> String| -> String {
        (0..3 * MARKERS).map(|k| separator.to_owned() + &cell(k / 3, k % 3)).collect()
    };
    let separator = match path.extension().and_then(|ending| ending.to_str()) {
        Some("trc") => {
            let labels = columns("\t", &|j, axis| if axis == 0 { format!("m{j}") } else { String::new() });
            writeln!(file, "DataRate\tNumFrames\tNumMarkers\tUnits\n{RATE}\t{FRAMES}\t{MARKERS}\tmm")?;
            writeln!(file, "Frame#\tTime{labels}\n")?;
            "\t"
        }
        Some("tsv") => {
            let names: String = (0..MARKERS).map(|j| format!("\tm{j}")).collect();
            writeln!(file, "NO_OF_FRAMES\t{FRAMES}\nFREQUENCY\t{RATE}\nMARKER_NAMES{names}")?;
            "\t"
        }
        _ => {
            let line = |cell: &dyn Fn(usize, usize) -> String| columns(",", cell);
            writeln!(file, "Format Version,1.23,Export Frame Rate,{RATE},Length Units,Millimeters\n")?;
            writeln!(file, ",Type{}", line(&|_, _| "Marker".into()))?;
            writeln!(file, ",Name{}", line(&|j, _| format!("m{j}")))?;
            writeln!(file, ",{}", line(&|_, _| "Position".into()))?;
            writeln!(file, "Frame,Time{}", line(&|_, axis| ["X", "Y", "Z"][axis].into()))?;
            ","
        }
    };
    let first = usize::from(separator == "\t");
    let mut row = String::new();
    for frame in 0..FRAMES {
        row.clear();
        write!(row, "{}{separator}{:.5}", frame + first, frame as f64 / RATE as f64)?;
        for marker in 0..MARKERS {
            for x in position(frame, marker) {
                write!(row, "{separator}{x:.5}")?;
            }
        }
        writeln!(file, "{row}")?;
    }
    Ok(file.flush()?)
}
