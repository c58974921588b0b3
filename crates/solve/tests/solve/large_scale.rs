//! Section 2's system: its elimination order, its factorisation, its solution.

use faer::Side;
use faer::sparse::SymbolicSparseColMat;
use faer::sparse::linalg::cholesky::{SymmetricOrdering, factorize_symbolic_cholesky};
use rhytid_core::{Error, NoProgress, SurfacePoint, VertexId};
use rhytid_geometry::cholesky::Columns;
use rhytid_geometry::cholesky::Factor;
use rhytid_geometry::cholesky::{Dissection, Graph, Part, dissect};
use rhytid_geometry::laplacian::laplacian;
use rhytid_solve::System;
use rhytid_solve::basis::basis;

/// A bent sheet of `width` by `height` vertices.
fn sheet(width: u32, height: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let at = |i: u32| {
        let (x, y) = (f64::from(i % width), f64::from(i / width));
        [x + 0.2 * (0.7 * y).sin(), y + 0.2 * (1.3 * x).cos(), (0.1 * x).sin() + 0.05 * y]
    };
    let cells = (0..height - 1).flat_map(|j| (0..width - 1).map(move |i| j * width + i));
    let triangles = cells.flat_map(|a| [[a, a + 1, a + width + 1], [a, a + width + 1, a + width]]).collect();
    ((0..width * height).map(at).collect(), triangles)
}

fn system(width: u32, height: u32) -> (Vec<[f64; 3]>, System) {
    let (positions, triangles) = sheet(width, height);
    let system = System::new(laplacian(&positions, &triangles), 3.0);
    (positions, system)
}

fn graph(vertices: usize, edges: impl IntoIterator<Item = [u32; 2]>) -> Graph {
    let mut rows = vec![Vec::new(); vertices];
    for [a, b] in edges {
        rows[a as usize].push(b);
        rows[b as usize].push(a);
    }
    let mut graph = Graph { offsets: vec![0], neighbors: Vec::new() };
    for mut row in rows {
        row.sort_unstable();
        row.dedup();
        graph.neighbors.extend(row);
        graph.offsets.push(graph.neighbors.len());
    }
    graph
}

/// Checks a dissection. Each vertex occurs once, and the parts fill their places. Vertices that share an
/// entry are in one part, or in one part above the other.
fn check(dissection: &Dissection, graph: &Graph, vertices: &[u32]) {
    let mut sorted = dissection.order.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, vertices);
    let mut above = vec![None; graph.offsets.len() - 1];
    walk(&dissection.root, &dissection.order, &mut above, &mut Vec::new());
    assert_eq!(dissection.root.places, 0..vertices.len());
    for &v in vertices {
        let path = above[v as usize].as_ref().unwrap();
        for other in graph.neighbors(v).iter().filter_map(|&w| above[w as usize].as_ref()) {
            assert!(path.starts_with(other) || other.starts_with(path), "{path:?} meets {other:?}");
        }
    }
}

/// Records the way from the root to its part for each vertex.
fn walk(part: &Part, order: &[u32], above: &mut [Option<Vec<bool>>], path: &mut Vec<bool>) {
    for &v in &order[part.columns.clone()] {
        above[v as usize] = Some(path.clone());
    }
    assert_eq!(part.columns.end, part.places.end);
    match part.halves.as_deref() {
        None => assert_eq!(part.columns, part.places),
        Some([left, right]) => {
            assert_eq!((left.places.start, left.places.end), (part.places.start, right.places.start));
            assert_eq!(right.places.end, part.columns.start);
            for (half, side) in [(left, false), (right, true)] {
                path.push(side);
                walk(half, order, above, path);
                path.pop();
            }
        }
    }
}

#[test]
fn separators_separate() {
    let (positions, system) = system(61, 47);
    let vertices: Vec<u32> = (0..61 * 47).filter(|v| v % 200 != 7).collect();
    let dissection = dissect(&positions, system.pattern(), vertices.clone());
    check(&dissection, system.pattern(), &vertices);
    let depth = |mut part: &Part| {
        let mut depth = 0;
        while let Some(halves) = &part.halves {
            (part, depth) = (&halves[0], depth + 1);
        }
        depth
    };
    assert!(depth(&dissection.root) >= 6, "2,800 vertices need more than {} cuts", depth(&dissection.root));
}

