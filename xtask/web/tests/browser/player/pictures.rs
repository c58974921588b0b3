//! What three.js shows.
use super::super::viewer::{decoded, differ, shows_face};
use super::*;

/// Two frames of a file from the front and from the side, one beside the other, as the page shows them.
fn shown(page: &str, file: &str, options: &str, picture: &Path) -> Vec<u8> {
    let faces = &package().faces;
    let frames = [faces.frame(0), faces.frame(44)];
    let body = format!(
        "for (const positions of {}) {{
            for (const degrees of [0, 60]) {{
                const opened = await open('{file}', {options});
                opened.look(degrees);
                opened.face.pose(positions);
                for (let i = 0; i < 3; i += 1) {{
                    opened.draw();
                    await new Promise((done) => requestAnimationFrame(done));
                }}
            }}
        }}
        return null;",
        json!(frames)
    );
    ran(page, &body, json!({ "picture": picture, "width": 4 * 480, "height": 480 }));
    std::fs::read(picture).unwrap()
}

/// The picture of each of the three ways to draw: by WebGPU, by WebGL 2 of the same renderer, and by the
/// older renderer. They are kept under `target/player-pictures`.
#[test]
fn a_face_looks_alike_however_it_is_drawn() {
    let folder = root().join("target/player-pictures");
    std::fs::create_dir_all(&folder).unwrap();
    for file in ["learned", "seams"] {
        let shown = |name: &str, page: &str, options: &str| {
            let picture = folder.join(format!("{file}-{name}.png"));
            shown(page, &format!("{file}.safetensors"), options, &picture)
        };
        let gpu = shown("webgpu", "gpu.html", "{}");
        assert!(shows_face(&gpu), "{file}: WebGPU");
        let (width, height, pixels) = decoded(&gpu);
        assert_eq!((width, height), (1920, 480));
        // The frames and the sides differ.
        let tile = |pixels: &[u8], i: usize| -> Vec<u8> {
            let bytes = pixels.len() / (1920 * 480);
            let row = |y: usize| &pixels[bytes * (1920 * y + 480 * i)..][..bytes * 480];
            (0..480).flat_map(|y| row(y).chunks_exact(bytes).flat_map(|p| [p[0], p[1], p[2], 255])).collect()
        };
        for [a, b] in [[0, 1], [0, 2], [1, 3]] {
            assert!(differ(&tile(&pixels, a), &tile(&pixels, b)) > 0.02, "{file}: {a} and {b} are alike");
        }
        for (name, page, options) in
            [("webgl", "gpu.html", "{ gpu: false }"), ("webgl-renderer", "gl.html", "{}")]
        {
            let other = decoded(&shown(name, page, options)).2;
            for i in 0..4 {
                let differ = differ(&tile(&pixels, i), &tile(&other, i));
                println!("{file}, {name}, {i}: {differ}");
                assert!(differ < 0.02, "{file}, {name}, {i}: {differ} of the pixels are others");
            }
        }
    }
}

/// The example's page shows a face, and is as short as it says.
#[test]
fn the_example_plays() {
    let lines = std::fs::read_to_string(root().join("examples/three/index.html")).unwrap();
    let script = lines.split_once("<script type=\"module\">").unwrap().1.split_once("</script>").unwrap().0;
    let lines = script.trim().lines().filter(|line| !line.trim().is_empty()).count();
    assert!(lines <= 30, "{lines}");
    let picture = root().join("target/player-pictures/example.png");
    std::fs::create_dir_all(picture.parent().unwrap()).unwrap();
    let mut visit = visit_of(
        "example.html",
        "return null;",
        json!({ "width": 900, "height": 600, "picture": picture, "evaluate": {} }),
    );
    // The page knows of no test.
    visit["until"] = json!("document.querySelector('canvas')?.width > 0");
    visit["steps"] =
        json!([{ "evaluate": { "_": "new Promise((done) => setTimeout(() => done(0), 3000))" } }]);
    let visited = visited(visit);
    assert_eq!(visited["errors"], json!([]));
    assert!(shows_face(&std::fs::read(&picture).unwrap()));
}
