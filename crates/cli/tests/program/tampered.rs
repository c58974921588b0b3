//! Files that were changed after their export: `verify` finds the change, and `stitch` refuses them.

use crate::common::{Fixture, image, stderr};

/// A text in a `.usda` file and its replacement. Then the words of `verify` and its exit code.
const CHANGES: [(&str, &str, &str, i32); 10] = [
    ("metersPerUnit = 0.01", "metersPerUnit = 1", "metres per unit: 1, expected 0.01", 1),
    ("upAxis = \"Y\"", "upAxis = \"Z\"", "up axis: Z, expected Y", 1),
    ("framesPerSecond = ", "framesPerSecond = 9", "framesPerSecond: 9", 1),
    ("startTimeCode = 0", "startTimeCode = 1", "startTimeCode 1, expected 0", 2),
    ("endTimeCode = 8", "endTimeCode = 7", "endTimeCode 7, expected 8", 2),
    (
        "faceVertexIndices = [0, 1, 22, 21",
        "faceVertexIndices = [21, 22, 1, 0",
        "faces: others, expected the rig's",
        1,
    ),
    (
        "int[] faceVertexCounts",
        "uniform token orientation = \"leftHanded\"\n        int[] faceVertexCounts",
        "left-handed faces",
        2,
    ),
    ("normal3f[] normals", "normal3f[] othernormals", "normals: lacks, expected has", 1),
    ("float3[] extent", "float3[] otherextent", "extents: lacks, expected has", 1),
    (
        "normals.timeSamples = {\n            0: [(",
        "normals.timeSamples = {\n            0: [(0, 0, 9), (",
        "",
        2,
    ),
];

fn exported() -> Fixture {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    for (frames, part) in [("0..9", "a"), ("9..17", "b")] {
        f.done(&format!(
            "animate face.safetensors take.csv --device cpu:0 --frames {frames} -o part-{part}.usda"
        ));
    }
    f
}

fn verify(f: &Fixture, name: &str) -> (i32, String) {
    let command = format!("verify {name} --rig face.safetensors --take take.csv --device cpu:0");
    let output = f.rhytid(&command).output().unwrap();
    let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), stderr(&output));
    (output.status.code().unwrap(), said)
}

#[test]
fn what_was_changed_is_found() {
    let f = exported();
    assert_eq!(verify(&f, "part-a.usda").0, 0);
    let text = f.read_text("part-a.usda");
    for (from, to, says, code) in CHANGES {
        assert!(text.contains(from), "{from}: {}", &text[..3000]);
        f.write("changed.usda", text.replace(from, to));
        let (found, said) = verify(&f, "changed.usda");
        assert!(found == code && said.contains(says), "{to}: {found} {said}");
    }
}

/// Changed numbers of one sample.
#[test]
fn a_wrong_extent_and_a_wrong_normal_are_found() {
    let f = exported();
    let text = f.read_text("part-a.usda");
    let change = |what: &str, says: &str| {
        let samples = text.find(&format!("{what}.timeSamples")).unwrap();
        let first = samples + text[samples..].find("[(").unwrap() + 2;
        let end = first + text[first..].find(')').unwrap();
        f.write("changed.usda", format!("{}9, 9, 9{}", &text[..first], &text[end..]));
        let (code, said) = verify(&f, "changed.usda");
        assert!(code == 1 && said.contains(says) && said.contains("FAILS"), "{what}: {said}");
    };
    change("extent", "extents: wrong in 1 of 9 frames");
    change("normals", "of their length at worst");
    change("points", "frame 0, vertex 0");
}

