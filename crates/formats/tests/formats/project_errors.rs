//! What every mistake in a project file is called, and in the files it names.
use rhytid_core::{Bind, Error, HandleId, InputErrorKind, StrainEdges, UpAxis, VertexId};
use rhytid_formats::Reach;
use rhytid_formats::project::{parse, read};
use std::path::Path;

/// Lines 1 to 14.
const PROJECT: &str = "\
[mesh]
neutral = \"neutral.obj\"
units = \"cm\"

[handles]
vertices = \"markers.csv\"

[[example]]
name = \"frown\"
mesh = \"poses/frown.obj\"

[large_scale]
bending_length = 3.0

";

/// The sentence for a project in which `from` became `to`.
fn changed(from: &str, to: &str) -> String {
    assert!(PROJECT.contains(from), "{from}");
    match parse(&PROJECT.replacen(from, to, 1), "face.toml") {
        Err(Error::Input(sentence)) => sentence.to_string(),
        other => panic!("expected an input error, found {other:?}"),
    }
}

#[test]
fn unknown_keys_are_named_with_the_nearest_known_one() {
    for (from, to, expected) in [
        (
            "neutral =",
            "neutrl =",
            "face.toml, line 2: unknown key \"neutrl\" in [mesh] (did you mean \"neutral\"?), \
             expected name, neutral, prim, units, up, weld, textures",
        ),
        (
            "[handles]",
            "[handels]",
            "face.toml, line 5: unknown key \"handels\" (did you mean \"handles\"?), \
             expected method, align, mesh, handles, example, prior, pins, contact, large_scale, strain, fine_scale, learned",
        ),
        (
            "[[example]]",
            "[[examples]]",
            "face.toml, line 8: unknown key \"examples\" (did you mean \"example\"?), \
             expected method, align, mesh, handles, example, prior, pins, contact, large_scale, strain, fine_scale, learned",
        ),
        (
            "mesh = \"poses",
            "MESH = \"poses",
            "face.toml, line 10: unknown key \"MESH\" in [[example]] (did you mean \"mesh\"?), expected name, mesh, prim, time, shape, shapes, weight, unit, scale, axes, mirror, noise, take, frame, displacement, millimetres, normal_map, green, strength",
        ),
        (
            "bending_length",
            "bending-length",
            "face.toml, line 13: unknown key \"bending-length\" in [large_scale] \
             (did you mean \"bending_length\"?), expected bending_length, bind, rotations",
        ),
        ("vertices", "colour", "face.toml, line 6: unknown key \"colour\" in [handles], expected vertices"),
        (
            "[large_scale]\n",
            "[strain]\nedge = \"auto\"\n[large_scale]\n",
            "face.toml, line 13: unknown key \"edge\" in [strain] (did you mean \"edges\"?), expected edges",
        ),
        (
            "[large_scale]\n",
            "[fine_scale]\nmax_influence = 3\n[large_scale]\n",
            "face.toml, line 13: unknown key \"max_influence\" in [fine_scale] \
             (did you mean \"max_influences\"?), expected method, max_influences",
        ),
        // The first unknown key of the file is named, not the first of the alphabet.
        (
            "units = \"cm\"",
            "zeta = 1\nalpha = 2",
            "face.toml, line 3: unknown key \"zeta\" in [mesh], expected name, neutral, prim, units, up, weld, textures",
        ),
    ] {
        assert_eq!(changed(from, to), expected);
    }
}

#[test]
fn what_is_missing_is_named() {
    let units = "\"m\", \"cm\", \"mm\", \"in\" or a number above 0, the metres in one mesh unit";
    for (from, to, expected) in [
        (
            "neutral = \"neutral.obj\"\n",
            "",
            "face.toml, line 1: [mesh] lacks the key neutral, expected the file of the neutral mesh",
        ),
        ("units = \"cm\"\n", "", &format!("face.toml, line 1: [mesh] lacks the key units, expected {units}")),
        (
            "vertices = \"markers.csv\"\n",
            "",
            "face.toml, line 5: [handles] lacks the key vertices, expected a CSV file with the header label,vertex",
        ),
        (
            "[handles]\nvertices = \"markers.csv\"\n",
            "",
            "face.toml: has no section [handles], expected one with vertices",
        ),
        (
            "[mesh]\nneutral = \"neutral.obj\"\nunits = \"cm\"\n",
            "",
            "face.toml: has no section [mesh], expected one with neutral and units",
        ),
        (
            "name = \"frown\"\n",
            "",
            "face.toml, line 8: [[example]] lacks the key name, expected a name that no other example has",
        ),
        (
            "mesh = \"poses/frown.obj\"\n",
            "",
            "face.toml, line 8: [[example]] lacks the key mesh, expected the file of the example's mesh",
        ),
    ] {
        assert_eq!(changed(from, to), expected);
    }
}

