//! The project file: what its text means, and that it survives being written.
use proptest::prelude::*;
use rhytid_core::{Bind, ContactSettings, Error, Reach, UpAxis, WrinkleStrains};
use rhytid_formats::mesh::NormalMapConvention;
use rhytid_formats::project::{
    Edges, ExampleSection, FineScaleSection, HandlesSection, LargeScaleSection, LearnedSection, MeshSection,
    Method, PinsSection, PriorSection, Project, StrainSection, Units, parse, read, write,
};
use std::path::PathBuf;

/// Every key, each with a value that is not its default where there is another.
const FULL: &str = r#"
method = "chapter"
align = false
[mesh]
name = "Ada"
neutral = "neutral.obj"        # paths are relative to this file
units = "cm"
up = "z"
weld = true
textures = false
[handles]
vertices = "markers.csv"
[[example]]
name = "frown"
mesh = "poses/frown.obj"
unit = "mm"
scale = 1.25
axes = "+x-z+y"
noise = 0.15
normal_map = "frown.png"
green = "down"
strength = 0.5
[[example]]
name = "smile"
mesh = "poses/smile.ply"
mirror = true
take = "ada.csv"
frame = 120
displacement = "smile.png"
millimetres = 1.5
[[example]]
name = "blink"
mesh = "head.usd"
prim = "/head/face"
time = 12.5
shape = ["blink_l", "blink_r"]
weight = -0.5
[[example]]
mesh = "head.glb"
shapes = "*"
weight = 0.75
[[example]]
mesh = "poses/scan.####.obj"
[pins]
auto = false
vertices = "skull.csv"
box = [[9, 20, -2], [-9.0, 5.5, -12]]
groups = ["skull", "ears"]
[contact]
eyes = false
[large_scale]
bending_length = 3.0
bind = "nearest"
[strain]
edges = "edges.csv"
[fine_scale]
max_influences = 8
[prior]
from = "generic"
neutral = "generic/rest.obj"
weight = 0.25
[learned]
share = 0.5
ridge = 1e-3
wrinkle_ridge = 0.01
reach = inf
fade = false
wrinkle_strains = "lengths"
marker_noise = 0
"#;

const SMALLEST: &str = "[mesh]\nneutral = 'n.obj'\nunits = 'm'\n[handles]\nvertices = 'h.csv'\n";

fn full() -> Project {
    let example = |name: &str, mesh: &str| ExampleSection {
        name: Some(name.into()),
        mesh: mesh.into(),
        prim: (name == "blink").then(|| "/head/face".into()),
        time: (name == "blink").then_some(12.5),
        shape: if name == "blink" { vec!["blink_l".into(), "blink_r".into()] } else { Vec::new() },
        shapes: Vec::new(),
        weight: (name == "blink").then_some(-0.5),
        unit: (name == "frown").then_some(Units::Millimetres),
        scale: (name == "frown").then_some(1.25),
        axes: (name == "frown").then(|| "+x-z+y".parse().unwrap()),
        mirror: name == "smile",
        noise: (name == "frown").then_some(0.15),
        take: (name == "smile").then(|| "ada.csv".into()),
        frame: (name == "smile").then_some(120),
        displacement: (name == "smile").then(|| "smile.png".into()),
        millimetres: (name == "smile").then_some(1.5),
        normal_map: (name == "frown").then(|| "frown.png".into()),
        green: (name == "frown").then_some(NormalMapConvention::Down),
        strength: (name == "frown").then_some(0.5),
    };
    Project {
        method: Method::Chapter,
        align: false,
        mesh: MeshSection {
            name: Some("Ada".into()),
            neutral: "neutral.obj".into(),
            prim: None,
            units: Some(Units::Centimetres),
            up: Some(UpAxis::Z),
            weld: Some(true),
            textures: Some(false),
        },
        handles: HandlesSection { vertices: "markers.csv".into() },
        examples: vec![
            example("frown", "poses/frown.obj"),
            example("smile", "poses/smile.ply"),
            example("blink", "head.usd"),
            ExampleSection {
                mesh: "head.glb".into(),
                shapes: vec!["*".into()],
                weight: Some(0.75),
                ..ExampleSection::default()
            },
            ExampleSection { mesh: "poses/scan.####.obj".into(), ..ExampleSection::default() },
        ],
        prior: Some(PriorSection {
            from: "generic".into(),
            neutral: Some("generic/rest.obj".into()),
            landmarks: None,
            weight: Some(0.25),
        }),
        pins: PinsSection {
            auto: Some(false),
            vertices: Some("skull.csv".into()),
            bounds: Some([[-9.0, 5.5, -12.0], [9.0, 20.0, -2.0]]),
            groups: vec!["skull".into(), "ears".into()],
        },
        contact: ContactSettings { eyes: false, openings: true },
        large_scale: LargeScaleSection { bending_length: Some(3.0), bind: Bind::Nearest, rotations: false },
        strain: StrainSection { edges: Edges::File("edges.csv".into()) },
        fine_scale: FineScaleSection { max_influences: 8 },
        learned: LearnedSection {
            share: Some(0.5),
            ridge: Some(1e-3),
            wrinkle_ridge: Some(0.01),
            marker_noise: Some(0.0),
            reach: Some(f64::INFINITY),
            fade: Some(false),
            wrinkle_strains: Some(WrinkleStrains::Lengths),
        },
    }
}