#[test]
fn parts_that_differ_are_not_stitched() {
    let f = exported();
    f.done("stitch part-a.usda part-b.usda -o whole.usd");
    let text = f.read_text("part-b.usda");
    for (from, to, says) in [
        ("metersPerUnit = 0.01", "metersPerUnit = 1", "metres per unit: 1 and 0.01"),
        ("upAxis = \"Y\"", "upAxis = \"Z\"", "the up axis: Z and Y"),
        ("framesPerSecond = ", "framesPerSecond = 9", "framesPerSecond: 9"),
        ("startTimeCode = 9", "startTimeCode = 8", "startTimeCode 8"),
        (
            "faceVertexIndices = [0, 1, 22, 21",
            "faceVertexIndices = [21, 22, 1, 0",
            "their faces are different",
        ),
        ("normal3f[] normals", "normal3f[] othernormals", "with normals: no and yes"),
        ("float3[] extent", "float3[] otherextent", "with extents: no and yes"),
    ] {
        assert!(text.contains(from), "{from}: {}", &text[..3000]);
        f.write("changed.usda", text.replace(from, to));
        f.refused("stitch part-a.usda changed.usda -o out/whole.usd", &["changed.usda", says]);
    }
}

/// A fault in a file: what it is, and the file with it.
struct Fault {
    what: String,
    text: String,
}

/// Where a statement in USD text begins and ends: `type name = value`, and what its braces or brackets hold.
fn statements(text: &str) -> Vec<std::ops::Range<usize>> {
    let mut found = Vec::new();
    let mut at = 0;
    let mut in_notes = 0;
    for line in text.split_inclusive('\n') {
        let begin = at;
        at += line.len();
        let opens =
            line.matches(['{', '[', '(']).count() as i64 - line.matches(['}', ']', ')']).count() as i64;
        // What people note changes nothing that is shown.
        if in_notes > 0 || line.contains("customData = {") {
            in_notes += opens;
            continue;
        }
        if !line.contains(" = ") {
            continue;
        }
        let mut end = at;
        let mut depth = opens;
        for more in text[at..].split_inclusive('\n') {
            if depth <= 0 {
                break;
            }
            depth +=
                more.matches(['{', '[', '(']).count() as i64 - more.matches(['}', ']', ')']).count() as i64;
            end += more.len();
        }
        // Only the brackets of metadata stay open at the end of a property's line.
        let is_open = opens > 0 && line.trim_end().ends_with('(');
        found.push(begin..if is_open { at } else { end });
    }
    found
}

/// The statement with its first or its last number, or its text, changed.
fn changed(statement: &str, last: bool) -> Option<String> {
    let (head, value) = statement.split_once(" = ")?;
    if let Some((before, rest)) = value.split_once('"') {
        let (word, after) = rest.split_once('"')?;
        return (!last).then(|| format!("{head} = {before}\"other{word}\"{after}"));
    }
    if let Some(rest) = value.strip_prefix("true").filter(|_| !last) {
        return Some(format!("{head} = false{rest}"));
    }
    // Times stand before colons.
    let is_part = |c: char| c.is_ascii_digit() || "+-.e".contains(c);
    let mut numbers = Vec::new();
    let mut i = 0;
    while i < value.len() {
        let length = value[i..].find(|c| !is_part(c)).unwrap_or(value.len() - i);
        let is_number = length > 0 && value[i..i + length].parse::<f64>().is_ok();
        if is_number && !value[i + length..].starts_with(':') {
            numbers.push(i..i + length);
        }
        i += length.max(1);
    }
    let range = if last { numbers.pop().filter(|_| !numbers.is_empty()) } else { numbers.first().cloned() }?;
    let number: f64 = value[range.clone()].parse().ok()?;
    let is_whole = !value[range.clone()].contains(['.', 'e']) && head.contains("int");
    let other = if is_whole { format!("{}", number as i64 + 1) } else { format!("{}", 2.0 * number + 1.5) };
    Some(format!("{head} = {}{other}{}", &value[..range.start], &value[range.end..]))
}