#[test]
fn maps_are_one_a_mesh_and_say_how_they_are_meant() {
    for (keys, expected) in [
        (
            "green = \"up\"",
            "line 8: [[example]] has green without normal_map; name that too, or leave it out",
        ),
        (
            "normal_map = \"n.png\"\ndisplacement = \"d.png\"\nmillimetres = 1",
            "line 8: [[example]] has displacement and normal_map; leave one of them out",
        ),
        (
            "normal_map = \"n.png\"\ngreen = \"left\"",
            "line 11: [[example]] green is \"left\", expected \"up\" (OpenGL) or \"down\" (DirectX)",
        ),
        (
            "normal_map = \"n.png\"\nstrength = -1",
            "line 11: [[example]] strength is -1, expected what heights are multiplied by, a number above 0, at most 1000",
        ),
    ] {
        let said = changed("mesh = \"poses", &format!("{keys}\nmesh = \"poses"));
        assert_eq!(said, format!("face.toml, {expected}"));
    }
}

#[test]
fn wrong_values_are_named_with_what_was_found_and_expected() {
    let units = "\"m\", \"cm\", \"mm\", \"in\" or a number above 0, the metres in one mesh unit";
    for (found, shown) in [
        ("\"foot\"", "\"foot\""),
        ("\"CM\"", "\"CM\""),
        ("0", "0"),
        ("-1.5", "-1.5"),
        ("nan", "nan"),
        ("inf", "inf"),
        ("1e999", "1e999"),
        ("0x1_0000_0000_0000_0000", "0x10000000000000000"),
        ("true", "true"),
        ("[1]", "an array"),
        ("{ m = 1 }", "a section"),
        ("1979-05-27", "the date 1979-05-27"),
    ] {
        assert_eq!(
            changed("\"cm\"", found),
            format!("face.toml, line 3: [mesh] units is {shown}, expected {units}")
        );
    }
    for (found, shown) in [("1e308", "1e308"), ("1e-7", "1e-7"), ("2000000.0", "2000000.0")] {
        let said = changed("\"cm\"", found);
        let expected = format!("line 3: [mesh] units is {shown}, expected a number of metres from 0.000001");
        assert!(said.contains(&expected), "{said}");
    }
    let length = "a length in mesh units, a number above 0";
    for (from, to, expected) in [
        ("\"neutral.obj\"", "7", "line 2: [mesh] neutral is 7, expected the file of the neutral mesh"),
        ("\"neutral.obj\"", "\"\"", "line 2: [mesh] neutral is empty, expected the file of the neutral mesh"),
        ("units", "name = \" \"\nunits", "line 3: [mesh] name is \" \", expected a name that is not empty"),
        ("units", "up = \"x\"\nunits", "line 3: [mesh] up is \"x\", expected \"y\" or \"z\""),
        ("units", "up = 1\nunits", "line 3: [mesh] up is 1, expected \"y\" or \"z\""),
        ("units", "weld = \"yes\"\nunits", "line 3: [mesh] weld is \"yes\", expected true or false"),
        ("\"frown\"", "\"\"", "line 9: [[example]] name is \"\", expected a name that is not empty"),
        ("\"frown\"", "\"frown\"\nmirror = 1", "line 10: [[example]] mirror is 1, expected true or false"),
        ("\"frown\"", "3", "line 9: [[example]] name is 3, expected a name that no other example has"),
        ("3.0", "0.0", &format!("line 13: [large_scale] bending_length is 0.0, expected {length}")),
        ("3.0", "-3", &format!("line 13: [large_scale] bending_length is -3, expected {length}")),
        ("3.0", "\"3\"", &format!("line 13: [large_scale] bending_length is \"3\", expected {length}")),
        (
            "3.0",
            "3.0\nbind = \"Rigid\"",
            "line 14: [large_scale] bind is \"Rigid\", expected \"auto\", \"rigid\" or \"nearest\"",
        ),
        ("3.0", "3.0\nrotations = 1", "line 14: [large_scale] rotations is 1, expected true or false"),
        (
            "[large_scale]",
            "[strain]\nedges = 1\n[large_scale]",
            "line 13: [strain] edges is 1, expected \"auto\" or a CSV file with the header a,b",
        ),
        (
            "[large_scale]",
            "[fine_scale]\nmethod = \"rbf\"\n[large_scale]",
            "line 13: [fine_scale] method is \"rbf\", expected \"learned\" or \"chapter\"",
        ),
        (
            "[large_scale]",
            "[fine_scale]\nmax_influences = 0\n[large_scale]",
            "line 13: [fine_scale] max_influences is 0, expected a whole number from 1",
        ),
        (
            "[large_scale]",
            "[fine_scale]\nmax_influences = 16.0\n[large_scale]",
            "line 13: [fine_scale] max_influences is 16.0, expected a whole number from 1",
        ),
        (
            "[mesh]\nneutral = \"neutral.obj\"\nunits = \"cm\"",
            "mesh = \"neutral.obj\"",
            "line 1: mesh is \"neutral.obj\", expected a section [mesh]",
        ),
        ("[[example]]", "[example]", "line 8: example is a section, expected [[example]] in double brackets"),
        ("[mesh]", "example = [3]\n[mesh]", "duplicate key"),
    ] {
        let found = changed(from, to);
        assert!(found.starts_with("face.toml, line ") && found.contains(expected), "{found}");
    }
    let list = "example = [{name = 'a', mesh = 'a.obj'}, 3]\nmesh = {neutral = 'n.obj', units = 'm'}\n\
                handles = {vertices = 'h.csv'}\n";
    let Err(Error::Input(found)) = parse(list, "face.toml") else { panic!() };
    assert_eq!(
        found.sentence(),
        "face.toml, line 1: example is 3, expected [[example]] in double brackets, once for each"
    );
}

