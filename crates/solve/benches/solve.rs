//! Timing of the large-scale system (section 2), step by step. On the same matrix, faer's own sparse Cholesky
//! and a peer are timed too.
//!
//! `cargo bench -p rhytid-solve --bench solve -- [--vertices N | --rig FILE] [--peer PYTHON] [--superlu]`
//!
//! The system is that of a rig file, or of a generated sheet. The peer is `benches/peers/solve.py`, which
//! needs NumPy, SciPy and scikit-sparse. The Python that `--peer` names runs it. Without the option, it is
//! the Python in `target/venv-peers`, if that exists.
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Mat, Side};
use npyz::WriterBuilder;
use rhytid_core::{NoProgress, SurfacePoint, Table, VertexId};
use rhytid_geometry::cholesky::Columns;
use rhytid_geometry::cholesky::Dissection;
use rhytid_geometry::cholesky::Factor;
use rhytid_geometry::cholesky::dissect;
use rhytid_geometry::laplacian::laplacian;
use rhytid_solve::basis::solve_columns;
use rhytid_solve::{DrivenComponents, System};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// The allowed difference of two programs' solutions of one system, as a part of the largest number in them.
const TOLERANCE: f64 = 1e-6;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

struct Input {
    rest: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    handles: Vec<VertexId>,
    bending_length: f64,
}

fn main() -> Outcome<()> {
    let mut vertices = 530_000;
    let (mut rig, mut python, mut superlu) = (None, None, false);
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or(format!("{arg} needs a value"));
        match arg.as_str() {
            // An option that `cargo bench` adds.
            "--bench" => {}
            "--vertices" => vertices = value()?.parse()?,
            "--rig" => rig = Some(PathBuf::from(value()?)),
            "--peer" => python = Some(PathBuf::from(value()?)),
            "--superlu" => superlu = true,
            _ => return Err(format!("unknown argument {arg}").into()),
        }
    }
    let input = match rig {
        Some(path) => from_rig(&path)?,
        None => sheet(vertices),
    };

    let (laplacian, time) = timed(|| laplacian(&input.rest, &input.triangles));
    println!(
        "{} vertices, {} handles, {} threads",
        input.rest.len(),
        input.handles.len(),
        rayon::current_num_threads()
    );
    println!("Laplacian             {time:7.2} s");
    let points: Vec<SurfacePoint> = input.handles.iter().map(|v| (*v).into()).collect();
    let mut free = DrivenComponents::new(&input.rest, &input.triangles, &points).driven;
    input.handles.iter().for_each(|v| free[v.index()] = false);
    let free: Vec<u32> = (0..).zip(&free).filter(|(_, free)| **free).map(|(v, _)| v).collect();
    let (system, time) = timed(|| System::new(laplacian, input.bending_length));
    println!("pattern               {time:7.2} s");
    let (Dissection { order, root }, ordering) =
        timed(|| dissect(&input.rest, system.pattern(), free.clone()));
    println!("ordering              {ordering:7.2} s");
    let (matrix, time) = timed(|| system.lower(&order));
    println!("assembly              {time:7.2} s");
    let (factor, factorisation) = timed(|| Factor::new(&matrix, &root, &NoProgress));
    let factor = factor?;
    println!("factorisation         {factorisation:7.2} s, {} million entries", factor.entries() / 1_000_000);
    drop((matrix, root));
    let h = input.handles.len();
    let mut basis = Table::filled(input.rest.len(), h, 0.0);
    let (done, solves) = timed(|| {
        solve_columns(
            &system,
            &factor,
            &order,
            &system.right(&order, &input.handles),
            &mut basis,
            &NoProgress,
        )
    });
    done?;
    println!("{h} solves             {solves:7.2} s");
    let ours = ordering + factorisation + solves;
    println!("ordering, factorisation and solves together: {ours:.2} s");
    drop(factor);
    let theirs = faers(&system, &free, &input.handles, &basis)?;
    println!("ours takes {:.2} of faer's", ours / theirs);

    let usual = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/venv-peers/bin/python");
    let Some(python) = python.or_else(|| usual.exists().then_some(usual)) else {
        println!("no peer: there is no target/venv-peers, and --peer names none");
        return Ok(());
    };
    let folder = tempfile::tempdir()?;
    write_system(folder.path(), &system, &free, &input.handles, basis.as_slice())?;
    drop((system, basis));
    let best = peer(&python, folder.path(), superlu)?;
    println!("ours takes {:.2} of the peer's best time", ours / best);
    Ok(())
}

/// Solves the same system by faer's sparse Cholesky in its own order, and checks the solution. The result is
/// the time in seconds.
fn faers(system: &System, free: &[u32], handles: &[VertexId], basis: &Table<f64>) -> Outcome<f64> {
    let matrix = |columns: Columns| {
        let rows = columns.rows.iter().map(|&row| row as usize).collect();
        let pattern = SymbolicSparseColMat::new_checked(
            free.len(),
            columns.offsets.len() - 1,
            columns.offsets,
            None,
            rows,
        );
        SparseColMat::new(pattern, columns.values)
    };
    let (lower, right) = (matrix(system.lower(free)), matrix(system.right(free, handles)).to_dense());
    let (symbolic, analysis) = timed(|| SymbolicLlt::try_new(lower.symbolic(), Side::Lower));
    let symbolic = symbolic.map_err(|e| format!("{e:?}"))?;
    let (llt, factorisation) = timed(|| Llt::try_new_with_symbolic(symbolic, lower.as_ref(), Side::Lower));
    let llt = llt.map_err(|e| format!("{e:?}"))?;
    let (solution, solves): (Mat<f64>, f64) = timed(|| llt.solve(&right));
    let h = handles.len();
    let (mut farthest, mut largest) = (0.0_f64, 0.0_f64);
    for (i, &v) in free.iter().enumerate() {
        for k in 0..h {
            let ours = basis.row(v as usize)[k];
            farthest = farthest.max((solution[(i, k)] - ours).abs());
            largest = largest.max(ours.abs());
        }
    }
    let difference = farthest / largest;
    if difference.is_nan() || difference > TOLERANCE {
        return Err(
            format!("faer's solution differs by {difference:.1e}, expected {TOLERANCE:.0e} at most").into()
        );
    }
    let sum = analysis + factorisation + solves;
    println!(
        "faer: {analysis:.2} + {factorisation:.2} + {solves:.2} = {sum:.2} s, differs by {difference:.1e}"
    );
    Ok(sum)
}

