//! Rigs made of random numbers from fixed seeds, each with something that is hard for a kernel.
use crate::{Built, Numbers};
use rhytid_core::{
    Examples, Faces, FineScale, HandleId, HandleSet, Influences, Learned, Rig, RigParts, StrainEdgeId,
    SurfacePoint, Table, UpAxis, VertexId, WrinkleStrains,
};

/// Sizes of a rig, and of a batch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sizes {
    /// V.
    pub vertices: usize,
    /// H; reduced if there are fewer vertices.
    pub handles: usize,
    /// F.
    pub edges: usize,
    /// P.
    pub examples: usize,
    /// K, 0 where F is 0.
    pub influences: usize,
    /// Frames in the batch.
    pub frames: usize,
    /// Frames of the largest batch.
    pub max_frames: usize,
}

/// How triangles lie on the vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Surface {
    /// A jittered sheet; the vertices left over from whole rows are isolated.
    Sheet,
    /// The sheet without a seventh of its quads.
    Holes,
    /// The sheet without all triangles at every third vertex.
    Isolated,
    /// The sheet with vertices on top of others, triangles that are lines, and triangles that name a corner
    /// twice.
    ZeroArea,
    /// All vertices around the first one: it shares a triangle with every other vertex.
    Fan,
}

/// Where the handles go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Motion {
    /// Each to a random place nearby.
    Random,
    /// They stay at rest.
    Rest,
    /// All into one point: every strain is −1.
    Collapsed,
}

/// The data from which a case is made.
#[derive(Debug, Clone)]
pub(crate) struct Recipe {
    /// Its sizes.
    pub sizes: Sizes,
    /// The random numbers.
    pub seed: u64,
    /// The triangles.
    pub surface: Surface,
    /// The batch.
    pub motion: Motion,
    /// The length of 1 in mesh units. The face keeps its size in metres.
    pub unit: f64,
    /// Whether the second and third centre have the same features.
    pub coincident_poses: bool,
    /// Whether the basis has numbers of all sizes down to 10⁻⁸, as a real one does.
    pub small_weights: bool,
    /// The rank of the basis, where it is less than the number of handles.
    pub rank: Option<usize>,
    /// Whether it is a rig of the learned method.
    pub learned: bool,
    /// Whether the handles turn.
    pub rotations: bool,
}

impl Sizes {
    /// Any sizes up to some hundreds.
    pub(crate) fn random(seed: u64) -> Self {
        let mut numbers = Numbers::new(seed ^ 0x51de5);
        let max_frames = 1 + numbers.below(12);
        Self {
            vertices: 1 + numbers.below(700),
            handles: 1 + numbers.below(120),
            edges: numbers.below(400),
            examples: numbers.below(12),
            influences: numbers.below(17),
            frames: 1 + numbers.below(max_frames),
            max_frames,
        }
    }
}

impl Recipe {
    /// A sheet that moves.
    pub(crate) fn new(sizes: Sizes) -> Self {
        Self {
            sizes,
            seed: sizes.vertices as u64,
            surface: Surface::Sheet,
            motion: Motion::Random,
            unit: 1.0,
            coincident_poses: false,
            small_weights: false,
            rank: None,
            learned: false,
            rotations: false,
        }
    }

    /// Makes the case.
    pub(crate) fn build(&self) -> Built {
        let mut numbers = Numbers::new(self.seed);
        let Sizes { vertices, handles, edges, examples, influences, .. } = self.sizes;
        let mut rest = self.rest(&mut numbers);
        let triangles = self.triangles(&mut rest);
        let unit = |p: [f64; 3]| p.map(|c| (c * self.unit) as f32);
        let rest: Vec<[f32; 3]> = rest.into_iter().map(unit).collect();

        let step = vertices * 5 / 8 + 1;
        // Distinct vertices, spread by a step that shares no factor with V. There cannot be more handles than
        // vertices.
        let step = (step..).find(|s| gcd(*s, vertices) == 1).unwrap_or(1);
        let handle_vertices: Vec<VertexId> =
            (0..handles.min(vertices)).map(|h| VertexId::from_index(h * step % vertices)).collect();
        let handle_rest: Vec<[f32; 3]> = handle_vertices.iter().map(|v| rest[v.index()]).collect();
        let handles = handle_vertices.len();
        let strain_edges = strain_edges(&handle_rest, edges, &mut numbers);
        let edges = strain_edges.len();
        let influences = influences.min(edges);
        let centers = examples + 1;
        let mut pose_features: Vec<f32> = (0..centers * edges)
            .map(|i| if i < edges { 0.0 } else { 0.3 * numbers.signed() as f32 })
            .collect();
        if self.coincident_poses {
            pose_features.copy_within(edges..2 * edges, 2 * edges);
        }
        let basis = self.basis(vertices, handles, &mut numbers);
        let influence_edges =
            (0..vertices).flat_map(|_| numbers.some_below(edges, influences)).map(StrainEdgeId).collect();
        let influence_weights = (0..vertices * influences)
            .map(|_| if numbers.below(3) == 0 { 0.0 } else { numbers.unit() as f32 })
            .collect();
        let rbf_weights = (0..vertices * centers).map(|_| unit(vector(&mut numbers, 2.0))).collect();
        let mut parts = RigParts {
            surface: rhytid_core::Surface {
                name: "random".into(),
                metres_per_unit: 0.01 / self.unit,
                up_axis: UpAxis::Y,
                faces: Faces { counts: vec![3; triangles.len()], indices: triangles.as_flattened().to_vec() },
                uvs: None,
                materials: None,
                triangles,
                rest,
                tangent_neighbors: (0..vertices).map(|v| VertexId::from_index((v + 1) % vertices)).collect(),
                joined: None,
            },
            handles: HandleSet {
                labels: (0..handles).map(|h| format!("m{h}")).collect(),
                points: handle_vertices.into_iter().map(SurfacePoint::from).collect(),
                rest: handle_rest,
                strain_edges,
                rotations: self.rotations,
            },
            examples: Examples {
                names: (0..examples).map(|j| format!("pose {j}")).collect(),
                // Only the learned method needs their positions.
                handles: Table::filled(examples, handles, [0.0; 3]),
            },
            bending_length: self.unit,
            basis,
            influences: Influences {
                edges: Table::new(vertices, influences, influence_edges),
                weights: Table::new(vertices, influences, influence_weights),
                beta: 1.0 / self.unit,
            },
            fine_scale: FineScale {
                pose_features: Table::new(centers, edges, pose_features),
                rbf_weights: Table::new(vertices, centers, rbf_weights),
            },
            learned: None,
        };
        let handle_positions = self.handle_positions(&parts.handles, &mut numbers);
        if self.learned {
            self.learn(&mut parts, &mut numbers);
        }
        Built { rig: Rig::new(parts).expect("numbers of the right shapes and ranges"), handle_positions }
    }

