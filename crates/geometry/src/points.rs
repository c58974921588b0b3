//! The points of a surface whose file has some of them as several vertices.
//!
//! glTF has one index per corner. So a vertex on a texture seam, or at a hard edge, is stored once per side.
use rhytid_core::{MOST_AROUND_JOINED, Mesh, VertexId};
use std::collections::HashMap;

/// The vertices of one point are within this part of the neutral's size in every example.
const TOGETHER: f64 = 1e-6;

/// The most edges at one place that are told apart. More are left open.
const MOST_AT_ONE_PLACE: usize = 16;

/// Which vertices are one point of the surface: V vertices are U points.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Points {
    /// V: the point of each vertex. Points are in the order of their lowest vertices.
    pub of_vertex: Vec<u32>,
    /// U: the lowest vertex of each point, ascending.
    pub first: Vec<VertexId>,
}

/// An open edge, in the direction in which its face goes along it.
#[derive(Clone, Copy)]
struct OpenEdge {
    from: u32,
    to: u32,
}

/// Coordinates as a key; −0 is 0.
type Place = [u64; 3];

impl Points {
    /// The points of a mesh, some of which are several vertices. `None` if each vertex is a point of its own.
    ///
    /// Two vertices are one point where two open edges of the mesh lie on each other, and their faces go
    /// along them in opposite directions. So the surface goes on there. In every one of the `examples`, V
    /// positions each, both edges have to lie on each other too. So lips that touch in the neutral are two.
    /// Of several edges that fit, those with the nearest numbers are joined.
    ///
    /// A point never has more than [`MOST_AROUND_JOINED`] triangles around it. Its vertices stay apart where
    /// it would.
    pub fn new(mesh: &Mesh, examples: &[&[[f64; 3]]]) -> Option<Self> {
        let mut joins = Joins { parent: (0..mesh.positions.len() as u32).collect() };
        let [low, high] = mesh.bounds()?;
        let size = (0..3).map(|c| (high[c] - low[c]).powi(2)).sum::<f64>().sqrt();
        let together = |a: u32, b: u32| {
            examples.iter().all(|positions| {
                let (a, b) = (positions[a as usize], positions[b as usize]);
                (0..3).all(|c| (a[c] - b[c]).abs() <= TOGETHER * size)
            })
        };
        for edges in edges_by_place(mesh) {
            let [forwards, backwards] = &edges;
            if forwards.len() + backwards.len() > MOST_AT_ONE_PLACE {
                continue;
            }
            let lie_on = |a: &OpenEdge, b: &OpenEdge| together(a.from, b.to) && together(a.to, b.from);
            // Where parts lie on each other in all poses, files have the vertices of a part together.
            let apart = |a: &OpenEdge, b: &OpenEdge| a.from.abs_diff(b.to);
            for a in forwards {
                let fitting = backwards.iter().filter(|b| lie_on(a, b));
                let Some(b) = fitting.min_by_key(|b| apart(a, b)) else { continue };
                let back = forwards.iter().filter(|a| lie_on(a, b)).min_by_key(|a| apart(a, b));
                if back.is_some_and(|back| std::ptr::eq(back, a)) {
                    joins.join(a.from, b.to);
                    joins.join(a.to, b.from);
                }
            }
        }
        joins.points(mesh)
    }

    /// U.
    pub fn len(&self) -> usize {
        self.first.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.first.is_empty()
    }

    /// V: the lowest vertex of each vertex's point.
    pub fn first_of_each(&self) -> Vec<VertexId> {
        self.of_vertex.iter().map(|&point| self.first[point as usize]).collect()
    }

    /// Takes all vertices of a point to where one of them is that moved from its place in `before`. V
    /// positions.
    pub fn follow(&self, before: &[[f64; 3]], positions: &mut [[f64; 3]]) {
        let mut moved: Vec<Option<[f64; 3]>> = vec![None; self.len()];
        for (&point, (before, x)) in self.of_vertex.iter().zip(before.iter().zip(positions.iter())) {
            if before != x {
                moved[point as usize] = Some(*x);
            }
        }
        for (&point, x) in self.of_vertex.iter().zip(positions) {
            *x = moved[point as usize].unwrap_or(*x);
        }
    }

    /// V positions in which all vertices of a point are where their mean is.
    pub fn even_out(&self, positions: &mut [[f64; 3]]) {
        let mut sums = vec![([0.0; 3], 0.0); self.len()];
        for (&point, x) in self.of_vertex.iter().zip(positions.iter()) {
            let (sum, count) = &mut sums[point as usize];
            (0..3).for_each(|c| sum[c] += x[c]);
            *count += 1.0;
        }
        for (&point, x) in self.of_vertex.iter().zip(positions) {
            let (sum, count) = sums[point as usize];
            if count > 1.0 {
                *x = sum.map(|sum| sum / count);
            }
        }
    }
}

/// The open edges of a mesh that lie on others: for each place, those in its direction and those against it.
/// In the order of the mesh.
fn edges_by_place(mesh: &Mesh) -> Vec<[Vec<OpenEdge>; 2]> {
    let mut uses: HashMap<[u32; 2], u32> = HashMap::new();
    let each_edge = || {
        mesh.faces.iter().flat_map(|face| {
            let next = face.iter().cycle().skip(1);
            face.iter().zip(next).map(|(&from, &to)| OpenEdge { from, to })
        })
    };
    let between = |edge: &OpenEdge| [edge.from.min(edge.to), edge.from.max(edge.to)];
    for edge in each_edge() {
        *uses.entry(between(&edge)).or_default() += 1;
    }
    // Adding zero makes −0 and 0 the same.
    let place = |v: u32| -> Place { mesh.positions[v as usize].map(|c| (c + 0.0).to_bits()) };
    let mut numbers: HashMap<[Place; 2], usize> = HashMap::new();
    let mut places: Vec<[Vec<OpenEdge>; 2]> = Vec::new();
    for edge in each_edge().filter(|edge| uses[&between(edge)] == 1) {
        let [from, to] = [place(edge.from), place(edge.to)];
        if from == to {
            continue;
        }
        let number = *numbers.entry([from.min(to), from.max(to)]).or_insert(places.len());
        if number == places.len() {
            places.push(<_>::default());
        }
        places[number][usize::from(from > to)].push(edge);
    }
    places
}

/// Vertices that are joined, as a forest whose roots are the lowest vertices.
struct Joins {
    parent: Vec<u32>,
}

impl Joins {
    fn root(&mut self, mut v: u32) -> u32 {
        while self.parent[v as usize] != v {
            let grandparent = self.parent[self.parent[v as usize] as usize];
            self.parent[v as usize] = grandparent;
            v = grandparent;
        }
        v
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    fn points(mut self, mesh: &Mesh) -> Option<Points> {
        let vertices = mesh.positions.len() as u32;
        let mut around = vec![0usize; mesh.positions.len()];
        for face in mesh.faces.iter() {
            for &v in face {
                // A corner of a polygon is in at most all of its triangles but the ends.
                around[self.root(v) as usize] += face.len() - 2;
            }
        }
        let (mut of_vertex, mut first) = (Vec::with_capacity(mesh.positions.len()), Vec::new());
        for v in 0..vertices {
            let root = self.root(v);
            let stays_apart = around[root as usize] > MOST_AROUND_JOINED;
            if root == v || stays_apart {
                of_vertex.push(first.len() as u32);
                first.push(VertexId(v));
            } else {
                of_vertex.push(of_vertex[root as usize]);
            }
        }
        (first.len() < of_vertex.len()).then_some(Points { of_vertex, first })
    }
}
