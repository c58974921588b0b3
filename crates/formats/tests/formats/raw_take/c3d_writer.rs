//! A writer of C3D files that are right, or wrong in ways that the tests choose.

/// Codes of the processors.
pub(super) const PROCESSORS: [(&str, u8); 3] = [("intel", 84), ("dec", 85), ("sgi", 86)];

/// A parameter's value.
#[derive(Clone)]
pub(super) enum Value {
    Words(Vec<u16>),
    Floats(Vec<f32>),
    /// A table of two rows, a pair behind the other.
    FloatPairs(Vec<[f32; 2]>),
    /// Each text is filled up with blanks to the longest.
    Texts(Vec<String>),
}

/// A trial as a file has it. Header and parameters can be set apart.
#[derive(Clone)]
pub(super) struct C3d {
    pub processor: u8,
    /// Coordinates are 16-bit multiples of this; `None` for floats.
    pub step: Option<f32>,
    /// The fourth number (below 0: missing) and position of each point of each frame.
    pub frames: Vec<Vec<([f32; 3], i16)>>,
    /// Measurements in a frame behind its points.
    pub analog: usize,
    pub header: Header,
    pub parameters: Vec<(&'static str, &'static str, Value)>,
    /// Whether entries of the parameter section end in a description, as the format's text says.
    pub descriptions: bool,
    /// Bytes behind the last frame instead of what fills the last block.
    pub tail: Option<usize>,
}

/// The values that differ from the rest of the trial.
#[derive(Clone, Default)]
pub(super) struct Header {
    pub points: Option<u16>,
    pub analog: Option<u16>,
    pub frames: Option<(u16, u16)>,
    pub data_block: Option<u16>,
    pub rate: Option<f32>,
    pub scale: Option<f32>,
    pub parameter_blocks: Option<u8>,
}

impl C3d {
    /// Markers `a0`, `a1` … at `rate`, in mm, each seen by two cameras.
    pub(super) fn new(rate: f32, frames: Vec<Vec<([f32; 3], i16)>>) -> Self {
        let points = frames.first().map_or(0, Vec::len);
        let mut out = Self {
            processor: 84,
            step: None,
            analog: 0,
            header: Header { rate: Some(rate), ..Header::default() },
            parameters: Vec::new(),
            descriptions: true,
            tail: None,
            frames,
        };
        out.set("POINT", "USED", Value::Words(vec![points as u16]));
        out.set("POINT", "FRAMES", Value::Words(vec![out.frames.len() as u16]));
        out.set("POINT", "RATE", Value::Floats(vec![rate]));
        out.set("POINT", "SCALE", Value::Floats(vec![-1.0]));
        out.set("POINT", "UNITS", Value::Texts(vec!["mm".into()]));
        out.set("POINT", "DATA_START", Value::Words(vec![0]));
        out.set("POINT", "LABELS", Value::Texts((0..points).map(|j| format!("a{j}")).collect()));
        out.set("ANALOG", "USED", Value::Words(vec![0]));
        out
    }

    /// Coordinates as 16-bit multiples of `step`.
    pub(super) fn integer(mut self, step: f32) -> Self {
        self.step = Some(step);
        self.set("POINT", "SCALE", Value::Floats(vec![step]));
        self
    }

    pub(super) fn set(&mut self, group: &'static str, name: &'static str, value: Value) {
        self.remove(group, name);
        self.parameters.push((group, name, value));
    }

    pub(super) fn remove(&mut self, group: &str, name: &str) {
        self.parameters.retain(|(g, n, _)| (*g, *n) != (group, name));
    }