/// Every statement of a USD file removed, and changed in its first and in its last number; every block of
/// samples a frame later; and what hides, moves or replaces a prim, added to each.
fn usd_faults(text: &str) -> Vec<Fault> {
    let mut faults = Vec::new();
    for range in statements(text) {
        let statement = &text[range.clone()];
        let name = statement.split(" = ").next().unwrap().trim().to_owned();
        // Names for people are theirs to change.
        if name == "displayName" {
            continue;
        }
        let with = |other: &str| format!("{}{other}{}", &text[..range.start], &text[range.end..]);
        let mut add = |what: &str, other: &str| {
            faults.push(Fault { what: format!("{name} {what}"), text: with(other) });
        };
        let opens_metadata = statement.trim_end().ends_with('(');
        if !opens_metadata {
            add("removed", "");
        }
        for last in [false, true] {
            if let Some(other) = changed(statement, last) {
                add(if last { "with another last number" } else { "changed" }, &other);
            }
        }
        if name.ends_with(".timeSamples") {
            let later: String = statement
                .split_inclusive('\n')
                .map(|line| match line.trim_start().split_once(": ") {
                    Some((time, rest)) => match time.parse::<f64>() {
                        Ok(time) => format!("            {}: {rest}", time + 1.0),
                        Err(_) => line.to_owned(),
                    },
                    None => line.to_owned(),
                })
                .collect();
            add("a frame later", &later);
        }
    }
    let additions = [
        "token visibility = \"invisible\"",
        "token purpose = \"guide\"",
        "double3 xformOp:translate = (10, 0, 0)",
        "uniform token[] xformOpOrder = [\"!resetXformStack!\"]",
        "int[] holeIndices = [0]",
        "float[] creaseSharpnesses = [1]",
        "uniform token interpolateBoundary = \"none\"",
        "rel proxyPrim = </other>",
    ];
    for (at, _) in text.match_indices("{\n").filter(|(at, _)| {
        let line = text[..*at].trim_end().rsplit('\n').next().unwrap().trim_start();
        line.starts_with("def ") || line == ")"
    }) {
        for addition in additions {
            let text = format!("{}{{\n{addition}\n{}", &text[..at], &text[at + 2..]);
            faults.push(Fault { what: format!("{addition} added"), text });
        }
    }
    // Prims of a stitched file are in its parts.
    if let Some((_, rest)) = text.split_once("def Mesh ") {
        let (mesh, _) = rest.split_once('\n').unwrap();
        faults.push(Fault {
            what: "the mesh's name given to a second prim".to_owned(),
            text: format!("{}def Mesh {mesh}\n{{\n}}\n}}\n", text.trim_end().strip_suffix('}').unwrap()),
        });
    }
    for (from, fields) in [
        ("#usda 1.0\n(\n", ["subLayers = [@other.usda@]", "endFrame = 3"]),
        ("def Xform \"face\"\n(\n", ["active = false", "instanceable = true"]),
        ("def Xform \"face\"\n(\n", ["prepend references = @other.usda@", "prepend payload = @other.usda@"]),
        ("def Xform \"face\"\n(\n", ["inherits = </other>", "hidden = true"]),
    ] {
        assert!(text.contains(from), "{}", &text[..400]);
        for field in fields {
            faults.push(Fault {
                what: format!("{field} added"),
                text: text.replacen(from, &format!("{from}{field}\n"), 1),
            });
        }
    }
    faults
}

/// Gives the neutral two materials, one with a texture, whose faces follow each other in turns. So the
/// triangles of a material are not together in the rig.
fn alternate_materials(f: &Fixture) {
    let mut text = "mtllib neutral.mtl\n".to_owned();
    let mut faces = 0;
    for line in f.read_text("neutral.obj").lines() {
        if line.starts_with("f ") {
            text.push_str(["usemtl dark\n", "usemtl light\n"][faces % 2]);
            faces += 1;
        }
        text.push_str(line);
        text.push('\n');
    }
    f.write("neutral.obj", text);
    f.write("neutral.mtl", "newmtl dark\nmap_Kd dark.png\nnewmtl light\nKd 0.9 0.9 0.9\n");
    f.write("dark.png", image([20, 20, 20]));
}

