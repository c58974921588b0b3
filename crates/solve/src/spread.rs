//! Handles spread evenly over the front of a face.
use crate::placement::Skin;
use glam::DVec3;
use rhytid_core::{SurfacePoint, VertexId};
use rhytid_geometry::geodesic::{EdgeGraph, nearest_handles};

/// The straight way between two handles is at least this part of the way along the mesh that would do.
const STRAIGHT: f64 = 0.75;

/// A handle near the middle is moved into the middle if it is nearer to its mirror image than this part of
/// its way to the other handles.
const NEAR_MIDDLE: f64 = 0.75;

/// A handle in the middle of the face has at least this part of that way to the others.
const LEAST_IN_MIDDLE: f64 = 0.6;

/// Two handles are at least so far apart, as a part of the median distance from a handle to its nearest.
const LEAST: f64 = 0.5;

/// Rounds of evening out, each followed by replacing the handles that are too near others.
const ROUNDS: usize = 4;

/// Steps of evening out in a round.
const STEPS: usize = 6;

impl Skin {
    /// Vertices for `count` handles, spread evenly over the front of the face, after the `kept` ones: brows,
    /// lids, nose, cheeks, lips, jaw and chin. With examples, only over the height and width of what they
    /// move.
    ///
    /// Each next vertex is the farthest from those before it. Then the vertices go to the middles of their
    /// cells, in several rounds. On a symmetric face, all but the kept ones are symmetric. No two are nearer
    /// than half the median distance between nearest ones, in a straight line, except kept ones. For that,
    /// there may be fewer than `count`.
    pub fn spread(&self, count: usize, kept: &[VertexId]) -> Vec<VertexId> {
        let rest: Vec<[f64; 3]> = self.rest.iter().map(DVec3::to_array).collect();
        let mut spread = Spread {
            skin: self,
            graph: EdgeGraph::new(&rest, &self.topology),
            kept: kept.len(),
            chosen: kept.to_vec(),
            nearest: Vec::new(),
        };
        spread.measure();
        spread.fill(count);
        for _ in 0..ROUNDS {
            for _ in 0..STEPS {
                spread.even_out();
            }
            spread.remove_close();
            spread.measure();
            spread.fill(count);
        }
        spread.remove_close();
        spread.chosen
    }

    /// Labels for spread handles: `m01`, `m02` and so on.
    ///
    /// Mirror images share a number and end with `_l` and `_r`. Left is the face's own left side, +x.
    pub fn labels(&self, vertices: &[VertexId]) -> Vec<String> {
        let mut labels = vec![String::new(); vertices.len()];
        let mut number = 0;
        for i in 0..vertices.len() {
            if !labels[i].is_empty() {
                continue;
            }
            number += 1;
            let other = self.image(vertices[i]).filter(|image| *image != vertices[i]);
            match other.and_then(|image| vertices.iter().position(|v| *v == image)) {
                Some(j) => {
                    let is_left = self.rest[vertices[i].index()].x > self.rest[vertices[j].index()].x;
                    let sides = if is_left { ["l", "r"] } else { ["r", "l"] };
                    labels[i] = format!("m{number:02}_{}", sides[0]);
                    labels[j] = format!("m{number:02}_{}", sides[1]);
                }
                None => labels[i] = format!("m{number:02}"),
            }
        }
        labels
    }

    fn image(&self, v: VertexId) -> Option<VertexId> {
        self.images.as_ref().and_then(|images| images[v.index()]).map(VertexId)
    }

    fn in_front(&self) -> impl Iterator<Item = VertexId> {
        (0..self.rest.len()).filter(|&v| self.front[v]).map(VertexId::from_index)
    }
}

/// Handles while they are spread.
struct Spread<'a> {
    skin: &'a Skin,
    graph: EdgeGraph<'a>,
    /// The first handles stay where they are.
    kept: usize,
    chosen: Vec<VertexId>,
    /// V: the distance from the nearest handle, along the mesh or, if that is less, straight and lengthened.
    nearest: Vec<f64>,
}

