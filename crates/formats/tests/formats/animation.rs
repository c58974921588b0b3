//! Small animations to export.
use rhytid_core::channel::{self, Channel};
use rhytid_core::{ChannelKind, Faces, Materials, NoProgress, Result, RigidMotion, UpAxis, Uvs};
use rhytid_formats::animation;
use rhytid_formats::export::{
    ChannelChoice, Clip, Frame, Gains, HeadMotion, Options, OutputStage, Recipe, Scene, StatedRecipe,
    Treatment, Written,
};
use rhytid_formats::take::Missing;
use std::path::Path;

/// 7.038531e-26: that text, read as `f64` and rounded to `f32`, is its neighbour.
pub(crate) const ROUNDED_TWICE: f32 = f32::from_bits(0x15ae_43fd);

/// Everything that an exporter is told.
#[derive(Clone)]
pub(crate) struct Animation {
    pub name: String,
    pub rest: Vec<[f32; 3]>,
    pub rest_normals: Vec<[f32; 3]>,
    /// Whether the exporter is told any normals.
    pub with_normals: bool,
    pub faces: Faces,
    pub triangle_corners: Vec<[u32; 3]>,
    pub uvs: Option<Uvs>,
    pub materials: Option<Materials>,
    pub head: Option<Vec<RigidMotion>>,
    pub metres_per_unit: f64,
    pub up_axis: UpAxis,
    pub rate: f64,
    pub first_time_code: f64,
    /// Positions and normals of each frame.
    pub frames: Vec<[Vec<f32>; 2]>,
    /// Further channels, with the numbers of each frame.
    pub others: Vec<Other>,
    pub recipe: StatedRecipe,
}

/// A channel, and its numbers in each frame.
#[derive(Clone)]
pub(crate) struct Other {
    pub channel: Channel,
    pub frames: Vec<Vec<f32>>,
}

impl Animation {
    /// What its frames have beside positions.
    pub(crate) fn channels(&self) -> Vec<Channel> {
        let normals = self.with_normals.then(|| channel::NORMALS.clone());
        normals.into_iter().chain(self.others.iter().map(|other| other.channel.clone())).collect()
    }

    /// The numbers of a further channel in each frame.
    pub(crate) fn other(&self, channel: &Channel) -> Option<&Vec<Vec<f32>>> {
        self.others.iter().find(|other| other.channel.name == channel.name).map(|other| &other.frames)
    }

    /// Without the channels that the file's format has no place for.
    pub(crate) fn for_file(mut self, path: &Path) -> Self {
        let format = animation::Format::from_extension(path).unwrap();
        self.with_normals &= format.carries(ChannelKind::Normals);
        self.others.retain(|other| other.channel.kind.is_some_and(|kind| format.carries(kind)));
        self
    }

    /// States another value of the recipe's.
    pub(crate) fn state(&mut self, name: &str, value: impl Into<serde_json::Value>) {
        self.recipe = std::mem::take(&mut self.recipe).with(name, value.into());
    }

    pub(crate) fn scene(&self) -> Scene<'_> {
        Scene {
            name: &self.name,
            rest: &self.rest,
            rest_normals: self.with_normals.then_some(&self.rest_normals),
            // A few bytes of a test.
            channels: self.channels().leak(),
            faces: &self.faces,
            triangle_corners: &self.triangle_corners,
            uvs: self.uvs.as_ref(),
            materials: self.materials.as_ref(),
            head: self.head.as_deref(),
            metres_per_unit: self.metres_per_unit,
            up_axis: self.up_axis,
            frames: self.frames.len(),
            rate: self.rate,
            first_time_code: self.first_time_code,
            recipe: &self.recipe,
            further: &[],
        }
    }

    pub(crate) fn frame(&self, i: usize) -> Frame<'_> {
        let [positions, normals] = &self.frames[i];
        let mut frame = Frame::new(positions);
        if self.with_normals {
            frame = frame.with(&channel::NORMALS, normals);
        }
        let others = self.others.iter().filter_map(|other| Some((&other.channel, other.frames.get(i)?)));
        others.fold(frame, |frame, (channel, numbers)| frame.with(channel, numbers))
    }

    pub(crate) fn export(&self, path: &Path) -> Result<Written> {
        self.export_with(path, &Options::default())
    }

    pub(crate) fn export_with(&self, path: &Path, options: &Options) -> Result<Written> {
        let mut exporter = animation::create(path, &self.scene(), options)?;
        for i in 0..self.frames.len() {
            exporter.frame(&self.frame(i))?;
        }
        exporter.finish(&NoProgress)
    }
}