#[test]
fn every_key_is_understood() {
    assert_eq!(parse(FULL, "face.toml").unwrap(), full());
    assert_eq!(parse(&format!("\u{feff}{}", FULL.replace('\n', "\r\n")), "face.toml").unwrap(), full());
}

#[test]
fn the_method_is_understood_where_it_once_was() {
    let with =
        |above: &str, below: &str| parse(&format!("{above}\n{SMALLEST}[fine_scale]\n{below}\n"), "face.toml");
    let (learned, chapter) = ("method = 'learned'", "method = 'chapter'");
    assert_eq!(with("", chapter).unwrap().method, Method::Chapter);
    assert_eq!(with("", learned).unwrap().method, Method::Learned);
    assert_eq!(with(chapter, chapter).unwrap().method, Method::Chapter);
    let Err(Error::Input(found)) = with(learned, chapter) else { panic!("two methods at once") };
    assert!(
        found.sentence().contains("line 8: [fine_scale] method is \"chapter\", expected the one at the top"),
        "{found}"
    );
    let Err(Error::Input(found)) = with("method = 'book'", "") else { panic!("no such method") };
    assert!(found.sentence().contains("method is \"book\", expected \"learned\" or \"chapter\""), "{found}");
}

/// Keys by their former names mean the same, and no file has a key by both.
#[test]
fn the_former_names_of_keys_are_understood() {
    let before = FULL.replace("wrinkle_ridge", "fold_ridge").replace("wrinkle_strains", "fold_strains");
    assert_eq!(parse(&before, "x.toml").unwrap(), full());
    let wrong = before.replace("\"lengths\"", "\"world\"");
    let Err(Error::Input(found)) = parse(&wrong, "x.toml") else { panic!("no such strains") };
    assert!(found.sentence().contains("[learned] fold_strains is \"world\""), "{found}");
    let both = FULL.replace("wrinkle_ridge = 0.01", "wrinkle_ridge = 0.01\nfold_ridge = 0.01");
    let Err(Error::Input(found)) = parse(&both, "x.toml") else { panic!("one key by both names") };
    let words = "line 66: fold_ridge is the former name of wrinkle_ridge, which [learned] has, too";
    assert!(found.sentence().contains(words), "{found}");
}

#[test]
fn inline_tables_are_sections_too() {
    let text = "mesh = {neutral = 'n.obj', units = 'm'}\nhandles.vertices = 'h.csv'\n\
                example = [{name = 'a', mesh = 'a.obj'}]\n";
    assert_eq!(parse(text, "face.toml").unwrap().examples[0].name.as_deref(), Some("a"));
}

#[test]
fn what_is_left_out_has_its_default() {
    let project = parse(SMALLEST, "face.toml").unwrap();
    assert_eq!(
        project,
        Project {
            method: Method::Learned,
            align: true,
            mesh: MeshSection {
                name: None,
                neutral: "n.obj".into(),
                prim: None,
                units: Some(Units::Metres),
                up: None,
                weld: None,
                textures: None,
            },
            handles: HandlesSection { vertices: "h.csv".into() },
            examples: vec![],
            prior: None,
            pins: PinsSection::default(),
            contact: ContactSettings { eyes: true, openings: true },
            large_scale: LargeScaleSection { bending_length: None, bind: Bind::Auto, rotations: false },
            strain: StrainSection { edges: Edges::Auto },
            fine_scale: FineScaleSection { max_influences: 16 },
            learned: LearnedSection::default(),
        }
    );
    let empty_sections = format!("{SMALLEST}[large_scale]\n[strain]\n[fine_scale]\n");
    assert_eq!(parse(&empty_sections, "face.toml").unwrap(), project);
}