/// Runs the peer, checks its solutions, and prints its times. The result is the least time in seconds.
fn peer(python: &Path, folder: &Path, superlu: bool) -> Outcome<f64> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../benches/peers/solve.py");
    let output = Command::new(python)
        .arg(script)
        .arg(folder)
        .args(superlu.then_some("--superlu"))
        .stderr(std::process::Stdio::inherit())
        .output()
        .map_err(|e| format!("{}: {e}", python.display()))?;
    if !output.status.success() {
        return Err(format!("the peer stopped: {}", output.status).into());
    }
    let mut best = f64::INFINITY;
    for line in String::from_utf8(output.stdout)?.lines() {
        let Told { name, seconds, difference } = serde_json::from_str(line)?;
        // Also if it is NaN.
        if difference.is_nan() || difference > TOLERANCE {
            return Err(format!(
                "{name}: its solution differs by {difference:.1e}, expected {TOLERANCE:.0e} at most"
            )
            .into());
        }
        let [ordering, factorisation, solves] = seconds;
        let sum: f64 = seconds.iter().sum();
        println!(
            "{name}: {ordering:.2} + {factorisation:.2} + {solves:.2} = {sum:.2} s, differs by {difference:.1e}"
        );
        best = best.min(sum);
    }
    Ok(best)
}

/// The peer's result of one way to solve the system.
#[derive(serde::Deserialize)]
struct Told {
    name: String,
    seconds: [f64; 3],
    difference: f64,
}

/// Writes the system with its vertices in the mesh's order, and its solution.
fn write_system(
    folder: &Path,
    system: &System,
    free: &[u32],
    handles: &[VertexId],
    basis: &[f64],
) -> Outcome<()> {
    let matrix = system.lower(free);
    let write = |name: &str, matrix: &Columns| -> Outcome<()> {
        let offsets: Vec<u32> = matrix.offsets.iter().map(|&offset| offset as u32).collect();
        write_npy(&folder.join(format!("{name}_offsets.npy")), &[offsets.len()], offsets)?;
        write_npy(
            &folder.join(format!("{name}_rows.npy")),
            &[matrix.rows.len()],
            matrix.rows.iter().copied(),
        )?;
        write_npy(
            &folder.join(format!("{name}_values.npy")),
            &[matrix.values.len()],
            matrix.values.iter().copied(),
        )
    };
    write("matrix", &matrix)?;
    write("right", &system.right(free, handles))?;
    let h = handles.len();
    let solution = free.iter().flat_map(|&v| &basis[v as usize * h..][..h]).copied();
    write_npy(&folder.join("solution.npy"), &[free.len(), h], solution)
}

fn write_npy<T: npyz::AutoSerialize>(
    path: &Path,
    shape: &[usize],
    numbers: impl IntoIterator<Item = T>,
) -> Outcome<()> {
    let shape: Vec<u64> = shape.iter().map(|&n| n as u64).collect();
    let file = BufWriter::new(File::create(path)?);
    let mut npy = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(file).begin_nd()?;
    npy.extend(numbers)?;
    npy.finish()?;
    Ok(())
}

fn from_rig(path: &Path) -> Outcome<Input> {
    let rig = rhytid_core::rig_file::read(path)?;
    Ok(Input {
        rest: rig.surface().rest.iter().map(|p| p.map(f64::from)).collect(),
        triangles: rig.surface().triangles.clone(),
        handles: rig.handles().points.iter().map(SurfacePoint::nearest_vertex).collect(),
        bending_length: rig.bending_length(),
    })
}

/// A domed sheet of about `vertices` vertices, with triangles of many shapes, and 89 handles spread over it.
fn sheet(vertices: usize) -> Input {
    let side = (vertices as f64).sqrt().round().max(16.0) as u32;
    let at = |i: u32, j: u32| {
        let [u, v] = [i, j].map(|i| 2.0 * f64::from(i) / f64::from(side - 1) - 1.0);
        let (x, y) = (u + 0.2 * (3.0 * v).sin() / f64::from(side), v + 0.1 * (5.0 * u).cos() * (1.0 - v * v));
        [10.0 * x, 12.0 * y, 8.0 * (1.0 - 0.5 * (x * x + y * y)) + 0.2 * (9.0 * x).sin() * (7.0 * y).cos()]
    };
    let number = |i: u32, j: u32| i * side + j;
    let rest = (0..side).flat_map(|i| (0..side).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect();
    let triangles = (0..side - 1)
        .flat_map(|i| (0..side - 1).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        })
        .collect();
    // A sequence that fills the square evenly.
    let spread = |i: u32, step: f64| (f64::from(i) * step).fract() * f64::from(side);
    let handles = (1..=89)
        .map(|i| VertexId(number(spread(i, 0.754_877_666) as u32, spread(i, 0.569_840_291) as u32)))
        .collect();
    Input { rest, triangles, handles, bending_length: 2.0 }
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}