/// Exports takes of one mesh, each as a clip of its own.
pub(crate) fn export_clips(takes: &[Animation], path: &Path, options: &Options) -> Result<Written> {
    let clips = takes[1..].iter().map(|take| Clip {
        head: take.head.as_deref(),
        frames: take.frames.len(),
        rate: take.rate,
        first_time_code: take.first_time_code,
        recipe: &take.recipe,
    });
    let clips: Vec<Clip<'_>> = clips.collect();
    let mut exporter = animation::create(path, &Scene { further: &clips, ..takes[0].scene() }, options)?;
    for take in takes {
        for i in 0..take.frames.len() {
            exporter.frame(&take.frame(i))?;
        }
    }
    exporter.finish(&NoProgress)
}

/// How texture coordinates are given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum UvKind {
    None,
    PerVertex,
    PerCorner,
    /// Per corner, and beyond 0 to 1.
    Tiled,
}

/// A sheet of 5 × 4 quads with a triangle and a pentagon at its rim and one vertex of no face, moving at
/// random.
pub(crate) fn animation(uvs: UvKind, frames: usize, seed: u64) -> Animation {
    let mut random = Random(seed);
    let mut faces = Faces::default();
    for y in 0..4 {
        for x in 0..5 {
            let v = y * 6 + x;
            faces.push(&[v, v + 1, v + 7, v + 6]);
        }
    }
    faces.push(&[0, 30, 1]);
    faces.push(&[24, 25, 26, 31, 32]);
    let vertices = 34;
    let rest: Vec<[f32; 3]> = (0..vertices).map(|_| random.vector(10.0)).collect();
    // The last vertex has no face, hence no normal.
    let normals = |random: &mut Random| -> Vec<[f32; 3]> {
        (0..vertices).map(|v| if v == vertices - 1 { [0.0; 3] } else { random.unit_vector() }).collect()
    };
    let rest_normals = normals(&mut random);
    let uvs = match uvs {
        UvKind::None => None,
        UvKind::PerVertex => {
            Some(Uvs { values: (0..vertices).map(|_| random.uv()).collect(), corners: None })
        }
        UvKind::PerCorner | UvKind::Tiled => {
            // Few values for many corners: some vertices get one, others several, some twice the same value
            // under two indices.
            let mut values: Vec<[f32; 2]> = (0..5).map(|_| random.uv()).collect();
            values.push(values[0]);
            if uvs == UvKind::Tiled {
                values[3] = [2.5, -1.25];
            }
            let corners = faces.indices.iter().map(|_| random.below(values.len() as u64) as u32).collect();
            Some(Uvs { values, corners: Some(corners) })
        }
    };
    let frames = (0..frames)
        .map(|_| {
            let positions = rest.iter().flat_map(|p| {
                let offset = random.vector(2.0);
                [p[0] + offset[0], p[1] + offset[1], p[2] + offset[2]]
            });
            [positions.collect(), normals(&mut random).into_flattened()]
        })
        .collect();
    Animation {
        name: "face".into(),
        triangle_corners: fans(&faces),
        rest,
        rest_normals,
        with_normals: true,
        faces,
        uvs,
        materials: None,
        head: None,
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        rate: 30.0,
        first_time_code: 1.0,
        frames,
        others: Vec::new(),
        recipe: StatedRecipe::from(&Recipe {
            version: "1.2.3".into(),
            rig: "0123456789abcdef".into(),
            stage: OutputStage::Full,
            first_frame: 7,
            end_frame: 5_000_000_000,
            fps: Some(30.0 / 1.001),
            start_frame: Some(1001),
            missing: Missing::Hold,
            fade_detail: true,
            head: HeadMotion::Drop,
            detail: 0.5,
            detail_of: Gains(vec![("brows".into(), 0.5), ("chin".into(), 2.0)]),
            edit: Some("[[gain]]\nregion = \"brüw\" # \"\"\"\nby = 1.5\n".into()),
            edit_hash: Some("0123".into()),
            // Whatever the frames have: all that a recipe can state.
            channels: ChannelKind::ALL
                .into_iter()
                .fold(ChannelChoice::NONE, ChannelChoice::with)
                .without(ChannelKind::Normals),
            wrinkle_groups: "a=b+c;d=e".parse().unwrap_or_default(),
            refine: true,
            treatment: Treatment {
                metres_per_unit: Some(1e-3),
                axes: Some("+x+z-y".into()),
                ..Treatment::default()
            },
        }),
    }
}