#[test]
fn units_and_axes_are_understood() {
    for (units, metres) in
        [("'m'", 1.0), ("'cm'", 0.01), ("'mm'", 0.001), ("'in'", 0.0254), ("2", 2.0), ("0.3048", 0.3048)]
    {
        let project = parse(&SMALLEST.replace("'m'", units), "face.toml").unwrap();
        assert_eq!(project.mesh.units.unwrap().metres_per_unit(), metres, "{units}");
    }
    for (up, axis) in [("y", UpAxis::Y), ("Y", UpAxis::Y), ("z", UpAxis::Z), ("Z", UpAxis::Z)] {
        let text = SMALLEST.replace("units", &format!("up = '{up}'\nunits"));
        assert_eq!(parse(&text, "face.toml").unwrap().mesh.up, Some(axis));
    }
}

#[test]
fn vertices_are_joined_for_gltf_alone_unless_the_project_says_otherwise() {
    for (neutral, weld, joins) in [
        ("n.obj", "", false),
        ("n.ply", "", false),
        ("n.glb", "", true),
        ("n.GLTF", "", true),
        ("n.obj", "weld = true\n", true),
        ("n.glb", "weld = false\n", false),
    ] {
        let text = SMALLEST.replace("n.obj", neutral).replace("units", &format!("{weld}units"));
        assert_eq!(parse(&text, "face.toml").unwrap().mesh.welds(), joins, "{neutral} {weld}");
    }
}

#[test]
fn what_is_written_can_be_read_by_people() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.toml");
    write(&path, &full()).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    for line in ["[mesh]", "units = \"cm\"", "[[example]]", "bending_length = 3.0", "edges = \"edges.csv\""] {
        assert!(text.lines().any(|l| l == line), "{line} in\n{text}");
    }
}

