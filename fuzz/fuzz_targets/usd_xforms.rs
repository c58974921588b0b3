//! A sound animation as USD text in which any stack of transforms is added to a prim. `verify` finds every
//! stack: each could move the face. Without one, the file is as its export wrote it.
#![no_main]
use libfuzzer_sys::arbitrary::{self, Arbitrary};
use libfuzzer_sys::fuzz_target;
use rhytid_core::{Error, Faces, RigidMotion, UpAxis};
use rhytid_formats::export::{Frame, Options, Scene, StatedRecipe};
use rhytid_formats::{animation, usd};
use std::sync::OnceLock;

#[derive(Debug, Arbitrary)]
struct Stack {
    has_head: bool,
    is_on_mesh: bool,
    operations: Vec<Operation>,
    order: Option<Vec<(u8, bool)>>,
    resets: bool,
}

#[derive(Debug, Arbitrary)]
struct Operation {
    kind: u8,
    suffix: Option<u8>,
    numbers: [f32; 4],
    is_sampled: bool,
    is_uniform: bool,
}

const KINDS: [(&str, &str, usize); 9] = [
    ("double3", "translate", 3),
    ("float3", "scale", 3),
    ("float3", "rotateXYZ", 3),
    ("float3", "rotateZYX", 3),
    ("double", "rotateX", 1),
    ("quatf", "orient", 4),
    ("matrix4d", "transform", 16),
    ("double3", "pivot", 3),
    ("token", "unknown", 1),
];

impl Operation {
    fn name(&self) -> String {
        let (_, kind, _) = KINDS[usize::from(self.kind) % KINDS.len()];
        match self.suffix {
            Some(suffix) => format!("xformOp:{kind}:s{suffix}"),
            None => format!("xformOp:{kind}"),
        }
    }

    fn statement(&self) -> String {
        let (type_name, _, width) = KINDS[usize::from(self.kind) % KINDS.len()];
        let number = |i: usize| match self.numbers[i % 4] {
            x if x.is_finite() => x.to_string(),
            x => x.to_string().to_lowercase(),
        };
        let list =
            |from: usize, count: usize| (from..from + count).map(number).collect::<Vec<_>>().join(", ");
        let value = match width {
            1 if type_name == "token" => "\"x\"".to_owned(),
            1 => number(0),
            16 => format!("( ({}), ({}), ({}), ({}) )", list(0, 4), list(1, 4), list(2, 4), list(3, 4)),
            _ => format!("({})", list(0, width)),
        };
        let uniform = if self.is_uniform && !self.is_sampled { "uniform " } else { "" };
        match self.is_sampled {
            true => format!("{type_name} {}.timeSamples = {{ 0: {value}, 1: {value}, }}\n", self.name()),
            false => format!("{uniform}{type_name} {} = {value}\n", self.name()),
        }
    }
}

impl Stack {
    /// The statements, and none if there is nothing in the stack.
    fn statements(&self) -> String {
        let mut text: String = self.operations.iter().map(Operation::statement).collect();
        if let Some(order) = &self.order {
            let mut names = Vec::new();
            names.extend(self.resets.then(|| "\"!resetXformStack!\"".to_owned()));
            for (chosen, is_inverted) in order {
                let name = match self.operations.get(usize::from(*chosen)) {
                    Some(operation) => operation.name(),
                    None => "xformOp:transform".to_owned(),
                };
                names.push(format!("\"{}{name}\"", if *is_inverted { "!invert!" } else { "" }));
            }
            text += &format!("uniform token[] xformOpOrder = [{}]\n", names.join(", "));
        }
        text
    }
}

fuzz_target!(|stack: Stack| {
    static TEXTS: OnceLock<[String; 2]> = OnceLock::new();
    let texts = TEXTS.get_or_init(|| [false, true].map(exported));
    let text = &texts[usize::from(stack.has_head)];
    let statements = stack.statements();
    // What comes last counts.
    let brace = if stack.is_on_mesh { "\n    }\n" } else { "\n}\n" };
    let at = text.rfind(brace).expect("a prim") + 1;
    let changed = format!("{}{statements}{}", &text[..at], &text[at..]);
    let mut reader = match usd::read::decode_animation(changed.into_bytes(), "fuzz") {
        Ok(reader) => reader,
        Err(Error::Input(sentence)) => return assert!(!statements.is_empty(), "{sentence}"),
        Err(other) => panic!("expected an input error, found {other:?}"),
    };
    let found = with_scene(stack.has_head, |scene| reader.compare(scene)).expect("a layer is compared");
    let rests = (0..2).all(|frame| match reader.head(frame) {
        Ok(head) => head.is_none_or(|head| head == RigidMotion::IDENTITY.matrix()),
        Err(_) => false,
    });
    assert_eq!(found.is_empty() && rests, statements.is_empty(), "{found:?}\n{statements}");
});

const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

fn with_scene<T>(has_head: bool, act: impl FnOnce(&Scene<'_>) -> T) -> T {
    let faces = Faces { counts: vec![4], indices: vec![0, 1, 2, 3] };
    let heads = [RigidMotion::IDENTITY; 2];
    act(&Scene {
        name: "square",
        rest: &SQUARE,
        rest_normals: None,
        channels: &[],
        faces: &faces,
        triangle_corners: &[[0, 1, 2], [0, 2, 3]],
        uvs: None,
        materials: None,
        head: has_head.then_some(&heads),
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        frames: 2,
        rate: 24.0,
        first_time_code: 0.0,
        recipe: &StatedRecipe::default(),
    })
}

fn exported(has_head: bool) -> String {
    let path = std::env::temp_dir().join(format!("rhytid-fuzz-{}-{has_head}.usda", std::process::id()));
    with_scene(has_head, |scene| {
        let mut exporter = animation::create(&path, scene, &Options::default()).unwrap();
        for _ in 0..scene.frames {
            exporter.frame(&Frame::new(SQUARE.as_flattened())).unwrap();
        }
        exporter.finish(&rhytid_core::NoProgress).unwrap();
    });
    std::fs::read_to_string(&path).unwrap()
}