#[test]
fn names_of_examples_are_distinct() {
    let second = "[[example]]\nname = \"frown\"\nmesh = \"b.obj\"\n[large_scale]";
    assert_eq!(
        changed("[large_scale]", second),
        "face.toml, line 13: [[example]] name is \"frown\", expected a name that no other example has, but line 9 has it too"
    );
}

#[test]
fn what_is_not_toml_is_named_by_line() {
    let found = changed("units = \"cm\"", "units = cm");
    assert!(found.starts_with("face.toml, line 3: not TOML: "), "{found}");
    let found = changed("units =", "neutral =");
    assert!(found.starts_with("face.toml, line 3: not TOML: duplicate key"), "{found}");
    let found = changed("[handles]", "[handles");
    assert!(found.starts_with("face.toml, line 5: not TOML: ") && !found.contains('\n'), "{found}");
    let deep = format!("a = {}", "[".repeat(100_000));
    assert!(parse(&deep, "face.toml").unwrap_err().to_string().starts_with("face.toml, line 1: not TOML: "));
}

const NEUTRAL: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

/// A folder with a whole small project in it.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("poses")).unwrap();
    for (file, text) in [
        ("face.toml", PROJECT),
        ("neutral.obj", NEUTRAL),
        ("markers.csv", "label,vertex\na,0\nb,2\n"),
        ("poses/frown.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nf 1 2 3 4\n"),
    ] {
        std::fs::write(folder.path().join(file), text).unwrap();
    }
    folder
}

fn reading(folder: &Path) -> String {
    match read(&folder.join("face.toml"), Reach::Below) {
        Err(Error::Input(sentence)) => sentence.to_string(),
        other => panic!("expected an input error, found {other:?}"),
    }
}

