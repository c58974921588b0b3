//! Distances along the edges of the rest mesh, and the handles' geodesic Voronoi cells, for `auto` strain
//! edges (section 3).
use crate::Topology;
use crate::dijkstra::{Label, shortest_ways, spread};
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{HandleId, SurfacePoint};
use rhytid_kernels::vec3;
use std::cmp::Ordering;

/// The edges of the rest mesh with their lengths.
pub struct EdgeGraph<'a> {
    positions: &'a [[f64; 3]],
    topology: &'a Topology,
    /// The lengths of the edges of each vertex, in the order of its neighbours.
    lengths: Vec<f64>,
}

impl<'a> EdgeGraph<'a> {
    /// The edges of a mesh with V×3 positions.
    pub fn new(positions: &'a [[f64; 3]], topology: &'a Topology) -> Self {
        let position = |v: usize| DVec3::from_array(positions[v]);
        let of_vertex =
            |v: usize| topology.neighbors(v).iter().map(move |&w| position(v).distance(position(w as usize)));
        let lengths = (0..positions.len()).into_par_iter().flat_map_iter(of_vertex).collect();
        Self { positions, topology, lengths }
    }

    /// V.
    fn vertices(&self) -> usize {
        self.topology.vertices()
    }

    /// The neighbours of a vertex with their distances.
    pub fn edges(&self, v: u32) -> impl Iterator<Item = (u32, f64)> {
        let lengths = &self.lengths[self.topology.neighbor_range(v as usize)];
        self.topology.neighbors(v as usize).iter().copied().zip(lengths.iter().copied())
    }

    /// The vertices of a point with the lengths of the straight ways to them, in mesh units.
    pub fn ways_from(&self, point: &SurfacePoint) -> impl Iterator<Item = (u32, f64)> {
        let at = point.at(self.positions);
        let to = move |v: u32| vec3::length(vec3::sub(self.positions[v as usize], at));
        point.corners().map(move |(v, _)| (v.0, to(v.0)))
    }

    /// The distance between two points in mesh units, out of the V distances of all vertices from the first.
    /// Infinite where no vertex of the second is reached.
    pub fn between(&self, from: &SurfacePoint, to: &SurfacePoint, distances: &[f64]) -> f64 {
        let along =
            self.ways_from(to).map(|(v, way)| distances[v as usize] + way).fold(f64::INFINITY, f64::min);
        // No way along edges is as short as the straight one inside a triangle.
        let is_of = |a: &SurfacePoint, b: &SurfacePoint| a.corners().all(|(v, _)| b.has(v));
        let is_inside = is_of(from, to) || is_of(to, from);
        let straight = || vec3::length(vec3::sub(to.at(self.positions), from.at(self.positions)));
        if is_inside { along.min(straight()) } else { along }
    }

    /// Writes the distance of every vertex from `from` into `distances`, V. A vertex that would be farther
    /// than its `limit` is not reached. The distance of a vertex that is not reached is infinite.
    pub fn distances(&self, from: &SurfacePoint, limit: impl Fn(u32) -> f64, distances: &mut [f64]) {
        shortest_ways(self.ways_from(from), |v| self.edges(v), limit, distances);
    }
}

/// Looks for the vertices near a vertex, again and again. It touches only what is near, so it is for many
/// vertices of a large mesh.
pub struct Near<'a> {
    graph: &'a EdgeGraph<'a>,
    /// V: infinite where the last search did not get.
    distances: Vec<f64>,
    /// The vertices that the last search reached.
    reached: Vec<u32>,
}

impl<'a> Near<'a> {
    /// Before any search, no vertex is near.
    pub fn new(graph: &'a EdgeGraph<'a>) -> Self {
        Self { graph, distances: vec![f64::INFINITY; graph.vertices()], reached: Vec::new() }
    }