impl Spread<'_> {
    fn straight(&self, a: VertexId, b: VertexId) -> f64 {
        self.skin.rest[a.index()].distance(self.skin.rest[b.index()])
    }

    /// Whether a vertex lies in the middle of a symmetric face.
    fn is_middle(&self, v: VertexId) -> bool {
        self.skin.image(v) == Some(v)
    }

    fn measure(&mut self) {
        self.nearest = vec![f64::INFINITY; self.skin.rest.len()];
        for handle in std::mem::take(&mut self.chosen) {
            self.add(handle);
        }
    }

    fn add(&mut self, handle: VertexId) {
        self.chosen.push(handle);
        let before = self.nearest.clone();
        let mut along = vec![0.0; before.len()];
        self.graph.distances(&handle.into(), |w| before[w as usize], &mut along);
        for v in self.skin.in_front() {
            let straight = self.straight(v, handle) / STRAIGHT;
            let nearest = &mut self.nearest[v.index()];
            *nearest = nearest.min(along[v.index()]).min(straight);
        }
    }

    /// The vertex of the front that suits and is farthest from all handles, the lowest of equals.
    fn farthest(&self, suits: impl Fn(VertexId) -> bool) -> Option<VertexId> {
        let far = |v: &VertexId| self.nearest[v.index()];
        let free = self.skin.in_front().filter(|v| far(v) > 0.0 && suits(*v));
        free.max_by(|a, b| far(a).total_cmp(&far(b)).then(b.cmp(a)))
    }

    /// Adds handles, each as far from the others as possible, until there are `count`.
    fn fill(&mut self, count: usize) {
        if self.chosen.is_empty() && count > 0 {
            // The foremost vertex, usually the tip of the nose.
            let forward = |v: &VertexId| self.skin.rest[v.index()].dot(self.skin.axes.z_axis);
            let foremost = |middle: bool| {
                let suiting = self.skin.in_front().filter(|v| !middle || self.is_middle(*v));
                suiting.max_by(|a, b| forward(a).total_cmp(&forward(b)))
            };
            let first = foremost(true).or_else(|| foremost(false).filter(|_| self.skin.images.is_none()));
            first.into_iter().for_each(|v| self.add(v));
        }
        let least = LEAST * self.median();
        let mut is_refused = vec![false; self.skin.rest.len()];
        while self.chosen.len() < count {
            let Some(v) = self.farthest(|v| !is_refused[v.index()]) else { break };
            let far = self.nearest[v.index()];
            if STRAIGHT * far < least {
                break;
            }
            match self.skin.image(v).filter(|image| *image != v) {
                None => self.add(v),
                Some(image) => {
                    let apart = self.straight(v, image);
                    if self.chosen.len() + 1 < count && (apart >= NEAR_MIDDLE * far || far.is_infinite()) {
                        self.add(v);
                        if !self.chosen.contains(&image) {
                            self.add(image);
                        }
                        continue;
                    }
                    // One in the middle is enough for both sides, and all that the count leaves.
                    is_refused[v.index()] = true;
                    is_refused[image.index()] = true;
                    let middle =
                        self.farthest(|w| self.is_middle(w) && self.straight(v, w) <= apart.max(far));
                    if let Some(middle) = middle.filter(|w| self.nearest[w.index()] >= LEAST_IN_MIDDLE * far)
                    {
                        self.add(middle);
                    }
                }
            }
        }
    }

    /// Moves each handle to the vertex nearest to the middle of its cell, where vertices count by their area.
    fn even_out(&mut self) {
        let points: Vec<SurfacePoint> = self.chosen.iter().map(|v| SurfacePoint::from(*v)).collect();
        let cells = nearest_handles(&self.graph, &points);
        let mut sums = vec![(DVec3::ZERO, 0.0); points.len()];
        let mut members: Vec<Vec<VertexId>> = vec![Vec::new(); points.len()];
        for v in self.skin.in_front() {
            let Some(cell) = cells[v.index()] else { continue };
            let (h, area) = (cell.handle.index(), self.skin.area[v.index()]);
            sums[h].0 += area * self.skin.rest[v.index()];
            sums[h].1 += area;
            members[h].push(v);
        }
        let mut is_done = vec![false; points.len()];
        is_done[..self.kept].fill(true);
        for h in 0..points.len() {
            if is_done[h] || members[h].is_empty() {
                continue;
            }
            let old = self.chosen[h];
            let image = self.skin.image(old);
            let other = image.and_then(|image| self.chosen.iter().position(|v| *v == image));
            let middle = sums[h].0 / sums[h].1;
            let off = |v: &VertexId| self.skin.rest[v.index()].distance_squared(middle);
            let is_alone = other == Some(h);
            let suiting = members[h].iter().copied().filter(|v| self.is_middle(*v) == is_alone);
            let Some(new) = suiting.min_by(|a, b| off(a).total_cmp(&off(b)).then(a.cmp(b))) else { continue };
            is_done[h] = true;
            let new_image = self.skin.image(new);
            match (other.filter(|other| *other != h), new_image) {
                (None, _) => self.chosen[h] = new,
                (Some(other), Some(image)) if other >= self.kept && !self.chosen.contains(&image) => {
                    is_done[other] = true;
                    (self.chosen[h], self.chosen[other]) = (new, image);
                }
                (Some(other), Some(image)) if self.chosen[other] == image => is_done[other] = true,
                _ => {}
            }
        }
    }

    /// The distance in a straight line from each handle to its nearest, and which that is.
    fn neighbors(&self) -> Vec<(f64, usize)> {
        let near = |i: usize| {
            let others = (0..self.chosen.len()).filter(move |&j| j != i);
            let apart = others.map(|j| (self.straight(self.chosen[i], self.chosen[j]), j));
            apart.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, i))
        };
        (0..self.chosen.len()).map(near).collect()
    }

    /// The median distance from a handle to its nearest; 0 for fewer than three.
    fn median(&self) -> f64 {
        if self.chosen.len() < 3 {
            return 0.0;
        }
        let mut apart: Vec<f64> = self.neighbors().into_iter().map(|(apart, _)| apart).collect();
        apart.sort_by(f64::total_cmp);
        apart[apart.len() / 2]
    }

    /// Removes handles, the later ones first, until none is too near another. Mirror images go together.
    fn remove_close(&mut self) {
        loop {
            let least = LEAST * self.median();
            let near = self.neighbors();
            let close = |i: &usize| *i >= self.kept && near[*i].0 < least;
            let Some(worst) = (0..near.len()).rev().find(close) else { break };
            let image = self.skin.image(self.chosen[worst]);
            let removed = self.chosen[worst];
            let (kept, mut place) = (self.kept, 0);
            self.chosen.retain(|v| {
                place += 1;
                place <= kept || (*v != removed && Some(*v) != image)
            });
        }
    }
}
