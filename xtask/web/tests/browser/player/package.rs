//! The package: its size, its types, its example.
use super::*;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;
use std::process::Command;

/// The most bytes of what a browser loads, as gzip.
const MOST: usize = 1_000_000;

/// The page of `examples/three`, with three.js and the package beside it in place of a network's.
pub(super) fn example() -> String {
    let page = std::fs::read_to_string(root().join("examples/three/index.html")).unwrap();
    let three = "https://cdn.jsdelivr.net/npm/three@0.187.0";
    let page = page
        .replace(&format!("{three}/build/"), "./")
        .replace("three/addons/controls/", "three/addons/")
        .replace(&format!("{three}/examples/jsm/"), "./")
        .replace("./player/index.js", "./index.js")
        .replace("face.safetensors", "learned.safetensors")
        // A browser asks every host for an icon.
        .replace("<title>", "<link rel=\"icon\" href=\"data:,\" /><title>");
    assert!(!page.contains("https:"), "{page}");
    page
}

#[test]
fn what_a_browser_loads_is_small_and_the_package_is_whole() {
    let Package { folder, files, .. } = package();
    let mut all = 0;
    for Size { name, .. } in
        files.iter().filter(|file| file.name.ends_with(".js") || file.name.ends_with(".wasm"))
    {
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        packed.write_all(&std::fs::read(folder.join(name)).unwrap()).unwrap();
        let bytes = packed.finish().unwrap().len();
        println!("{name}: {bytes} bytes as gzip");
        all += bytes;
    }
    println!("{all} bytes in all");
    assert!(all < MOST, "{all}");
    let manifest: Value =
        serde_json::from_slice(&std::fs::read(folder.join("package.json")).unwrap()).unwrap();
    assert_eq!(
        (&manifest["name"], &manifest["version"]),
        (&json!("@rhytid/player"), &json!(env!("CARGO_PKG_VERSION")))
    );
    // npm packs each file of the folder.
    let output =
        Command::new("npm").args(["pack", "--dry-run", "--json"]).current_dir(folder).output().unwrap();
    let packed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let mut names: Vec<&str> =
        packed[0]["files"].as_array().unwrap().iter().map(|f| f["path"].as_str().unwrap()).collect();
    names.sort_unstable();
    let built: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    assert_eq!(names, built);
}

/// A program that uses everything of the types. A line after `@ts-expect-error` must not compile.
const PROGRAM: &str = r#"
import { BASIS_STORAGES, DEFAULTS, Face, init, Live, MISSING, RhytidError, STAGES, Take } from "./index.js";
import type { BasisStorage, Missing, Stage } from "./index.js";

class Mesh { readonly isMesh = true; constructor(public geometry?: object) {} }
class Other {}
const THREE = { Mesh, BufferGeometry: Other, BufferAttribute: Other, MeshStandardMaterial: Other, Texture: Other };

export async function everything(renderer: { render(mesh: Mesh): void }): Promise<Mesh> {
    await init(new URL("rhytid_player_bg.wasm", "http://localhost"));
    const basis: BasisStorage = BASIS_STORAGES[0];
    const face = await Face.load("face.safetensors", { basis, name: "face" });
    const mesh: Mesh = face.mesh3js(THREE);
    for (const { name, rest } of face.handles) face.pose({ [name]: [rest[0], rest[1], rest[2]] });
    face.pose(face.positions);
    face.pose(new Map([["chin", [0, 1, 2] as const]]));
    const missing: Missing = DEFAULTS.missing;
    const take = await Take.load(new Blob(), face, { missing });
    face.play(take, { loop: true, head: false, speed: 2, at: take.duration / 2 });
    face.paused = !face.paused;
    face.seek((face.time ?? 0) + 1 / take.rate);
    face.update(performance.now() / 1000);
    const live: Live = face.follow("ws://localhost", { reconnect: false });
    const late: number = live.counts.late + (live.frame?.latency ?? 0);
    const stages: readonly Stage[] = STAGES;
    const positions: Float32Array = await face.read(stages[late > 0 ? 4 : 5]);
    const policies: readonly string[] = MISSING;
    // @ts-expect-error: no animation is made with this policy.
    await Take.load("take.csv", face, { missing: "leave" });
    // @ts-expect-error: there is no such stage.
    await face.read("wrinkles");
    // @ts-expect-error: faces are loaded.
    new Face();
    // @ts-expect-error: what evaluates is not chosen.
    face.evaluatedOn = "cpu";
    // @ts-expect-error: three coordinates.
    face.pose({ chin: [1, 2] });
    try {
        renderer.render(mesh);
    } catch (error) {
        if (error instanceof RhytidError) console.log(error.kind, policies, positions, face.memory.wasm, face.evaluatedOn);
    }
    face.stop();
    take.dispose();
    face.dispose();
    return mesh;
}
"#;

#[test]
fn the_types_are_those_of_the_package() {
    let folder = tempfile::tempdir().unwrap();
    for Size { name, .. } in package().files.iter().filter(|file| file.name.ends_with(".d.ts")) {
        std::fs::copy(package().folder.join(name), folder.path().join(name)).unwrap();
    }
    std::fs::write(folder.path().join("program.ts"), PROGRAM).unwrap();
    let compiler = root().join("target/node/node_modules/typescript/bin/tsc");
    let flags = [
        "--noEmit",
        "--strict",
        "--exactOptionalPropertyTypes",
        "--target",
        "es2022",
        "--module",
        "nodenext",
    ];
    let output =
        Command::new("node").arg(compiler).args(flags).arg("program.ts").current_dir(folder.path()).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}

/// What the types declare is there, and nothing else is.
#[test]
fn the_types_name_what_the_module_has() {
    let types = std::fs::read_to_string(package().folder.join("index.d.ts")).unwrap();
    let found = run(
        "gpu.html",
        "const members = (value) => Object.getOwnPropertyNames(value).filter((name) => !['constructor', 'length', 'name', 'prototype'].includes(name));
        const face = await player.Face.load('learned.safetensors');
        const take = await player.Take.load('take.csv', face);
        const live = face.follow('ws://127.0.0.1:9', { reconnect: false });
        const of = (type, one) => [...members(type), ...members(type.prototype), ...members(one)];
        const found = { exports: Object.keys(player), Face: of(player.Face, face), Take: of(player.Take, take), Live: of(player.Live, live) };
        live.close();
        return found;",
    );
    for class in ["Face", "Take", "Live"] {
        let body = types
            .split_once(&format!("export declare class {class} {{"))
            .unwrap()
            .1
            .split_once("\n}")
            .unwrap()
            .0;
        let members =
            body.lines().map(str::trim).filter(|line| line.ends_with(';') && !line.starts_with("private"));
        let mut declared: Vec<&str> = members
            .map(|line| line.trim_start_matches("static ").trim_start_matches("readonly "))
            .map(|line| line.split(['(', ':', '<']).next().unwrap())
            .collect();
        let mut there: Vec<&str> =
            found[class].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        // What only the package's own files use.
        there.retain(|name| !["wasm", "at", "headAt", "newest"].contains(name));
        if class == "Face" {
            // The name of a class is a member of it, and a face has one.
            there.push("name");
        }
        declared.sort_unstable();
        there.sort_unstable();
        assert_eq!(declared, there, "{class}");
    }
    let exports: Vec<&str> = found["exports"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert_eq!(
        exports,
        ["BASIS_STORAGES", "DEFAULTS", "Face", "Live", "MISSING", "RhytidError", "STAGES", "Take", "init"]
    );
}