#[test]
fn odd_inputs_are_ordered_too() {
    let n = 500;
    let line: Vec<[f64; 3]> = (0..n).map(|i| [f64::from(i), 0.0, 0.0]).collect();
    let chain = || (1..n).map(|i| [i - 1, i]);
    let all: Vec<u32> = (0..n).collect();
    let cases = [
        ("one place", vec![[1.0, 2.0, 3.0]; n as usize], graph(n as usize, chain())),
        ("a star", line.clone(), graph(n as usize, (1..n).map(|i| [0, i]))),
        ("pairs", line.clone(), graph(n as usize, (0..n).map(|i| [i / 2 * 2, i]))),
        ("no entries", line.clone(), graph(n as usize, [])),
        (
            "all entries",
            line.clone(),
            graph(n as usize, all.iter().flat_map(|&i| (0..i).map(move |j| [i, j]))),
        ),
        ("two chains in one place", line.iter().map(|p| [p[0] % 250.0, 0.0, 0.0]).collect(), {
            graph(n as usize, chain().filter(|&[_, b]| b != 250))
        }),
        (
            "huge numbers",
            line.iter().map(|p| [p[0] * 1e305, -p[0] * 1e305, 0.0]).collect(),
            graph(n as usize, chain()),
        ),
    ];
    for (name, positions, graph) in &cases {
        println!("{name}");
        check(&dissect(positions, graph, all.clone()), graph, &all);
        check(&dissect(positions, graph, vec![3]), graph, &[3]);
        check(&dissect(positions, graph, Vec::new()), graph, &[]);
    }
}

/// Entries of faer's factor in its own order of approximate minimum degree.
fn entries_by_minimum_degree(matrix: &Columns) -> usize {
    let n = matrix.offsets.len() - 1;
    let rows = matrix.rows.iter().map(|&row| row as usize).collect();
    let pattern = SymbolicSparseColMat::new_checked(n, n, matrix.offsets.clone(), None, rows);
    factorize_symbolic_cholesky(pattern.as_ref(), Side::Lower, SymmetricOrdering::Amd, Default::default())
        .unwrap()
        .len_val()
}

#[test]
fn there_is_less_fill_than_by_minimum_degree() {
    let (positions, system) = system(240, 240);
    let dissection = dissect(&positions, system.pattern(), (0..240 * 240).collect());
    let matrix = system.lower(&dissection.order);
    let factor = Factor::new(&with_added_diagonal(matrix.clone()), &dissection.root, &NoProgress).unwrap();
    let theirs = entries_by_minimum_degree(&matrix);
    assert!((factor.entries() as f64) < 0.9 * theirs as f64, "{} and {theirs}", factor.entries());
}

/// The matrix with a diagonal added, because it is singular without handles.
fn with_added_diagonal(mut matrix: Columns) -> Columns {
    for j in 0..matrix.offsets.len() - 1 {
        matrix.values[matrix.offsets[j]] += 1.0;
    }
    matrix
}

#[test]
fn a_solution_fulfils_its_equations() {
    let (positions, system) = system(53, 31);
    let n = 53 * 31;
    let Dissection { order, root } = dissect(&positions, system.pattern(), (0..n as u32).collect());
    let matrix = with_added_diagonal(system.lower(&order));
    let factor = Factor::new(&matrix, &root, &NoProgress).unwrap();
    // A dense right-hand side, one with a single entry, and none.
    let right = |i: usize| [(i as f64).sin(), f64::from(u8::from(i == 700)), 0.0];
    let mut x: Vec<f64> = (0..n).flat_map(right).collect();
    factor.solve(&mut x, 3);
    let mut product = vec![[0.0; 3]; n];
    for j in 0..n {
        let (rows, values) = matrix.column(j);
        for (&i, value) in rows.iter().zip(values) {
            let i = i as usize;
            for c in 0..3 {
                product[i][c] += value * x[3 * j + c];
                if i != j {
                    product[j][c] += value * x[3 * i + c];
                }
            }
        }
    }
    for (i, product) in product.iter().enumerate() {
        for c in 0..3 {
            assert!((product[c] - right(i)[c]).abs() < 1e-11, "row {i}: {product:?}");
        }
        assert_eq!(x[3 * i + 2], 0.0);
    }
}

#[test]
fn what_is_not_positive_definite_is_refused() {
    let (positions, system) = system(20, 20);
    let Dissection { order, root } = dissect(&positions, system.pattern(), (0..400).collect());
    let mut matrix = with_added_diagonal(system.lower(&order));
    matrix.values[matrix.offsets[350]] = -1.0;
    let error = Factor::new(&matrix, &root, &NoProgress).unwrap_err();
    assert!(matches!(error, Error::Input(_)) && error.to_string().contains("factorised"), "{error}");
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let (positions, triangles) = sheet(130, 90);
    let handles: Vec<SurfacePoint> = (0..40).map(|i| VertexId(31 + 290 * i).into()).collect();
    let driven = vec![true; positions.len()];
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            basis(&positions, laplacian(&positions, &triangles), &handles, &driven, 4.0, &NoProgress)
        })
        .unwrap()
    };
    let one = with(1);
    let sums = one.rows().map(|row| (row.iter().sum::<f64>() - 1.0).abs());
    assert!(sums.fold(0.0, f64::max) < 1e-9);
    for threads in [2, 3, 7] {
        assert!(
            one.as_slice().iter().zip(with(threads).as_slice()).all(|(a, b)| a.to_bits() == b.to_bits()),
            "{threads} threads"
        );
    }
}