/// Each kind of file with every fault that a machine can make: `verify` finds all.
#[test]
fn every_fault_of_a_usd_file_is_found() {
    let f = Fixture::with_side(11);
    alternate_materials(&f);
    f.done("solve face.toml -o face.safetensors");
    let head = ",head_tx,head_ty,head_tz,head_qx,head_qy,head_qz,head_qw";
    let take = f.take(6);
    let with_head = take.lines().enumerate().map(|(i, line)| match i {
        0 => format!("{line}{head}\n"),
        i => format!("{line},{},0,0,0,0,0,1\n", i as f64 / 10.0),
    });
    f.write("take.csv", with_head.collect::<String>());
    let (mut count, mut missed) = (0, Vec::new());
    let animate = "animate face.safetensors take.csv --device cpu:0";
    for (frames, part) in [("0..3", "a"), ("3..6", "b")] {
        f.done(&format!("{animate} --frames {frames} -o part-{part}.usd"));
    }
    for options in ["--strain --sigma", "--velocities", "--shapes 3", "--shapes 3 --no-normals", "stitched"] {
        match options {
            "stitched" => f.done("stitch part-a.usd part-b.usd -o sound.usda"),
            _ => f.done(&format!("{animate} {options} -o sound.usda")),
        };
        let (code, said) = verify(&f, "sound.usda");
        assert_eq!(code, 0, "{options}: {said}");
        let text = f.read_text("sound.usda").replace("def SkelRoot \"face\"\n", "def Xform \"face\"\n");
        for Fault { what, text } in usd_faults(&text) {
            let text = if options.contains("shapes") {
                text.replace("def Xform \"face\"\n", "def SkelRoot \"face\"\n")
            } else {
                text
            };
            f.write("changed.usda", &text);
            let (code, said) = verify(&f, "changed.usda");
            missed.extend((!matches!(code, 1 | 2)).then(|| format!("{options}: {what}")));
            assert!(!said.contains("panicked"), "{what}: {said}");
            count += 1;
        }
    }
    assert!(
        missed.is_empty(),
        "{} of {count} faults of USD files are not found:\n{}",
        missed.len(),
        missed.join("\n")
    );
    println!("{count} faults of USD files, all found");
    assert!(count > 500, "{count}");
}

/// Paths of all leaves of JSON.
fn leaves(value: &serde_json::Value, path: &str, found: &mut Vec<String>) {
    match value {
        serde_json::Value::Object(fields) => {
            fields.iter().for_each(|(name, value)| leaves(value, &format!("{path}/{name}"), found));
        }
        serde_json::Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, value)| leaves(value, &format!("{path}/{i}"), found));
        }
        _ => found.push(path.to_owned()),
    }
}

/// Removes what stands at a path.
fn remove(document: &mut serde_json::Value, path: &str) {
    let (parent, name) = path.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        serde_json::Value::Object(fields) => drop(fields.remove(name)),
        serde_json::Value::Array(items) => drop(items.remove(name.parse().unwrap())),
        other => panic!("{path}: {other}"),
    }
}

