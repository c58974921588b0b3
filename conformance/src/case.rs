//! The cases, and the suite of each.
use crate::recipe::{Motion, Recipe, Sizes, Surface};
use rhytid_core::{BasisStorage, Rig, UploadOptions};
use serde::Serialize;

/// How much to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Suite {
    /// A second or two: enough to trust a device with a take.
    Quick,
    /// Everything; includes the quick cases.
    Full,
}

/// A rig and a batch of frames to evaluate. The value is small: [`Case::build`] makes the rig.
#[derive(Debug, Clone)]
pub struct Case {
    /// What is special, such as `holes`, or the sizes. `v65-h8-f65-p6-k16-b2-of-3` is a batch of 2 after an
    /// upload for 3.
    pub name: String,
    /// The options of the upload.
    pub options: UploadOptions,
    /// Whether it is in [`Suite::Quick`] too.
    pub quick: bool,
    /// Whether it has the chapter's size. A device may be too small for it.
    pub large: bool,
    recipe: Recipe,
}

/// The contents of a case.
#[derive(Debug, Clone)]
pub struct Built {
    /// The rig.
    pub rig: Rig,
    /// frames × H × 3, mesh units.
    pub handle_positions: Vec<f32>,
}

impl Case {
    /// Makes the rig and the batch, the same on every machine.
    pub fn build(&self) -> Built {
        self.recipe.build()
    }

    fn new(name: impl Into<String>, sizes: Sizes, recipe: impl FnOnce(&mut Recipe)) -> Self {
        let mut all = Recipe::new(sizes);
        recipe(&mut all);
        let options = UploadOptions::frames(sizes.max_frames);
        Self { name: name.into(), options, quick: false, large: false, recipe: all }
    }

    fn of_sizes(sizes: Sizes) -> Self {
        Self::new(Self::name_of(sizes), sizes, |_| ())
    }

    fn learned_of_sizes(sizes: Sizes) -> Self {
        Self::new(format!("learned-{}", Self::name_of(sizes)), sizes, |r| r.learned = true)
    }

    fn name_of(sizes: Sizes) -> String {
        let Sizes { vertices, handles, edges, examples, influences, frames, max_frames } = sizes;
        let batch = if frames == max_frames { "full".into() } else { format!("of-{max_frames}") };
        format!("v{vertices}-h{handles}-f{edges}-p{examples}-k{influences}-b{frames}-{batch}")
    }

    fn quick(mut self) -> Self {
        self.quick = true;
        self
    }

    fn with_clusters(mut self) -> Self {
        self.options.basis = BasisStorage::Clustered;
        self
    }

    fn with_fp16_basis(mut self) -> Self {
        self.options.basis = BasisStorage::F16;
        self
    }
}

/// V, H, F, P, K, frames of the batch and of the largest batch.
/// The vertices, strain edges and handles straddle tiles (16), a workgroup (64), SwiftShader's largest
/// workgroup (256) and blocks of the CPU backend (1025).
const QUICK_SIZES: [[usize; 7]; 6] = [
    [1, 1, 0, 0, 0, 1, 1],
    [63, 8, 65, 6, 16, 1, 2],
    [64, 31, 64, 1, 4, 1, 1],
    [65, 8, 63, 6, 16, 2, 3],
    [129, 89, 243, 6, 16, 31, 32],
    [1025, 89, 243, 6, 16, 1, 1],
];

/// As [`QUICK_SIZES`].
const FULL_SIZES: [[usize; 7]; 19] = [
    [1, 1, 0, 6, 0, 2, 2],
    [2, 2, 1, 0, 1, 1, 1],
    [2, 2, 1, 0, 1, 70_000, 70_000],
    [3, 1, 0, 1, 0, 2, 2],
    [4, 3, 3, 1, 2, 31, 31],
    [31, 7, 11, 2, 4, 2, 2],
    [127, 63, 80, 6, 16, 1, 2],
    [128, 64, 128, 6, 16, 16, 16],
    [129, 65, 127, 40, 2, 1, 32],
    [255, 89, 243, 6, 16, 2, 31],
    [256, 89, 256, 6, 16, 2, 2],
    [257, 89, 257, 6, 16, 2, 2],
    [300, 300, 1000, 40, 16, 3, 5],
    [300, 89, 243, 6, 16, 32, 32],
    [1023, 64, 150, 6, 16, 1, 1],
    [1024, 65, 160, 40, 16, 2, 2],
    [1025, 89, 243, 6, 16, 31, 40],
    [2049, 300, 1000, 6, 16, 2, 2],
    [4097, 89, 243, 8, 1, 4, 4],
];