#[test]
fn programs_learn_what_is_wrong_of_a_project() {
    let kind = |from: &str, to: &str| {
        let text = PROJECT.replacen(from, to, 1);
        assert_ne!(text, PROJECT);
        parse(&text, "face.toml").unwrap_err().input_kind().unwrap().clone()
    };
    let key = |key: &str| key.to_owned();
    assert_eq!(kind("units", "unit"), InputErrorKind::UnknownKey { key: key("unit") });
    assert_eq!(kind("\"cm\"", "\"parsec\""), InputErrorKind::UnknownUnit { found: "parsec".into() });
    assert_eq!(
        kind("bending_length = 3.0", "bending_length = -1"),
        InputErrorKind::WrongValue { key: key("bending_length") }
    );
    assert_eq!(kind("name = \"frown\"\n", ""), InputErrorKind::MissingKey { key: key("name") });
    assert!(matches!(kind("[large_scale]", "[large_scale"), InputErrorKind::Malformed { line: Some(_) }));

    let folder = folder();
    let kind = |from: &str, to: &str| {
        std::fs::write(folder.path().join("face.toml"), PROJECT.replacen(from, to, 1)).unwrap();
        read(&folder.path().join("face.toml"), Reach::Below).unwrap_err().input_kind().unwrap().clone()
    };
    let outside = "../frown.obj";
    assert_eq!(kind("poses/frown.obj", outside), InputErrorKind::OutsideFolder { file: outside.into() });
    let file = folder.path().join("poses/smile.obj");
    assert_eq!(kind("poses/frown.obj", "poses/smile.obj"), InputErrorKind::NotThere { file });
    std::fs::write(folder.path().join("poses/frown.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n").unwrap();
    assert_eq!(kind("", ""), InputErrorKind::Mismatch);
}

#[test]
fn a_whole_project_becomes_a_face() {
    let folder = folder();
    let face = read(&folder.path().join("face.toml"), Reach::Below).unwrap();
    assert_eq!((face.name.as_str(), face.metres_per_unit, face.up_axis), ("face", 0.01, UpAxis::Y));
    assert_eq!((face.neutral.positions.len(), face.neutral.positions[2]), (4, [1.0, 1.0, 0.0]));
    assert_eq!(
        (face.handles.labels, face.handles.points),
        (vec!["a".into(), "b".into()], [0, 2].map(|v| VertexId(v).into()).to_vec())
    );
    assert_eq!((face.examples.len(), face.examples[0].name.as_str()), (1, "frown"));
    assert_eq!(face.examples[0].positions[2], [1.0, 1.0, 0.5]);
    assert_eq!(face.settings.bending_length, Some(3.0));
    assert_eq!((face.settings.bind, face.settings.max_influences), (Bind::Auto, 16));
    assert_eq!(face.settings.strain_edges, StrainEdges::Auto);
}

#[test]
fn choices_arrive_in_the_face() {
    let folder = folder();
    std::fs::write(folder.path().join("edges.csv"), "a,b\nb,a\n").unwrap();
    let text = PROJECT.replace("neutral =", "name = \"Ada\"\nup = \"Z\"\nneutral =")
        + "bind = \"nearest\"\n[strain]\nedges = \"edges.csv\"\n[fine_scale]\nmax_influences = 3\n";
    std::fs::write(folder.path().join("face.toml"), text).unwrap();
    let face = read(&folder.path().join("face.toml"), Reach::Below).unwrap();
    assert_eq!((face.name.as_str(), face.up_axis), ("Ada", UpAxis::Z));
    assert_eq!((face.settings.bind, face.settings.max_influences), (Bind::Nearest, 3));
    assert_eq!(face.settings.strain_edges, StrainEdges::Given(vec![[HandleId(1), HandleId(0)]]));
}

#[test]
fn a_file_that_is_not_there_is_named_with_its_key() {
    for (file, key) in [
        ("neutral.obj", "[mesh] neutral"),
        ("markers.csv", "[handles] vertices"),
        ("poses/frown.obj", "[[example]] \"frown\": mesh"),
        ("edges.csv", "[strain] edges"),
    ] {
        let folder = folder();
        if key == "[strain] edges" {
            let text = format!("{PROJECT}[strain]\nedges = \"edges.csv\"\n");
            std::fs::write(folder.path().join("face.toml"), text).unwrap();
        } else {
            std::fs::remove_file(folder.path().join(file)).unwrap();
        }
        let (project, path) = (folder.path().join("face.toml"), folder.path().join(file));
        assert_eq!(
            reading(folder.path()),
            format!(
                "{}: {key} names {}, which does not exist; paths are relative to the project file",
                project.display(),
                path.display()
            )
        );
        std::fs::create_dir(&path).unwrap();
        assert!(reading(folder.path()).ends_with("which is a folder, expected a file"));
    }
}

#[test]
fn a_handle_past_the_last_vertex_is_named() {
    let folder = folder();
    let markers = folder.path().join("markers.csv");
    std::fs::write(&markers, "label,vertex\na,3\nb,4\n").unwrap();
    assert_eq!(
        reading(folder.path()),
        format!(
            "{}: handle \"b\" is at vertex 4, but {} has 4 vertices, expected 0 to 3",
            markers.display(),
            folder.path().join("neutral.obj").display()
        )
    );
}

#[test]
fn an_example_with_another_vertex_count_is_named() {
    let folder = folder();
    std::fs::write(folder.path().join("poses/frown.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n").unwrap();
    let found = reading(folder.path());
    assert!(found.contains("frown.obj") && found.contains('3') && found.contains('4'), "{found}");
}

#[test]
fn a_project_that_is_not_there_or_not_text_is_named() {
    let folder = folder();
    let path = folder.path().join("absent.toml");
    assert!(matches!(read(&path, Reach::Below), Err(Error::Io { path: p, .. }) if p == path));
    std::fs::write(folder.path().join("face.toml"), b"[mesh]\n# caf\xe9\n").unwrap();
    assert!(
        reading(folder.path())
            .ends_with("face.toml, line 2: not UTF-8 text, expected a project file in TOML")
    );
}