#[test]
fn every_fault_of_a_gltf_file_is_found() {
    use serde_json::{Value, json};
    let f = Fixture::with_side(11);
    // Mostly in the basis, the band would make the take a mixture of few shapes, and its error would be
    // rounding.
    f.write("face.toml", format!("{}[learned]\nshare = 1\n", f.read_text("face.toml")));
    // On this coarse sheet, wrinkles are as rough as noise.
    f.replace("face.toml", "mesh = \"poses/pinch.obj\"", "mesh = \"poses/pinch.obj\"\nnoise = 0");
    alternate_materials(&f);
    f.done("solve face.toml -o face.safetensors");
    f.write("take.csv", f.take(4));
    let (mut count, mut missed) = (0, Vec::new());
    for options in ["--strain", "--compressed --quantize", "--shapes 2"] {
        let _ = std::fs::remove_dir_all(f.path("g"));
        std::fs::create_dir(f.path("g")).unwrap();
        f.done(&format!("animate face.safetensors take.csv --device cpu:0 {options} -o g/sound.gltf"));
        let (code, said) = verify(&f, "g/sound.gltf");
        assert_eq!(code, 0, "{options}: {said}");
        let sound: Value = serde_json::from_str(&f.read_text("g/sound.gltf")).unwrap();
        let mut documents: Vec<(String, Value)> = Vec::new();
        let mut paths = Vec::new();
        leaves(&sound, "", &mut paths);
        for path in paths {
            // The program and its version, the use of a view, the names of targets and of the take, and the
            // recipe, which has checks of its own. Two vertices may have the same error.
            let harmless = [
                "/asset/generator",
                "/target",
                "/targetNames/",
                "/animations/0/name",
                "/rhytid/",
                "/error/vertex",
            ];
            if harmless.iter().any(|word| path.contains(word)) && !path.contains("/channels/") {
                continue;
            }
            let is_default = sound.pointer(&path).unwrap() == 0 && path.ends_with("/byteOffset");
            let mut removed = sound.clone();
            remove(&mut removed, &path);
            if !is_default {
                documents.push((format!("{path} removed"), removed));
            }
            let mut other = sound.clone();
            let leaf = other.pointer_mut(&path).unwrap();
            *leaf = match &*leaf {
                // A vertex may have the same error in two frames, so the next frame may be right.
                Value::Number(_) if path.ends_with("/error/frame") => 1000.into(),
                Value::Number(number) if number.is_u64() => (number.as_u64().unwrap() + 1).into(),
                Value::Number(number) => (2.0 * number.as_f64().unwrap() + 0.5).into(),
                Value::Bool(yes) => (!yes).into(),
                Value::String(text) => format!("other{text}").into(),
                other => panic!("{path}: {other}"),
            };
            documents.push((format!("{path} changed"), other));
        }
        for (place, field) in [
            ("/nodes/0", json!({"extensions": {"KHR_node_visibility": {"visible": false}}})),
            ("/nodes/0", json!({"skin": 0})),
            ("/nodes/0", json!({"weights": [1.0, 1.0, 1.0, 1.0]})),
            ("/nodes/0", json!({"translation": [0.1, 0.0, 0.0]})),
            ("/nodes/0", json!({"rotation": [0.0, 1.0, 0.0, 0.0]})),
            ("/meshes/0", json!({"weights": [0.0, 1.0, 0.0, 0.0]})),
            ("/materials/0", json!({"alphaMode": "BLEND"})),
            ("/materials/0", json!({"emissiveFactor": [1.0, 1.0, 1.0]})),
            ("", json!({"cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]})),
            ("", json!({"extensionsUsed": ["KHR_materials_unlit"]})),
            ("/scenes/0", json!({"name": "other"})),
            ("/animations/0/samplers/0", json!({"interpolation": "STEP"})),
        ] {
            let mut other = sound.clone();
            let fields = field.as_object().unwrap().clone();
            other.pointer_mut(place).unwrap().as_object_mut().unwrap().extend(fields);
            documents.push((format!("{place} {field} added"), other));
        }
        let bin = sound.pointer("/buffers/0/uri").unwrap().as_str().unwrap().to_owned();
        for (what, document) in documents {
            f.write("g/changed.gltf", document.to_string());
            let (code, said) = verify(&f, "g/changed.gltf");
            missed.extend((!matches!(code, 1 | 2)).then(|| format!("{options}: {what}")));
            assert!(!said.contains("panicked"), "{what}: {said}");
            count += 1;
        }
        // One number in the middle of each accessor.
        let bytes = f.read(&format!("g/{bin}"));
        f.write("g/changed.gltf", sound.to_string());
        for (i, accessor) in sound["accessors"].as_array().unwrap().iter().enumerate() {
            let Some(view) = accessor["bufferView"].as_u64() else { continue };
            let view = &sound["bufferViews"][view as usize];
            let begin =
                view["byteOffset"].as_u64().unwrap_or(0) + accessor["byteOffset"].as_u64().unwrap_or(0);
            let count_of = accessor["count"].as_u64().unwrap();
            let stride = view["byteStride"].as_u64().unwrap_or(4);
            let at = (begin + (count_of / 2) * stride) as usize;
            let mut other = bytes.clone();
            // The high byte of a float, or a byte of an integer.
            let at = at + if accessor["componentType"] == 5126 { 3 } else { 0 };
            other[at] ^= 0x41;
            f.write(&format!("g/{bin}"), &other);
            let (code, _) = verify(&f, "g/changed.gltf");
            missed.extend((!matches!(code, 1 | 2)).then(|| format!("{options}: a number of accessor {i}")));
            count += 1;
        }
        f.write(&format!("g/{bin}"), &bytes);
    }
    assert!(
        missed.is_empty(),
        "{} of {count} faults of glTF files are not found:\n{}",
        missed.len(),
        missed.join("\n")
    );
    println!("{count} faults of glTF files, all found");
    assert!(count > 300, "{count}");
}