/// As [`QUICK_SIZES`], of rigs of the learned method.
const QUICK_LEARNED_SIZES: [[usize; 7]; 2] = [[65, 8, 63, 5, 16, 2, 3], [129, 89, 243, 6, 16, 31, 32]];

/// The same. P straddles the 8 examples that are summed at once, and goes up to the promised limit.
const LEARNED_SIZES: [[usize; 7]; 8] = [
    [1, 1, 0, 1, 0, 1, 1],
    [31, 7, 0, 3, 0, 2, 2],
    [63, 8, 65, 8, 16, 1, 2],
    [127, 63, 80, 9, 4, 5, 5],
    [300, 89, 243, 64, 16, 3, 5],
    [301, 89, 243, 63, 16, 3, 5],
    [1025, 89, 243, 6, 16, 17, 40],
    [2049, 300, 1000, 24, 16, 2, 2],
];

fn sizes([vertices, handles, edges, examples, influences, frames, max_frames]: [usize; 7]) -> Sizes {
    Sizes { vertices, handles, edges, examples, influences, frames, max_frames }
}

/// The face of the chapter: V, H, F, P, K, and a batch of one.
const CHAPTER: [usize; 7] = [530_000, 89, 243, 6, 16, 1, 1];

/// Every case of a suite.
pub fn cases(suite: Suite) -> Vec<Case> {
    // An odd size with a whole tile and a part of one, and a batch smaller than the largest.
    let usual = sizes([201, 23, 70, 6, 16, 3, 5]);
    let mut cases: Vec<Case> = QUICK_SIZES.map(|n| Case::of_sizes(sizes(n)).quick()).into();
    cases.extend(chapter_cases(usual));
    cases.extend(learned_cases(usual));
    cases.extend(turning_cases(usual));
    cases.extend(f16_cases(usual));
    cases.extend(clustered_cases(usual));
    cases.extend(QUICK_LEARNED_SIZES.map(|n| Case::learned_of_sizes(sizes(n)).quick()));
    cases.extend(FULL_SIZES.map(|n| Case::of_sizes(sizes(n))));
    cases.extend(LEARNED_SIZES.map(|n| Case::learned_of_sizes(sizes(n))));
    cases.extend((1..=6).map(|seed| {
        let sizes = Sizes::random(seed);
        Case::new(format!("random-{seed}"), sizes, |r| r.seed = seed)
    }));
    let mut chapter = Case::new("chapter", sizes(CHAPTER), |_| ());
    chapter.large = true;
    cases.push(chapter);
    if suite == Suite::Quick {
        cases.retain(|case| case.quick);
    }
    cases
}

/// Rigs of the chapter's method with special surfaces, poses, motions and units.
fn chapter_cases(usual: Sizes) -> Vec<Case> {
    vec![
        Case::new("f16", usual, |r| r.small_weights = true).with_fp16_basis().quick(),
        Case::new("holes", usual, |r| r.surface = Surface::Holes).quick(),
        Case::new("isolated-vertices", usual, |r| r.surface = Surface::Isolated).quick(),
        Case::new("zero-area", usual, |r| r.surface = Surface::ZeroArea).quick(),
        Case::new("fan", Sizes { vertices: 801, ..usual }, |r| r.surface = Surface::Fan).quick(),
        Case::new("coincident-poses", usual, |r| r.coincident_poses = true).quick(),
        Case::new("at-rest", usual, |r| r.motion = Motion::Rest).quick(),
        Case::new("collapsed", usual, |r| r.motion = Motion::Collapsed).quick(),
        Case::new("large-units", usual, |r| r.unit = 1e12).quick(),
        Case::new("small-units", usual, |r| r.unit = 1e-12).quick(),
    ]
}

/// Rigs of the learned method with special motions and units.
fn learned_cases(usual: Sizes) -> Vec<Case> {
    vec![
        Case::new("learned-f16", usual, |r| {
            r.small_weights = true;
            r.learned = true;
        })
        .with_fp16_basis()
        .quick(),
        Case::new("learned-at-rest", usual, |r| {
            r.motion = Motion::Rest;
            r.learned = true;
        })
        .quick(),
        Case::new("learned-large-units", usual, |r| {
            r.unit = 1e12;
            r.learned = true;
        }),
        Case::new("learned-small-units", usual, |r| {
            r.unit = 1e-12;
            r.learned = true;
        }),
    ]
}