    /// A random basis, V×H.
    fn basis(&self, vertices: usize, handles: usize, numbers: &mut Numbers) -> Table<f32> {
        let mut basis = Vec::with_capacity(vertices * handles);
        if let Some(rank) = self.rank {
            let of_rank: Vec<f64> = (0..rank * handles).map(|_| numbers.signed()).collect();
            for _ in 0..vertices {
                let of_vertex: Vec<f64> = (0..rank).map(|_| numbers.signed()).collect();
                let entry =
                    |h: usize| (0..rank).map(|k| of_vertex[k] * of_rank[k * handles + h]).sum::<f64>();
                basis.extend((0..handles).map(|h| entry(h) as f32));
            }
        }
        for _ in basis.len()..vertices * handles {
            let size = if self.small_weights { 10f64.powf(-8.0 * numbers.unit()) } else { 1.0 };
            basis.push((size * numbers.signed()) as f32);
        }
        if self.surface == Surface::ZeroArea {
            // Vertices at the same place move together.
            for v in (ON_TOP..vertices).step_by(ON_TOP) {
                basis.copy_within((v - 1) * handles..v * handles, v * handles);
            }
        }
        Table::new(vertices, handles, basis)
    }

    /// Makes the rig one of the learned method, with arbitrary numbers of the right shapes.
    fn learn(&self, parts: &mut RigParts, numbers: &mut Numbers) {
        let (vertices, examples) = (parts.surface.rest.len(), parts.examples.len());
        let handles = parts.handles.len();
        let unit = |p: [f64; 3]| p.map(|c| (c * self.unit) as f32);
        let rest: Vec<[f64; 3]> = parts.handles.rest.iter().map(|x| x.map(f64::from)).collect();
        let example_handles = (0..examples)
            .flat_map(|_| &rest)
            .map(|rest| {
                let u = vector(numbers, 0.5);
                std::array::from_fn(|c| (rest[c] + self.unit * u[c]) as f32)
            })
            .collect();
        parts.examples.handles = Table::new(examples, handles, example_handles);
        let a = ANCHORS.min(handles);
        let anchors = (0..vertices).flat_map(|_| numbers.some_below(handles, a)).map(HandleId).collect();
        let mut weights = |_| if numbers.below(3) == 0 { 0.0 } else { numbers.unit() as f32 };
        let anchor_weights: Vec<f32> = (0..vertices * a).map(&mut weights).collect();
        // One rig has only wrinkles beyond its basis.
        let share = if examples == 3 { 0.0 } else { 0.2 };
        let columns = if share > 0.0 { examples } else { 0 };
        let example_weights = (0..vertices * columns).map(|_| unit(vector(numbers, 2.0))).collect();
        // A feature without a weight has no gain.
        let mut gain = |weight: f32| if weight == 0.0 { 0.0 } else { (self.unit * numbers.unit()) as f32 };
        let of_vertex = |v: usize| {
            let weights = parts.influences.weights.row(v).iter().chain(&anchor_weights[v * a..][..a]);
            weights.map(|weight| gain(*weight)).collect::<Vec<f32>>()
        };
        let gains: Vec<f32> = (0..vertices).flat_map(of_vertex).collect();
        let feature_gains = Table::new(vertices, parts.influences.per_vertex() + a, gains);
        parts.learned = Some(Learned {
            share,
            ridge: 1e-2,
            wrinkle_ridge: 1e-3,
            marker_noise: 0.0,
            wrinkle_strains: if examples % 3 == 0 {
                WrinkleStrains::Vectors
            } else {
                WrinkleStrains::Lengths
            },
            // Some frames go farther than the examples. In the other rigs the reach is infinite.
            reach: if examples % 4 > 0 { 1.0 } else { f64::INFINITY },
            prior_lengths: Vec::new(),
            anchors: Table::new(vertices, a, anchors),
            anchor_weights: Table::new(vertices, a, anchor_weights),
            feature_gains,
            example_weights: Table::new(vertices, columns, example_weights),
            variances: vec![0.0; vertices],
            contact: <_>::default(),
        });
    }