#[test]
fn projects_that_would_not_read_back_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.toml");
    let change = |edit: fn(&mut Project)| {
        let mut project = full();
        edit(&mut project);
        project
    };
    for (bad, words) in [
        (change(|p| p.examples[1].name = Some("frown".into())), "[[example]] name is \"frown\""),
        (change(|p| p.large_scale.bending_length = Some(f64::NAN)), "bending_length is nan"),
        (change(|p| p.mesh.units = Some(Units::MetresPerUnit(-1.0))), "units is -1.0"),
        (change(|p| p.mesh.neutral = PathBuf::new()), "neutral is empty"),
        (change(|p| p.fine_scale.max_influences = 0), "max_influences is 0"),
        (change(|p| p.learned.share = Some(1.5)), "[learned] share is 1.5, expected a number from 0 to 1"),
        (change(|p| p.learned.ridge = Some(0.0)), "[learned] ridge is 0.0, expected a number above 0"),
        (change(|p| p.learned.wrinkle_ridge = Some(-1.0)), "[learned] wrinkle_ridge is -1.0"),
        (change(|p| p.learned.marker_noise = Some(f64::INFINITY)), "[learned] marker_noise is inf"),
        (
            change(|p| p.learned.reach = Some(0.5)),
            "[learned] reach is 0.5, expected a number from 1, inf for no bound",
        ),
        (change(|p| p.learned.reach = Some(f64::NAN)), "[learned] reach is nan"),
        (
            change(|p| p.prior = Some(PriorSection { weight: Some(1.5), ..prior("generic") })),
            "[prior] weight is 1.5, expected \"auto\" or a number from 0 to 1",
        ),
        (
            change(|p| {
                p.prior = Some(PriorSection { neutral: Some("n.obj".into()), ..prior("a.safetensors") });
            }),
            "[prior] has neutral, which is of use only where from is a folder",
        ),
        (
            change(|p| p.prior = Some(PriorSection { neutral: Some("n.obj".into()), ..prior("a.glb") })),
            "[prior] has neutral, which is of use only where from is a folder",
        ),
        (
            change(|p| p.prior = Some(PriorSection { landmarks: Some("l.csv".into()), ..prior("generic") })),
            "[prior] has landmarks, which is of use only where from is a rig",
        ),
    ] {
        let Err(Error::Input(found)) = write(&path, &bad) else { panic!("{bad:?} was written") };
        assert!(found.sentence().contains("not written") && found.sentence().contains(words), "{found}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

fn prior(from: &str) -> PriorSection {
    PriorSection { from: from.into(), ..PriorSection::default() }
}

#[test]
fn a_prior_that_is_a_rig_is_not_read_without_a_transfer() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.toml");
    std::fs::write(&path, format!("{SMALLEST}[prior]\nfrom = 'other.safetensors'\n")).unwrap();
    let text = read(&path, Reach::Below).unwrap_err().to_string();
    assert!(text.contains("other.safetensors, which does not exist"), "{text}");
    std::fs::write(folder.path().join("other.safetensors"), "").unwrap();
    let text = read(&path, Reach::Below).unwrap_err().to_string();
    assert!(text.contains("rhytid_transfer::read_face"), "{text}");
    let Err(error) = parse(&format!("{SMALLEST}[prior]\nweight = 'auto'\n"), "face.toml") else { panic!() };
    assert!(error.to_string().contains("[prior] lacks the key from"), "{error}");
}

fn any_project() -> impl Strategy<Value = Project> {
    let path = || "[a-zé .\"'#\\\\/]{0,12}[a-z]".prop_map(PathBuf::from);
    let units = prop_oneof![
        Just(Units::Metres),
        Just(Units::Centimetres),
        Just(Units::Millimetres),
        Just(Units::Inches),
        (1e-6..1e6).prop_map(Units::MetresPerUnit),
    ];
    let mesh = (proptest::option::of(".{0,8}[a-z]"), path(), units, any::<bool>());
    let examples = proptest::collection::btree_map(".{0,8}[a-z]", path(), 0..4);
    let choices =
        (proptest::option::of(1e-9..1e6), any::<bool>(), proptest::option::of(path()), 1..1000_usize);
    (mesh, path(), examples, choices).prop_map(|(mesh, vertices, examples, choices)| Project {
        method: if choices.1 { Method::Learned } else { Method::Chapter },
        align: choices.1,
        mesh: MeshSection {
            name: mesh.0,
            neutral: mesh.1,
            prim: None,
            units: Some(mesh.2),
            up: Some(if mesh.3 { UpAxis::Z } else { UpAxis::Y }),
            weld: mesh.3.then_some(choices.1),
            textures: choices.1.then_some(mesh.3),
        },
        handles: HandlesSection { vertices },
        examples: examples
            .into_iter()
            .map(|(name, mesh)| ExampleSection {
                mirror: name.len() > 4,
                frame: (name.len() > 6).then_some(name.len()),
                take: (name.len() > 6).then(|| PathBuf::from("take.csv")),
                name: Some(name),
                mesh,
                ..ExampleSection::default()
            })
            .collect(),
        prior: None,
        pins: PinsSection { auto: choices.0.map(|x| x > 1.0), ..PinsSection::default() },
        contact: ContactSettings { eyes: choices.1, openings: choices.0.is_some() },
        large_scale: LargeScaleSection {
            bending_length: choices.0,
            bind: if choices.1 { Bind::Nearest } else { Bind::Rigid },
            rotations: choices.1,
        },
        strain: StrainSection {
            edges: choices.2.filter(|path| path.as_os_str() != "auto").map_or(Edges::Auto, Edges::File),
        },
        fine_scale: FineScaleSection { max_influences: choices.3 },
        learned: LearnedSection { ridge: choices.0, ..LearnedSection::default() },
    })
}

proptest! {
    #[test]
    fn projects_survive_writing_and_parsing(project in any_project()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("face.toml");
        write(&path, &project).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        prop_assert_eq!(parse(&text, "face.toml").unwrap(), project);
    }

    #[test]
    fn any_text_is_a_project_or_a_named_error(
        text in prop_oneof![
            any::<String>(),
            proptest::collection::vec(
                proptest::sample::select(vec![
                    "[mesh]\n", "[handles]\n", "[[example]]\n", "[example]\n", "neutral = ", "units = ", "'cm'",
                    "vertices = ", "name = ", "'a'", "'b.obj'", "\n", "1", "-0.5", "true", "{", "}", "[", "]",
                    "bending_length = ", "max_influences = ", "a.b = ", "0x", "_", "1979-05-27", "\u{feff}", "é",
                ]),
                0..30,
            ).prop_map(|pieces| pieces.concat()),
        ],
    ) {
        if let Err(error) = parse(&text, "f.toml") {
            prop_assert!(error.to_string().starts_with("f.toml"), "{}", error);
        }
    }

    #[test]
    fn one_changed_byte_is_a_project_or_a_named_error(at in 0..FULL.len(), byte in 0..128_u8) {
        let mut text = FULL.as_bytes().to_vec();
        text[at] = byte;
        let text = String::from_utf8(text).unwrap();
        if let Err(error) = parse(&text, "f.toml") {
            prop_assert!(error.to_string().starts_with("f.toml, line ") || error.to_string().contains("has no section"),
                "{}", error);
        }
    }
}