/// The same with everything that a scene may have: all channels, materials with odd names, and a head that
/// moves.
pub(crate) fn with_everything(uvs: UvKind, frames: usize, seed: u64) -> Animation {
    let mut animation = animation(uvs, frames, seed);
    let mut random = Random(seed ^ 0xa5a5);
    let numbers = animation.rest.len() * 3;
    let velocities = (0..frames).map(|_| (0..numbers).map(|_| random.unit() * 20.0 - 10.0).collect());
    animation.others.push(Other { channel: channel::VELOCITIES.clone(), frames: velocities.collect() });
    for kind in [ChannelKind::Sigma, ChannelKind::Strain, ChannelKind::Wrinkles] {
        for channel in kind.channels(&["smile", "frown"].map(String::from)) {
            let count = channel.width * animation.rest.len();
            let of_frames = (0..frames).map(|_| (0..count).map(|_| random.unit() - 0.5).collect());
            animation.others.push(Other { frames: of_frames.collect(), channel });
        }
    }
    let names = ["skin 1", "skin-1", "Zähne \"oben\"\n", "1"];
    let of_face = (0..animation.faces.len()).map(|_| random.below(4) as u32).collect();
    animation.materials = Some(Materials::named(names, of_face));
    animation.head = Some((0..frames).map(|_| random.motion()).collect());
    animation
}

/// Each polygon as a fan of triangles, by corner.
fn fans(faces: &Faces) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    let mut first = 0;
    for &count in &faces.counts {
        triangles.extend((1..count - 1).map(|i| [first, first + i, first + i + 1]));
        first += count;
    }
    triangles
}

/// SplitMix64: the same numbers on every machine.
pub(crate) struct Random(pub u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    /// From 0 to 1.
    fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    pub(crate) fn vector(&mut self, size: f32) -> [f32; 3] {
        std::array::from_fn(|_| (self.unit() - 0.5) * size)
    }

    fn uv(&mut self) -> [f32; 2] {
        [self.unit(), self.unit()]
    }

    fn unit_vector(&mut self) -> [f32; 3] {
        loop {
            let v = self.vector(2.0);
            let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
            if length > 0.1 {
                return v.map(|x| x / length);
            }
        }
    }

    fn motion(&mut self) -> RigidMotion {
        let q: [f64; 4] = std::array::from_fn(|_| f64::from(self.unit()) - 0.5);
        let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        RigidMotion { rotation: q.map(|x| x / length), translation: self.vector(100.0).map(f64::from) }
    }

    /// Any finite number: every exponent is as likely.
    pub(crate) fn finite(&mut self) -> f32 {
        loop {
            let x = f32::from_bits(self.bits() as u32);
            if x.is_finite() {
                return x;
            }
        }
    }
}