/// Rigs whose handles turn, of both methods.
fn turning_cases(usual: Sizes) -> Vec<Case> {
    vec![
        Case::new("turning", usual, |r| r.rotations = true).quick(),
        Case::new("turning-learned-f16", Sizes { frames: 1, ..usual }, |r| {
            r.small_weights = true;
            r.learned = true;
            r.rotations = true;
        })
        .with_fp16_basis()
        .quick(),
        Case::new("turning-at-rest", usual, |r| {
            r.motion = Motion::Rest;
            r.rotations = true;
        })
        .quick(),
        Case::new("turning-collapsed", usual, |r| {
            r.motion = Motion::Collapsed;
            r.rotations = true;
        })
        .quick(),
        Case::new("turning-large-units", usual, |r| {
            r.unit = 1e12;
            r.rotations = true;
        }),
        Case::new("turning-small-units", usual, |r| {
            r.unit = 1e-12;
            r.rotations = true;
        }),
        Case::new("turning-h1", Sizes { handles: 1, edges: 0, influences: 0, ..usual }, |r| {
            r.rotations = true;
        }),
        Case::new(
            "turning-h89-b31",
            Sizes { vertices: 1025, handles: 89, edges: 243, frames: 31, max_frames: 31, ..usual },
            |r| r.rotations = true,
        ),
    ]
}

/// Bases in half precision, of one handle and of many.
fn f16_cases(usual: Sizes) -> Vec<Case> {
    vec![
        Case::new("f16-h1", Sizes { handles: 1, edges: 0, influences: 0, ..usual }, |r| {
            r.small_weights = true;
        })
        .with_fp16_basis(),
        Case::new(
            "f16-h89-b31",
            Sizes { vertices: 1025, handles: 89, frames: 31, max_frames: 31, ..usual },
            |r| {
                r.small_weights = true;
            },
        )
        .with_fp16_basis(),
    ]
}

/// Bases in clusters of 256 vertices.
fn clustered_cases(usual: Sizes) -> Vec<Case> {
    // Two whole clusters, and a short one that ends within a tile.
    let three = Sizes { vertices: 600, ..usual };
    vec![
        Case::new("clustered", three, |r| r.rank = Some(7)).with_clusters().quick(),
        Case::new("clustered-rank-1", three, |r| r.rank = Some(1)).with_clusters().quick(),
        // More rows than handles: those beyond take the rounding to integers away.
        Case::new("clustered-full-rank", three, |_| ()).with_clusters().quick(),
        Case::new("clustered-small-weights", three, |r| r.small_weights = true).with_clusters(),
        Case::new("clustered-h1", Sizes { handles: 1, edges: 0, influences: 0, ..usual }, |_| ())
            .with_clusters()
            .quick(),
        Case::new("clustered-v1", sizes([1, 1, 0, 0, 0, 1, 1]), |_| ()).with_clusters(),
        Case::new("clustered-learned", Sizes { frames: 5, ..three }, |r| {
            r.rank = Some(7);
            r.learned = true;
        })
        .with_clusters()
        .quick(),
        Case::new("clustered-turning", Sizes { frames: 1, ..three }, |r| {
            r.rank = Some(5);
            r.rotations = true;
        })
        .with_clusters()
        .quick(),
        Case::new(
            "clustered-h89-b31",
            Sizes { vertices: 1025, handles: 89, frames: 31, max_frames: 31, ..usual },
            |r| r.rank = Some(20),
        )
        .with_clusters(),
        Case::new(
            "clustered-turning-b31",
            Sizes { vertices: 1025, handles: 89, frames: 31, max_frames: 40, ..usual },
            |r| {
                r.rank = Some(20);
                r.rotations = true;
            },
        )
        .with_clusters(),
    ]
}

/// The vertices of [`timing_case`].
pub const TIMED_VERTICES: usize = 65_536;

/// A rig of [`TIMED_VERTICES`] and a batch of 4 frames, to measure the speed of a device. It belongs to no
/// suite.
pub fn timing_case() -> Case {
    Case::new("timing", sizes([TIMED_VERTICES, 89, 243, 6, 16, 4, 4]), |_| ())
}

/// A small rig for sessions that are broken on purpose.
pub(crate) fn mutant_case() -> Case {
    Case::new("mutant", sizes([65, 8, 20, 6, 16, 2, 2]), |_| ())
}
