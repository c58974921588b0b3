//! Layers of every kind of value, made at random, as text and binary: USD must find them the same.
use super::common::{python, python_usd_24_3, root, run};
use crate::animation::Random;
use rhytid_formats::usd::layer::{
    Attribute, Fields, Layer, Prim, Property, Reference, Relationship, Specifier, Value,
};
use rhytid_formats::usd::write::{Encoding, LayerWriter, Sample};
use std::path::Path;
use std::process::Command;

/// Lengths around the limits at which arrays are compressed.
const LENGTHS: [u64; 8] = [0, 1, 3, 15, 16, 17, 100, 3000];

const TEXTS: [&str; 8] =
    ["", "plain", "\"quoted\"", "back\\slash", "two\nlines\tand\ra tab", "Zoë 鼻", "'", "\u{7}\u{1b}"];

impl Random {
    fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len() as u64) as usize]
    }

    fn list<T>(&mut self, mut item: impl FnMut(&mut Self) -> T) -> Vec<T> {
        let length = *self.pick(&LENGTHS);
        (0..length).map(|_| item(self)).collect()
    }

    fn text(&mut self) -> String {
        format!("{}{}", self.pick(&TEXTS), self.below(50))
    }

    fn double(&mut self) -> f64 {
        match self.below(4) {
            0 => f64::from(self.finite()),
            1 => self.below(100) as f64 - 50.0,
            2 => *self.pick(&[-0.0, 0.1, f64::MAX, f64::MIN_POSITIVE, 5e-324, f64::INFINITY, -f64::INFINITY]),
            _ => self.bits() as f64 / 3.0,
        }
    }

    /// Often short enough to stand for itself, or nearly.
    fn matrix(&mut self) -> [[f64; 4]; 4] {
        let mut rows = [[0.0; 4]; 4];
        for (i, row) in rows.iter_mut().enumerate() {
            row[i] = self.below(260) as f64 - 130.0;
        }
        if self.below(2) == 0 {
            rows[self.below(4) as usize][self.below(4) as usize] = self.double();
        }
        rows
    }

    /// Differences of every width, at the limits of each, in runs and mixed.
    fn integers(&mut self) -> Vec<i32> {
        const STEPS: [i32; 12] = [0, 1, -1, 127, 128, -128, -129, 32767, 32768, -32768, -32769, i32::MIN];
        let choices: Vec<i32> = (0..1 + self.below(4)).map(|_| *self.pick(&STEPS)).collect();
        let mut x = self.bits() as i32;
        let wild = self.below(4) == 0;
        self.list(|random| {
            x = if wild { random.bits() as i32 } else { x.wrapping_add(*random.pick(&choices)) };
            x
        })
    }

    /// Whole numbers, few different ones, or many.
    fn floats(&mut self) -> Vec<f32> {
        let kind = self.below(5);
        let few: Vec<f32> = (0..1 + self.below(6)).map(|_| self.finite()).collect();
        self.list(|random| match kind {
            0 => random.below(2000) as f32 - 1000.0,
            1 => *random.pick(&few),
            2 => *random.pick(&[0.0, -0.0, 1.0]),
            3 => *random.pick(&[f32::INFINITY, 2_147_483_648.0, -2_147_483_648.0, 3.0]),
            _ => random.finite(),
        })
    }

    fn value(&mut self, depth: u32) -> Value {
        match self.below(if depth == 0 { 18 } else { 19 }) {
            0 => Value::Bool(self.below(2) == 0),
            1 => Value::Int(self.bits() as i32),
            2 => Value::Float(self.finite()),
            3 => Value::Double(self.double()),
            4 => Value::String(self.text()),
            5 => Value::Token(self.text()),
            6 => Value::Asset(format!("./a{}@b.usd", self.below(9))),
            7 => Value::Matrix4d(self.matrix()),
            8 => Value::Tokens(self.list(Self::text)),
            9 => Value::Assets(self.list(|random| format!("c{}.usd", random.below(9)))),
            10 => Value::Ints(self.integers()),
            11 => Value::Floats(self.floats()),
            12 => Value::Float2s(self.list(|random| [random.finite(), random.finite()])),
            13 => Value::Float3s(self.list(|random| std::array::from_fn(|_| random.finite()))),
            14 => Value::Double2s(self.list(|random| [random.double(), random.double()])),
            15 => Value::Matrix4ds(self.list(Self::matrix)),
            16 => Value::Float4(std::array::from_fn(|_| self.finite())),
            17 => Value::Float4s(self.list(|random| std::array::from_fn(|_| random.finite()))),
            _ => Value::Dictionary(self.dictionary(depth - 1)),
        }
    }

    fn dictionary(&mut self, depth: u32) -> Fields {
        (0..self.below(5)).map(|i| (format!("key {i}"), self.value(depth))).collect()
    }
}