    fn width(&self) -> usize {
        (self.sizes.vertices as f64).sqrt().ceil() as usize
    }

    fn rest(&self, numbers: &mut Numbers) -> Vec<[f64; 3]> {
        let width = self.width();
        (0..self.sizes.vertices)
            .map(|v| {
                let [x, y, z] = vector(numbers, 0.3);
                if self.surface == Surface::Fan && v > 0 {
                    let angle = v as f64 / self.sizes.vertices as f64 * std::f64::consts::TAU;
                    return [5.0 * angle.cos() + 0.1 * x, 5.0 * angle.sin() + 0.1 * y, 5.0 * z];
                }
                [(v % width) as f64 + x, (v / width) as f64 + y, z]
            })
            .collect()
    }

    fn triangles(&self, rest: &mut [[f64; 3]]) -> Vec<[u32; 3]> {
        let (vertices, width) = (self.sizes.vertices, self.width());
        let mut triangles = Vec::new();
        if self.surface == Surface::Fan {
            triangles.extend((2..vertices as u32).map(|v| [0, v - 1, v]));
        } else {
            for v in 0..vertices {
                let is_hole = self.surface == Surface::Holes && v % 7 == 3;
                if v % width + 1 < width && v + width + 1 < vertices && !is_hole {
                    let [a, b, c, d] = [v, v + 1, v + width + 1, v + width].map(|i| i as u32);
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        if self.surface == Surface::Isolated {
            triangles.retain(|t| t.iter().all(|v| v % 3 != 1));
        }
        if self.surface == Surface::ZeroArea {
            for v in (ON_TOP..vertices).step_by(ON_TOP) {
                rest[v] = rest[v - 1];
            }
            // Lines of grid points, and triangles with two equal corners.
            let lines = (0..vertices as u32 - 2).step_by(11).map(|v| [v, v + 1, v + 1]);
            triangles.extend(lines);
            triangles.extend((0..vertices as u32).step_by(13).map(|v| [v; 3]));
            let last = vertices - 3;
            rest[last + 1] = std::array::from_fn(|c| rest[last][c] + [1.0, 0.5, 0.25][c]);
            rest[last + 2] = std::array::from_fn(|c| rest[last][c] + [2.0, 1.0, 0.5][c]);
            triangles.push([last, last + 1, last + 2].map(|v| v as u32));
        }
        if triangles.is_empty() {
            triangles.push([0, 0, (vertices - 1) as u32]);
        }
        triangles
    }

    fn handle_positions(&self, handles: &HandleSet, numbers: &mut Numbers) -> Vec<f32> {
        let mut positions = Vec::with_capacity(self.sizes.frames * handles.len() * 3);
        for _ in 0..self.sizes.frames {
            let meeting = vector(numbers, 3.0);
            for at_rest in &handles.rest {
                let rest = at_rest.map(|c| f64::from(c) / self.unit);
                let p = match self.motion {
                    Motion::Random => {
                        let u = vector(numbers, 0.5);
                        std::array::from_fn(|c| rest[c] + u[c])
                    }
                    Motion::Rest => {
                        positions.extend(at_rest);
                        continue;
                    }
                    Motion::Collapsed => meeting,
                };
                positions.extend(p.map(|c| (c * self.unit) as f32));
            }
        }
        positions
    }
}

/// The largest number of anchors of a vertex.
const ANCHORS: usize = 8;

/// In [`Surface::ZeroArea`], every vertex whose number is a multiple of this lies on the one before it.
const ON_TOP: usize = 10;

/// Pairs of handles at different places, as a rig requires.
fn strain_edges(rest: &[[f32; 3]], edges: usize, numbers: &mut Numbers) -> Vec<[HandleId; 2]> {
    let mut strain_edges = Vec::with_capacity(edges);
    while rest.len() > 1 && strain_edges.len() < edges {
        let a = numbers.below(rest.len());
        let b = (a + 1 + numbers.below(rest.len() - 1)) % rest.len();
        if rest[a] != rest[b] {
            strain_edges.push([a, b].map(HandleId::from_index));
        }
    }
    strain_edges
}

/// Three random numbers in −size..size.
fn vector(numbers: &mut Numbers, size: f64) -> [f64; 3] {
    std::array::from_fn(|_| size * numbers.signed())
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
