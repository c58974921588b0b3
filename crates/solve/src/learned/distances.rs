//! The distances of the handles from each vertex along the edges of the rest mesh, as far as they matter
//! (step 4 of the learned method).
use rayon::prelude::*;
use rhytid_core::{HandleId, HandleSet, Progress, Result, Table};
use rhytid_geometry::Topology;
use rhytid_geometry::geodesic::Cell;
use rhytid_geometry::geodesic::EdgeGraph;
use std::sync::atomic::{AtomicU64, Ordering};

/// An allowance for rounding in bounds.
const SLACK: f64 = 1.0 + 1e-9;

/// g of every handle and vertex.
///
/// g is infinite between parts. It may also be infinite where the handle is neither an end of one of the
/// vertex's nearest strain edges nor one of its nearest handles.
pub(crate) struct Distances {
    /// H×V.
    along: Table<f64>,
    /// F: between the two ends of each strain edge.
    of_edges: Vec<f64>,
}

/// The surface on which distances are measured, and the number of distances that are needed.
#[derive(Clone, Copy)]
pub(crate) struct Searched<'a> {
    /// V×3.
    pub(crate) rest: &'a [[f64; 3]],
    pub(crate) topology: &'a Topology,
    /// V: the handle nearest to each vertex.
    pub(crate) cells: &'a [Option<Cell>],
    /// The number of strain edges of smallest `s = g_va + g_vb − g_ab` that each vertex needs.
    pub(crate) nearest_edges: usize,
    /// The number of nearest handles that each vertex needs.
    pub(crate) nearest_handles: usize,
}

impl Distances {
    /// The distances from each of `handles`, as far as any vertex needs them.
    ///
    /// A search from a handle stops where its distances can no longer matter.
    ///
    /// Let a vertex be in the cell of handle h₀, at the distance d from h₀. All its distances are at most d
    /// more than those from h₀. So its s of the edge of rank n is at most `S(h₀) + 2d`, where S(h₀) is s of
    /// that rank at h₀, over ways through neighbouring cells. An edge with an end h has
    /// `s ≥ 2(g_vh − its length)`. So no edge at h matters beyond `S(h₀)/2 + d + the longest edge at h`.
    ///
    /// Beyond that point on a way from h, no edge at h matters for later vertices either. For each 1 of the
    /// way, the least s of an edge at h grows by 2, and the bound by at most 2.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Cancelled`].
    pub(crate) fn new(
        searched: Searched<'_>,
        handles: &HandleSet<f64>,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let Searched { rest, topology, cells, nearest_edges, nearest_handles } = searched;
        let (vertices, strain_edges) = (rest.len(), &handles.strain_edges);
        let graph = EdgeGraph::new(rest, topology);
        let between = between_handles(&graph, cells, handles.len());
        let straight = |&[a, b]: &[HandleId; 2]| {
            let [a, b] = [a, b].map(|h| handles.rest[h.index()]);
            (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
        };
        let mut longest = vec![0.0_f64; handles.len()];
        for &[a, b] in strain_edges {
            for h in [a, b] {
                longest[h.index()] = longest[h.index()].max(between[a.index()][b.index()]);
            }
        }
        // S/2 and the distance of the last of the nearest handles, from each handle.
        let reach: Vec<[f64; 2]> = between
            .par_iter()
            .map(|from| {
                let s = strain_edges.iter().map(|edge| {
                    let [a, b] = edge.map(|h| from[h.index()]);
                    a + b - straight(edge)
                });
                [ranked(s.collect(), nearest_edges) / 2.0, ranked(from.clone(), nearest_handles)]
            })
            .collect();

        // The part of the bound that a vertex adds to the longest edge at a handle, and the farthest of its
        // nearest handles.
        let reach: Vec<[f64; 2]> = cells
            .par_iter()
            .map(|cell| match *cell {
                Some(own) => reach[own.handle.index()].map(|reach| SLACK * (own.distance + reach)),
                None => [0.0; 2],
            })
            .collect();

        let (total, done) = (handles.len() as u64, AtomicU64::new(0));
        let mut along = Table::filled(handles.len(), vertices, f64::INFINITY);
        along.par_rows_mut().zip(handles.points.par_iter().zip(&longest)).try_for_each(
            |(along, (handle, longest))| {
                progress.step("neighborhoods", done.fetch_add(1, Ordering::Relaxed), total)?;
                let limit = |v: u32| {
                    let [of_edges, of_handles] = reach[v as usize];
                    (of_edges + SLACK * longest).max(of_handles)
                };
                graph.distances(handle, limit, along);
                Ok(())
            },
        )?;
        progress.step("neighborhoods", total, total)?;
        let between = |&[a, b]: &[HandleId; 2]| {
            let [from, to] = [a, b].map(|h| &handles.points[h.index()]);
            graph.between(from, to, along.row(a.index()))
        };
        Ok(Self { of_edges: strain_edges.iter().map(between).collect(), along })
    }

    /// g between handle `h` and vertex `v` in mesh units.
    pub(crate) fn get(&self, h: HandleId, v: usize) -> f64 {
        self.along.row(h.index())[v]
    }

    /// g between the two ends of each strain edge, F in mesh units.
    pub(crate) fn of_edges(&self) -> &[f64] {
        &self.of_edges
    }

    /// g between each of the H handles and vertex `v`, into `out`.
    pub(crate) fn to_handles(&self, v: usize, out: &mut [f64]) {
        for (out, along) in out.iter_mut().zip(self.along.rows()) {
            *out = along[v];
        }
    }

    /// V.
    pub(crate) fn vertices(&self) -> usize {
        self.along.columns()
    }
}

/// The number of this rank, counted from 1. Infinite where there are fewer numbers, or where the rank is 0.
fn ranked(mut numbers: Vec<f64>, rank: usize) -> f64 {
    match rank.checked_sub(1).filter(|&i| i < numbers.len()) {
        Some(i) => *numbers.select_nth_unstable_by(i, f64::total_cmp).1,
        None => f64::INFINITY,
    }
}

/// Upper bounds of the distances between handles, H×H.
///
/// They are the lengths of ways from cell to neighbouring cell, each through the handles of both cells.
fn between_handles(graph: &EdgeGraph<'_>, cells: &[Option<Cell>], handles: usize) -> Vec<Vec<f64>> {
    let mut between = vec![vec![f64::INFINITY; handles]; handles];
    for (v, cell) in cells.iter().enumerate() {
        let Some(a) = *cell else { continue };
        for (w, length) in graph.edges(v as u32) {
            if let Some(b) = cells[w as usize]
                && a.handle != b.handle
            {
                let way = &mut between[a.handle.index()][b.handle.index()];
                *way = way.min(a.distance + length + b.distance);
            }
        }
    }
    for (h, from) in between.iter_mut().enumerate() {
        from[h] = 0.0;
    }
    // The algorithm of Floyd and Warshall.
    for k in 0..handles {
        let through = between[k].clone();
        between.par_iter_mut().for_each(|from| {
            let to = from[k];
            if to.is_finite() {
                from.iter_mut().zip(&through).for_each(|(way, on)| *way = way.min(to + on));
            }
        });
    }
    between
}

#[cfg(test)]
mod tests {
    use super::super::neighborhoods::{InfluenceSource, edge_influences, linear_influences};
    use super::*;
    use rhytid_core::NoProgress;
    use rhytid_core::{SurfacePoint, VertexId};
    use rhytid_geometry::geodesic::nearest_handles;
    use rhytid_geometry::geodesic::touching_cells;