    /// Looks for the vertices whose distance from a vertex is at most `limit`. Returns them with these
    /// distances, in no particular order.
    pub fn search(&mut self, from: u32, limit: f64) -> impl Iterator<Item = (u32, f64)> {
        self.reached.iter().for_each(|v| self.distances[*v as usize] = f64::INFINITY);
        let edges = |v| self.graph.edges(v);
        self.reached = spread([(from, 0.0)], edges, |_| limit, &mut self.distances);
        self.reached.iter().map(|v| (*v, self.distances[*v as usize]))
    }

    /// The distance of a vertex in the last search. Infinite where it did not get.
    pub fn distance(&self, v: u32) -> f64 {
        self.distances[v as usize]
    }
}

/// The handle that is nearest to each vertex along the edges of the rest mesh. Of equally near handles the
/// lowest counts. `None` where no handle can be reached.
pub fn voronoi_cells(
    positions: &[[f64; 3]],
    topology: &Topology,
    handles: &[SurfacePoint],
) -> Vec<Option<HandleId>> {
    let cells = nearest_handles(&EdgeGraph::new(positions, topology), handles);
    cells.into_iter().map(|cell| cell.map(|cell| cell.handle)).collect()
}

/// The handle that is nearest to a vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Its distance along the edges of the rest mesh.
    pub distance: f64,
    /// The nearest handle.
    pub handle: HandleId,
}

impl Label for Cell {
    const UNREACHED: Self = Self { distance: f64::INFINITY, handle: HandleId(u32::MAX) };

    fn distance(&self) -> f64 {
        self.distance
    }

    fn through(&self, length: f64) -> Self {
        Self { distance: self.distance + length, ..*self }
    }

    /// Of equally near handles the lowest counts.
    fn order(&self, other: &Self) -> Ordering {
        self.distance.total_cmp(&other.distance).then(self.handle.cmp(&other.handle))
    }
}

/// As [`voronoi_cells`], with the distances.
pub fn nearest_handles(graph: &EdgeGraph<'_>, handles: &[SurfacePoint]) -> Vec<Option<Cell>> {
    let mut cells = vec![Cell::UNREACHED; graph.vertices()];
    let sources = handles.iter().enumerate().flat_map(|(h, point)| {
        let handle = HandleId::from_index(h);
        graph.ways_from(point).map(move |(v, distance)| (v, Cell { distance, handle }))
    });
    shortest_ways(sources, |v| graph.edges(v), |_| f64::INFINITY, &mut cells);
    cells.into_iter().map(|cell| (cell != Cell::UNREACHED).then_some(cell)).collect()
}

