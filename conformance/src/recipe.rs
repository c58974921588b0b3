//! Rigs made of random numbers from fixed seeds, each with something that is hard on a kernel.
use crate::{Built, Numbers};
use rhytid_core::{Faces, FoldStrains, Learned, Rig, UpAxis};

/// Sizes of a rig, and of a batch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sizes {
    /// V.
    pub vertices: usize,
    /// H, made fewer where there are fewer vertices.
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
    /// The sheet with vertices on top of others, triangles that are lines, and triangles with a corner twice.
    ZeroArea,
    /// All vertices around the first: one vertex has a triangle for each other.
    Fan,
}

/// Where the handles go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Motion {
    /// Each somewhere near.
    Random,
    /// Nowhere.
    Rest,
    /// All into one point: every strain is −1.
    Collapsed,
}

/// What a case is made from.
#[derive(Debug, Clone)]
pub(crate) struct Recipe {
    /// How large it is.
    pub sizes: Sizes,
    /// The random numbers.
    pub seed: u64,
    /// The triangles.
    pub surface: Surface,
    /// The batch.
    pub motion: Motion,
    /// What 1 becomes in mesh units; the face stays as large in metres.
    pub unit: f64,
    /// Whether the second and third centre have the same features.
    pub coincident_poses: bool,
    /// Whether the basis has numbers of all sizes down to 10⁻⁸, as a real one does.
    pub small_weights: bool,
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
            learned: false,
            rotations: false,
        }
    }

    /// Makes it.
    pub(crate) fn build(&self) -> Built {
        let mut numbers = Numbers::new(self.seed);
        let Sizes { vertices, handles, edges, examples, influences, .. } = self.sizes;
        let mut rest = self.rest(&mut numbers);
        let triangles = self.triangles(&mut rest);
        let unit = |p: [f64; 3]| p.map(|c| (c * self.unit) as f32);
        let rest: Vec<[f32; 3]> = rest.into_iter().map(unit).collect();

        let step = vertices * 5 / 8 + 1;
        // Distinct vertices, spread by a step that shares no factor with V; more handles than that cannot be.
        let step = (step..).find(|s| gcd(*s, vertices) == 1).unwrap_or(1);
        let handle_vertices: Vec<u32> =
            (0..handles.min(vertices)).map(|h| (h * step % vertices) as u32).collect();
        let handles = handle_vertices.len();
        let strain_edges = self.strain_edges(&rest, &handle_vertices, edges, &mut numbers);
        let edges = strain_edges.len();
        let influences = influences.min(edges);
        let centers = examples + 1;
        let mut pose_features: Vec<f32> = (0..centers * edges)
            .map(|i| if i < edges { 0.0 } else { 0.3 * numbers.signed() as f32 })
            .collect();
        if self.coincident_poses {
            pose_features.copy_within(edges..2 * edges, 2 * edges);
        }
        let mut basis = Vec::with_capacity(vertices * handles);
        for _ in 0..vertices * handles {
            let size = if self.small_weights { 10f64.powf(-8.0 * numbers.unit()) } else { 1.0 };
            basis.push((size * numbers.signed()) as f32);
        }
        if self.surface == Surface::ZeroArea {
            // What lies together moves together.
            for v in (ON_TOP..vertices).step_by(ON_TOP) {
                basis.copy_within((v - 1) * handles..v * handles, v * handles);
            }
        }
        let mut rig = Rig {
            name: "random".into(),
            metres_per_unit: 0.01 / self.unit,
            up_axis: UpAxis::Y,
            labels: (0..handles).map(|h| format!("m{h}")).collect(),
            example_names: (0..examples).map(|j| format!("pose {j}")).collect(),
            faces: Faces { counts: vec![3; triangles.len()], indices: triangles.as_flattened().to_vec() },
            uvs: None,
            materials: None,
            bending_length: self.unit,
            beta: 1.0 / self.unit,
            triangles,
            basis,
            influence_edges: (0..vertices).flat_map(|_| numbers.some_below(edges, influences)).collect(),
            influence_weights: (0..vertices * influences)
                .map(|_| if numbers.below(3) == 0 { 0.0 } else { numbers.unit() as f32 })
                .collect(),
            tangent_neighbors: (0..vertices).map(|v| ((v + 1) % vertices) as u32).collect(),
            pose_features,
            rbf_weights: (0..vertices * centers).map(|_| unit(vector(&mut numbers, 2.0))).collect(),
            // Where they are, the learned method alone wants to know.
            example_handles: vec![[0.0; 3]; examples * handles],
            rotations: self.rotations,
            learned: None,
            strain_edges,
            rest,
            handles: handle_vertices,
        };
        let handle_positions = self.handle_positions(&rig, &mut numbers);
        if self.learned {
            self.learn(&mut rig, &mut numbers);
        }
        Built { rig, handle_positions }
    }

    /// Makes the rig one of the learned method: anything of the right shapes.
    fn learn(&self, rig: &mut Rig, numbers: &mut Numbers) {
        let (vertices, examples) = (rig.vertices(), rig.example_names.len());
        let unit = |p: [f64; 3]| p.map(|c| (c * self.unit) as f32);
        let rest = rig.handles.iter().map(|&v| rig.rest[v as usize].map(f64::from));
        let rest: Vec<[f64; 3]> = rest.collect();
        rig.example_handles = (0..examples)
            .flat_map(|_| &rest)
            .map(|rest| {
                let u = vector(numbers, 0.5);
                std::array::from_fn(|c| (rest[c] + self.unit * u[c]) as f32)
            })
            .collect();
        let a = ANCHORS.min(rig.handles.len());
        let anchors = (0..vertices).flat_map(|_| numbers.some_below(rig.handles.len(), a)).collect();
        let mut weights = |_| if numbers.below(3) == 0 { 0.0 } else { numbers.unit() as f32 };
        // One rig has folds and nothing else beyond its basis.
        let share = if examples == 3 { 0.0 } else { 0.2 };
        let weights_of_examples = if share > 0.0 { vertices * examples } else { 0 };
        rig.learned = Some(Learned {
            share,
            ridge: 1e-2,
            fold_ridge: 1e-3,
            marker_noise: 0.0,
            fold_strains: if examples % 3 == 0 { FoldStrains::Vectors } else { FoldStrains::Lengths },
            // Some frames go farther than the examples, and with others it does not matter.
            reach: if examples % 4 > 0 { 1.0 } else { f64::INFINITY },
            anchors,
            anchor_weights: (0..vertices * a).map(&mut weights).collect(),
            // It is in the basis: no kernel reads it.
            feature_gains: vec![0.0; vertices * (rig.influences() + a)],
            example_weights: (0..weights_of_examples).map(|_| unit(vector(numbers, 2.0))).collect(),
            variances: vec![0.0; vertices],
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
            // Lines of grid points in a row, and corners that are one vertex.
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

    /// Pairs of handles that do not lie together, as a rig promises.
    fn strain_edges(
        &self,
        rest: &[[f32; 3]],
        handles: &[u32],
        edges: usize,
        numbers: &mut Numbers,
    ) -> Vec<[u32; 2]> {
        let at = |h: u32| rest[handles[h as usize] as usize];
        let mut strain_edges = Vec::with_capacity(edges);
        while handles.len() > 1 && strain_edges.len() < edges {
            let a = numbers.below(handles.len()) as u32;
            let b = (a + 1 + numbers.below(handles.len() - 1) as u32) % handles.len() as u32;
            if at(a) != at(b) {
                strain_edges.push([a, b]);
            }
        }
        strain_edges
    }

    fn handle_positions(&self, rig: &Rig, numbers: &mut Numbers) -> Vec<f32> {
        let mut positions = Vec::with_capacity(self.sizes.frames * rig.handles.len() * 3);
        for _ in 0..self.sizes.frames {
            let meeting = vector(numbers, 3.0);
            for &v in &rig.handles {
                let rest = rig.rest[v as usize].map(|c| f64::from(c) / self.unit);
                let p = match self.motion {
                    Motion::Random => {
                        let u = vector(numbers, 0.5);
                        std::array::from_fn(|c| rest[c] + u[c])
                    }
                    Motion::Rest => {
                        positions.extend(rig.rest[v as usize]);
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

/// Anchors of a vertex, at most.
const ANCHORS: usize = 8;

/// In [`Surface::ZeroArea`], each so-manieth vertex lies on the one before it.
const ON_TOP: usize = 10;

/// Three numbers in −size..size.
fn vector(numbers: &mut Numbers, size: f64) -> [f64; 3] {
    std::array::from_fn(|_| size * numbers.signed())
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