    /// The file; DATA_START is set to where the points are if it is 0.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let section = self.section(0);
        let data_block = 2 + section.len() / 512;
        let mut out = self.first_block(data_block as u16);
        out.extend(self.section(data_block as u16));
        for frame in &self.frames {
            for (position, fourth) in frame {
                for x in position {
                    match self.step {
                        Some(step) => self.word((x / step).round() as i16 as u16, &mut out),
                        None => self.float(*x, &mut out),
                    }
                }
                match self.step {
                    Some(_) => self.word(*fourth as u16, &mut out),
                    None => self.float(f32::from(*fourth), &mut out),
                }
            }
            for _ in 0..self.analog {
                match self.step {
                    Some(_) => self.word(0x1234, &mut out),
                    None => self.float(1234.5, &mut out),
                }
            }
        }
        let rest = self.tail.unwrap_or(out.len().next_multiple_of(512) - out.len());
        out.resize(out.len() + rest, 0);
        out
    }

    fn first_block(&self, data_block: u16) -> Vec<u8> {
        let header = &self.header;
        let mut out = vec![2, 0x50];
        let count = self.frames.len() as u16;
        let (first, last) = header.frames.unwrap_or((1, count));
        let points = self.frames.first().map_or(0, Vec::len) as u16;
        for word in
            [header.points.unwrap_or(points), header.analog.unwrap_or(self.analog as u16), first, last, 0]
        {
            self.word(word, &mut out);
        }
        self.float(header.scale.unwrap_or(self.step.unwrap_or(-1.0)), &mut out);
        self.word(header.data_block.unwrap_or(data_block), &mut out);
        self.word(u16::from(self.analog > 0), &mut out);
        self.float(header.rate.unwrap_or(0.0), &mut out);
        out.resize(512, 0);
        out
    }

    fn section(&self, data_block: u16) -> Vec<u8> {
        let mut groups: Vec<&str> = self.parameters.iter().map(|(group, _, _)| *group).collect();
        groups.dedup();
        groups.sort_unstable();
        groups.dedup();
        let mut out = vec![1, 0x50, 0, self.processor];
        for (i, group) in groups.iter().enumerate() {
            let body = if self.descriptions { vec![4, b't', b'e', b's', b't'] } else { Vec::new() };
            self.entry(-(i as i8) - 1, group, &body, false, &mut out);
        }
        for (i, (group, name, value)) in self.parameters.iter().enumerate() {
            let id = groups.iter().position(|g| g == group).unwrap() as i8 + 1;
            let is_place = *name == "DATA_START" && matches!(value, Value::Words(words) if words == &[0]);
            let value = if is_place { Value::Words(vec![data_block]) } else { value.clone() };
            let mut body = self.value(&value);
            if self.descriptions {
                body.extend([5, b'w', b'o', b'r', b'd', b's']);
            }
            self.entry(id, name, &body, i + 1 == self.parameters.len(), &mut out);
        }
        out.resize(out.len().next_multiple_of(512), 0);
        out[2] = self.header.parameter_blocks.unwrap_or((out.len() / 512) as u8);
        out
    }

    fn entry(&self, id: i8, name: &str, body: &[u8], is_last: bool, out: &mut Vec<u8>) {
        out.extend([name.len() as u8, id as u8]);
        out.extend(name.as_bytes());
        self.word(if is_last { 0 } else { 2 + body.len() as u16 }, out);
        out.extend(body);
    }

    fn value(&self, value: &Value) -> Vec<u8> {
        let mut out = Vec::new();
        match value {
            Value::Words(words) => {
                out.extend([2, u8::from(words.len() > 1)]);
                out.extend((words.len() > 1).then_some(words.len() as u8));
                words.iter().for_each(|word| self.word(*word, &mut out));
            }
            Value::Floats(floats) => {
                out.extend([4, 0]);
                floats.iter().for_each(|float| self.float(*float, &mut out));
            }
            Value::FloatPairs(pairs) => {
                out.extend([4, 2, 2, pairs.len() as u8]);
                pairs.as_flattened().iter().for_each(|float| self.float(*float, &mut out));
            }
            Value::Texts(texts) => {
                let longest = texts.iter().map(String::len).max().unwrap_or(0);
                out.extend([0xFF, 2, longest as u8, texts.len() as u8]);
                texts.iter().for_each(|text| out.extend(format!("{text:longest$}").bytes()));
            }
        }
        out
    }

    fn word(&self, word: u16, out: &mut Vec<u8>) {
        out.extend(if self.processor == 86 { word.to_be_bytes() } else { word.to_le_bytes() });
    }

    fn float(&self, float: f32, out: &mut Vec<u8>) {
        match self.processor {
            86 => out.extend(float.to_be_bytes()),
            // A VAX float is the IEEE float of four times the value with its words swapped.
            85 => {
                let [a, b, c, d] = (float * 4.0).to_le_bytes();
                out.extend([c, d, a, b]);
            }
            _ => out.extend(float.to_le_bytes()),
        }
    }
}

/// A made-up trial: all coordinates are multiples of 1/16 within ±2000; the second marker is missing from the
/// fourth frame and filled in the fifth.
pub(super) fn trial(points: usize, frames: usize) -> C3d {
    let position = |i: usize, j: usize| {
        let (i, j) = (i as f32, j as f32);
        [-700.0 + 3.0 * j + i / 16.0, 12.5 * j - i / 4.0, 1500.0 - j + ((i * 7.0) % 64.0) / 16.0]
    };
    let point = |i: usize, j: usize| match (i, j) {
        (3, 1) => ([0.0; 3], -1),
        (4, 1) => (position(i, j), 0),
        _ => (position(i, j), 0x0300 + 7),
    };
    C3d::new(120.0, (0..frames).map(|i| (0..points).map(|j| point(i, j)).collect()).collect())
}