/// The pairs of handles whose cells touch: an edge of the mesh joins them. Each pair is ascending, and the
/// pairs are sorted.
pub fn touching_cells(topology: &Topology, cells: &[Option<HandleId>]) -> Vec<[HandleId; 2]> {
    let mut pairs = Vec::new();
    for (v, cell) in cells.iter().enumerate() {
        for &w in topology.neighbors(v) {
            if let (Some(a), Some(b)) = (*cell, cells[w as usize])
                && a < b
            {
                pairs.push([a, b]);
            }
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// For each of `edges`, the shortest way along the mesh from one handle to the other across a place where
/// their cells touch. `edges` are as [`touching_cells`] returns them.
pub fn ways(graph: &EdgeGraph<'_>, cells: &[Option<Cell>], edges: &[[HandleId; 2]]) -> Vec<f64> {
    let mut ways = vec![f64::INFINITY; edges.len()];
    for (v, cell) in cells.iter().enumerate() {
        for (w, between) in graph.edges(v as u32) {
            if let (Some(a), Some(b)) = (*cell, cells[w as usize])
                && let Ok(edge) = edges.binary_search(&[a.handle.min(b.handle), a.handle.max(b.handle)])
            {
                ways[edge] = ways[edge].min(a.distance + between + b.distance);
            }
        }
    }
    ways
}

/// A pair of touching cells is dropped if its way is more than so many times the median way.
///
/// Such cells touch only because there is no marker between them, as at the back of a head. A strain edge
/// would go through the head. Measured ratios on four faces with 31 to 120 handles: at most 3 between
/// neighbours on the skin. They are 4 to 5 around a mouth or an eye without a marker at its corner, and 5 to
/// 23 around a head.
const MAX_WAY_RATIO: f64 = 5.0;

/// A pair is dropped, too, if its way along the skin is more than so many times the straight line. Such a
/// line goes across an opening: the lips or the lids.
const MAX_DETOUR: f64 = 2.0;

/// Removes the pairs from `edges` whose way along the skin is more than five times the median way, and those
/// whose way is more than twice the straight line. `at` is where a handle is.
pub fn drop_far_pairs(
    graph: &EdgeGraph<'_>,
    cells: &[Option<Cell>],
    at: impl Fn(HandleId) -> [f64; 3],
    edges: &mut Vec<[HandleId; 2]>,
) {
    let ways = ways(graph, cells, edges);
    let mut sorted = ways.clone();
    sorted.sort_by(f64::total_cmp);
    let Some(median) = sorted.get(sorted.len() / 2) else { return };
    let mut ways = ways.iter();
    edges.retain(|&[a, b]| {
        let straight = vec3::length(vec3::sub(at(b), at(a)));
        ways.next().is_some_and(|way| *way <= MAX_WAY_RATIO * median && *way <= MAX_DETOUR * straight)
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::VertexId;

    #[test]
    fn cells_of_a_strip() {
        // A strip of seven quads, each cut in two, with handles at its two ends and in the middle.
        let positions: Vec<[f64; 3]> = (0..16).map(|i| [f64::from(i / 2), f64::from(i % 2), 0.0]).collect();
        let triangles: Vec<[u32; 3]> = (0..7u32)
            .flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 2, 2 * i + 3, 2 * i + 1]])
            .collect();
        let topology = Topology::new(17, &triangles);
        let positions = [positions, vec![[9.0; 3]]].concat();
        let cells = voronoi_cells(&positions, &topology, &[0, 14, 6].map(|v| VertexId(v).into()));
        // A quad's side has the length 1, and its diagonal, which leans to the left, √2. So the left handle
        // has the first two columns, and the middle handle the next three. The lower vertex of the sixth
        // column is as far from the middle handle as from the right one, and the handle with the lower number
        // gets it. The upper vertex is nearer to the right handle.
        let expected = [0, 0, 0, 0, 2, 2, 2, 2, 2, 2, 1, 1, 1, 1, 1, 1].map(|h| Some(HandleId(h)));
        assert_eq!(cells[..16], expected);
        assert_eq!(touching_cells(&topology, &cells), [[0, 2], [1, 2]].map(|pair| pair.map(HandleId)));
    }

    /// A grid of 7 × 6 quads of 3 by 4, each cut in two. All lengths are whole numbers, and many are equal.
    /// `bend` moves the vertices by up to that much.
    fn grid(bend: f64) -> (Vec<[f64; 3]>, Topology) {
        let number = |i: u32| ((f64::from(i) * 12.9898).sin() * 43758.5453).fract();
        let at = |i: u32| {
            [3.0 * f64::from(i % 8) + bend * number(i), 4.0 * f64::from(i / 8), bend * number(100 + i)]
        };
        let quads = (0..6).flat_map(|row| (0..7).map(move |column| 8 * row + column));
        let triangles: Vec<[u32; 3]> = quads.flat_map(|a| [[a, a + 1, a + 9], [a, a + 9, a + 8]]).collect();
        ((0..56).map(at).collect(), Topology::new(56, &triangles))
    }

    #[test]
    fn what_is_near_has_the_distances_of_all() {
        for bend in [0.0, 1.0] {
            let (positions, topology) = grid(bend);
            let graph = EdgeGraph::new(&positions, &topology);
            let mut near = Near::new(&graph);
            let mut distances = vec![0.0; positions.len()];
            for (from, limit) in [(0, 9.0), (27, 0.0), (27, 12.5), (50, 1e9), (3, 2.0)] {
                graph.distances(&VertexId(from).into(), |_| limit, &mut distances);
                let expected = (0..).zip(&distances).filter(|(_, d)| **d <= limit).map(|(v, d)| (v, *d));
                let mut found: Vec<(u32, f64)> = near.search(from, limit).collect();
                found.sort_by_key(|(v, _)| *v);
                assert_eq!(found, expected.collect::<Vec<_>>(), "{bend} {from} {limit}");
                assert_eq!((0..56).map(|v| near.distance(v)).collect::<Vec<_>>(), distances);
            }
        }
    }

    /// All distances by Floyd and Warshall.
    fn all_distances(positions: &[[f64; 3]], topology: &Topology) -> Vec<Vec<f64>> {
        let position = |v: usize| DVec3::from_array(positions[v]);
        let count = positions.len();
        let mut all = vec![vec![f64::INFINITY; count]; count];
        for (v, of_vertex) in all.iter_mut().enumerate() {
            of_vertex[v] = 0.0;
            for &w in topology.neighbors(v) {
                of_vertex[w as usize] = position(v).distance(position(w as usize));
            }
        }
        for k in 0..count {
            for i in 0..count {
                for j in 0..count {
                    all[i][j] = all[i][j].min(all[i][k] + all[k][j]);
                }
            }
        }
        all
    }

    #[test]
    fn distances_and_cells_are_those_of_every_way_there_is() {
        let handles = [50, 3, 20, 23, 5];
        for bend in [0.0, 2.5] {
            let (positions, topology) = grid(bend);
            let all = all_distances(&positions, &topology);
            let mut found = vec![0.0; positions.len()];
            let graph = EdgeGraph::new(&positions, &topology);
            for &h in &handles {
                graph.distances(&VertexId(h).into(), |_| f64::INFINITY, &mut found);
                for (v, distance) in found.iter().enumerate() {
                    assert!((distance - all[h as usize][v]).abs() < 1e-12, "from {h} to {v}");
                }
            }
            for (v, cell) in voronoi_cells(&positions, &topology, &handles.map(|v| VertexId(v).into()))
                .into_iter()
                .enumerate()
            {
                let of_handle = |h: usize| all[handles[h] as usize][v];
                let nearest =
                    (0..handles.len()).min_by(|a, b| of_handle(*a).total_cmp(&of_handle(*b))).unwrap();
                assert_eq!(cell, Some(HandleId::from_index(nearest)), "vertex {v}, bent by {bend}");
            }
        }
    }

    #[test]
    fn a_ring_with_handles_on_one_side_has_no_edge_around_its_back() {
        // 60 vertices a way around, three high; a handle at every third of the first ten.
        let at = |i: usize| std::f64::consts::TAU * i as f64 / 60.0;
        let positions: Vec<[f64; 3]> =
            (0..180).map(|v| [at(v / 3).cos(), at(v / 3).sin(), 0.1 * (v % 3) as f64]).collect();
        let v = |i: u32, j: u32| 3 * (i % 60) + j;
        let triangles: Vec<[u32; 3]> = (0..60)
            .flat_map(|i| [0, 1].map(|j| (i, j)))
            .flat_map(|(i, j)| {
                [[v(i, j), v(i + 1, j), v(i, j + 1)], [v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)]]
            })
            .collect();
        let topology = Topology::new(180, &triangles);
        let handles: Vec<SurfacePoint> = (0..4).map(|i| VertexId(v(3 * i, 1)).into()).collect();
        let graph = EdgeGraph::new(&positions, &topology);
        let cells = nearest_handles(&graph, &handles);
        let of: Vec<Option<HandleId>> = cells.iter().map(|cell| cell.map(|cell| cell.handle)).collect();
        let mut edges = touching_cells(&topology, &of);
        assert_eq!(edges, [[0, 1], [0, 3], [1, 2], [2, 3]].map(|pair| pair.map(HandleId)));
        let ways = ways(&graph, &cells, &edges);
        assert!((ways[1] / ways[0] - 51.0 / 3.0).abs() < 0.5, "{ways:?}");
        drop_far_pairs(&graph, &cells, |h| handles[h.index()].at(&positions), &mut edges);
        assert_eq!(edges, [[0, 1], [1, 2], [2, 3]].map(|pair| pair.map(HandleId)));
    }
}