/// A layer, and the numbers of the attributes that have samples: vectors are even, matrices odd.
fn layer(random: &mut Random) -> (Layer, usize) {
    let mut sampled = 0;
    let prims = (0..3).map(|i| prim(random, &format!("p{i}"), 3, &mut sampled)).collect();
    let metadata = vec![
        ("defaultPrim".into(), Value::Token("p0".into())),
        ("customLayerData".into(), Value::Dictionary(random.dictionary(2))),
        ("endTimeCode".into(), Value::Double(random.below(9) as f64 / 7.0)),
    ];
    (Layer { metadata, prims }, sampled)
}

fn prim(random: &mut Random, name: &str, depth: u32, sampled: &mut usize) -> Prim {
    let mut metadata = vec![("customData".into(), Value::Dictionary(random.dictionary(2)))];
    if random.below(2) == 0 {
        metadata.push(("kind".into(), Value::Token("component".into())));
        metadata.push(("apiSchemas".into(), Value::PrependedTokens(vec!["AAPI".into(), "BAPI".into()])));
    }
    if random.below(2) == 0 {
        let reference = |prim: &str| Reference { asset: "./other.usd".into(), prim: prim.into() };
        metadata
            .push(("references".into(), Value::PrependedReferences(vec![reference(""), reference("/x/y")])));
    }
    let mut properties: Vec<Property> = (0..random.below(6))
        .map(|i| {
            let mut value = random.value(0);
            let samples = (random.below(3) == 0).then(|| {
                *sampled += 1;
                *sampled - 1
            });
            if let Some(n) = samples {
                value = [Value::Float3s(vec![[1.0; 3]]), Value::Matrix4d(random.matrix())][n % 2].clone();
            }
            Property::Attribute(Attribute {
                name: format!("ns:a{i}"),
                type_name: value.type_name().unwrap().into(),
                uniform: samples.is_none() && random.below(2) == 0,
                metadata: if random.below(2) == 0 {
                    Vec::new()
                } else {
                    vec![("documentation".into(), Value::String(random.text()))]
                },
                default: (random.below(4) > 0).then_some(value),
                connections: (0..random.below(3)).map(|i| format!("/p{i}/q/r.ns:a{i}")).collect(),
                samples,
            })
        })
        .collect();
    for i in 0..random.below(3) {
        let targets =
            (0..=random.below(3)).map(|i| ["/p1", "/p1.ns:a0", "/elsewhere/x", "/p0/q"][i as usize].into());
        properties.push(Property::Relationship(Relationship {
            name: format!("rel{i}"),
            targets: targets.collect(),
        }));
    }
    let names = ["q", "r", "s"].into_iter().take(if depth == 0 { 0 } else { random.below(4) as usize });
    Prim {
        specifier: if random.below(3) == 0 { Specifier::Over } else { Specifier::Def },
        type_name: (*random.pick(&["", "Xform", "Mesh"])).into(),
        name: name.into(),
        metadata,
        properties,
        children: names.map(|name| prim(random, name, depth - 1, sampled)).collect(),
    }
}

fn write(path: &Path, encoding: Encoding, layer: &Layer, sampled: usize, seed: u64) {
    let mut random = Random(seed);
    let mut writer = LayerWriter::create(path, encoding, layer).unwrap();
    for time in -3..4 {
        for number in 0..sampled {
            let vectors = random.list(|random| [random.finite(); 3]);
            let matrix = random.matrix();
            // Every fifth has none at all.
            if number % 5 < 4 {
                let sample =
                    if number % 2 == 0 { Sample::Float3s(&vectors) } else { Sample::Matrix4d(&matrix) };
                writer.sample(number, f64::from(time) / 3.0, sample).unwrap();
            }
        }
    }
    let bytes = writer.finish().unwrap();
    assert_eq!(bytes, std::fs::metadata(path).unwrap().len());
}

fn check(python: &Path, seeds: std::ops::Range<u64>) {
    let folder = tempfile::tempdir().unwrap();
    for seed in seeds.clone() {
        let (layer, sampled) = layer(&mut Random(seed));
        write(&folder.path().join(format!("{seed}.usda")), Encoding::Text, &layer, sampled, seed);
        write(&folder.path().join(format!("{seed}.usdc")), Encoding::Crate, &layer, sampled, seed);
    }
    let script = root().join("crates/formats/tests/formats/export/usd_layers_check.py");
    let printed = run(Command::new(python).arg(script).arg(folder.path()));
    assert!(printed.contains(&format!("{} layers are the same", seeds.count())), "{printed}");
}

#[test]
fn text_and_binary_are_the_same_to_usd() {
    check(&python(), 0..60);
}

#[test]
fn text_and_binary_are_the_same_to_the_oldest_usd() {
    check(&python_usd_24_3(), 100..130);
}