    /// A bent grid of 40 × 30 vertices in quads cut in two, and 80 handles anywhere on it.
    #[test]
    fn what_is_not_searched_changes_nothing() {
        let number = |i: u32| ((f64::from(i) * 12.9898).sin() * 43758.5453).fract().abs();
        let at = |v: u32| {
            let (x, y) = (f64::from(v % 40) + 0.6 * number(v), f64::from(v / 40) + 0.6 * number(v + 5000));
            [x, y, 3.0 * (0.3 * x).sin()]
        };
        let rest: Vec<[f64; 3]> = (0..1200).map(at).collect();
        let corners = (0..29).flat_map(|row| (0..39).map(move |column| 40 * row + column));
        let triangles: Vec<[u32; 3]> =
            corners.flat_map(|a| [[a, a + 1, a + 41], [a, a + 41, a + 40]]).collect();
        let topology = Topology::new(rest.len(), &triangles);
        let points: Vec<SurfacePoint> = (0..80).map(|h| VertexId((h * 7919 + 13) % 1200).into()).collect();
        let cells = nearest_handles(&EdgeGraph::new(&rest, &topology), &points);
        let of_handle: Vec<Option<HandleId>> =
            cells.iter().map(|cell| cell.map(|cell| cell.handle)).collect();
        let mut edges = touching_cells(&topology, &of_handle);
        // An edge across the whole grid.
        edges.push([0, 41].map(HandleId));
        let handles = HandleSet {
            labels: (0..80).map(|h| h.to_string()).collect(),
            rest: points.iter().map(|point| point.at(&rest)).collect(),
            points,
            strain_edges: edges,
            rotations: false,
        };
        let distances = |nearest_edges, nearest_handles| {
            let (rest, topology, cells) = (&rest[..], &topology, &cells[..]);
            let searched = Searched { rest, topology, cells, nearest_edges, nearest_handles };
            Distances::new(searched, &handles, &NoProgress).unwrap()
        };
        let sources = vec![InfluenceSource::Itself; rest.len()];
        for k in [3, 6, 12] {
            let [some, all] = [(k + 1, 8), (usize::MAX, usize::MAX)].map(|(edges, nearest)| {
                let distances = distances(edges, nearest);
                let alpha = edge_influences(&distances, &handles, 4.0, k);
                let omega = linear_influences(&handles, &distances, &alpha, &sources, 4.0);
                let found = distances.along.as_slice().iter().filter(|g| g.is_finite()).count();
                (alpha, omega, found)
            });
            assert!(some.2 < all.2 * 9 / 10, "{k}: {} of {} were searched", some.2, all.2);
            assert_eq!(some.0, all.0, "{k} strain edges");
            assert_eq!(some.1, all.1, "{k} strain edges");
        }
    }
}
