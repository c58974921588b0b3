//! `rhytid render`: pictures of frames, on every device that draws.

use crate::common::{Fixture, assert_refused, image, list, stderr};

fn png(bytes: &[u8]) -> (png::OutputInfo, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgba);
    (info, pixels)
}

fn solved() -> Fixture {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f
}

#[test]
fn a_sheet_shows_frames_beside_each_other() {
    let f = solved();
    let said = f.done("render face.safetensors take.csv -o out/sheet.png --show shaded,wireframe,strain,detail,sigma,markers,influences,frames --vertex 50 --count 3 --size 60x50");
    assert!(
        said.contains("out/sheet.png: 3 pictures evaluated on cpu:0") && said.contains("drawn on wgpu:0"),
        "{said}"
    );
    let (info, pixels) = png(&f.read("out/sheet.png"));
    // At least as wide as four pictures or two legends.
    assert!(info.width >= 8 * 60 && info.height > 3 * 50, "{} × {}", info.width, info.height);
    let paper = &pixels[..4];
    let drawn = pixels.chunks(4).filter(|pixel| *pixel != paper).count();
    assert!(drawn > 24 * 60 * 50 / 4, "{drawn} pixels are not paper");
    // The same again, by bytes.
    f.done("render face.safetensors take.csv -o out/again.png --show shaded,wireframe,strain,detail,sigma,markers,influences,frames --vertex 50 --count 3 --size 60x50");
    assert!(f.read("out/sheet.png") == f.read("out/again.png"));
}

#[test]
fn each_frame_has_a_picture_of_its_own() {
    let f = solved();
    f.done("render face.safetensors take.csv -o out/f{frame}.png --frames 2..5 --size 90x70 --turn -30 --raise 20 --whole");
    assert_eq!(list(&f.path("out")), ["f00002.png", "f00003.png", "f00004.png"]);
    let pictures = [2, 3, 4].map(|frame| png(&f.read(&format!("out/f0000{frame}.png"))));
    for (info, _) in &pictures {
        assert_eq!((info.width, info.height), (90, 70));
    }
    assert!(pictures[0].1 != pictures[1].1, "the face moves");
    f.done(
        "render face.safetensors take.csv -o out/c{frame}.png --frames 2..3 --size 90x70 --background none",
    );
    f.done(
        "render face.safetensors take.csv -o out/d{frame}.png --frames 2..3 --size 90x70 --background 20A0ff",
    );
    let [clear, blue] = ["c", "d"].map(|name| png(&f.read(&format!("out/{name}00002.png"))).1);
    assert_eq!((&clear[..4], &blue[..4]), (&[0; 4][..], &[0x20, 0xa0, 0xff, 255][..]));
    // One frame, on its own and on a sheet.
    f.done("render face.safetensors take.csv -o out/one.png --frames 2..3 --stage shell");
}

#[test]
fn a_picture_moves_with_the_takes_frames_and_the_camera_goes_around() {
    let f = solved();
    f.done("render face.safetensors take.csv -o out/face.webp --frames 2..6 --size 60x50");
    f.done("render face.safetensors take.csv -o out/around.webp --frames 2..3 --size 60x50 --turntable --count 8");
    f.done("render face.safetensors take.csv -o out/around-{frame}.png --frames 2..3 --size 60x50 --turntable --count 2");
    for (file, frames) in [("face", 4), ("around", 8)] {
        let bytes = f.read(&format!("out/{file}.webp"));
        let mut decoder = image_webp::WebPDecoder::new(std::io::Cursor::new(&bytes)).unwrap();
        assert_eq!(decoder.num_frames(), frames);
        let (mut pictures, mut duration) = (Vec::new(), 0);
        for _ in 0..frames {
            let mut pixels = vec![0; decoder.output_buffer_size().unwrap()];
            duration += decoder.read_frame(&mut pixels).unwrap();
            pictures.push(pixels);
        }
        assert_eq!(f64::from(duration), (1000.0 * f64::from(frames) / 30.0).round());
        assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]), "{file} stands still");
        if file == "around" {
            let [front, back] = [0, 1].map(|i| png(&f.read(&format!("out/around-0000{i}.png"))).1);
            assert!(pictures[0] == front && pictures[4] == back, "from the front and from behind");
        }
    }
    let whole = f.read("out/face.webp");
    let refused =
        f.rhytid("render face.safetensors take.csv -o out/face.webp --draw-on wgpu:77").output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(f.read("out/face.webp") == whole);
}

#[test]
fn skin_is_lit_as_it_is_asked_for() {
    let f = solved();
    let args = "render face.safetensors take.csv --frames 2..3 --size 90x70";
    f.refused(&format!("{args} -o no.png --show skin --light 10"), &["--light", "-41,33"]);
    f.refused(
        &format!("{args} -o no.png --show skin --exposure 11"),
        &["--exposure", "stops from -10 to 10"],
    );
    // The whole sheet is one part.
    f.refused(&format!("{args} -o no.png --hide 0"), &["--hide: nothing would be left"]);
    f.refused(&format!("{args} -o no.png --hide 100000"), &["--hide 100000", "the rig's vertices are 0 to"]);
    // The brightness of the middle.
    let seen = |name: &str, options: &str| {
        let said = f.done(&format!("{args} -v -o out/{name}{{frame}}.png {options}"));
        assert!(said.contains(" skin, ") == options.contains("skin"), "{said}");
        let (_, pixels) = png(&f.read(&format!("out/{name}00002.png")));
        let middle = &pixels[4 * (35 * 90 + 45)..][..3];
        (middle.iter().map(|part| u32::from(*part)).sum::<u32>(), pixels)
    };
    let (front, drawn) = seen("front", "--show skin --light 0,0");
    assert!(drawn != seen("shaded", "--show shaded").1);
    let (side, _) = seen("side", "--show skin --light 85,0");
    assert!(front > side + 30, "{front}, {side} from the side");
    let (brighter, _) = seen("brighter", "--show skin --light 85,0 --exposure 1");
    assert!(brighter > side + 30, "{brighter} by a stop, {side} before");
    assert!(seen("agx", "--show skin --light 0,0 --tone agx").1 != drawn);
    // A session's own buffers give the same picture.
    assert!(seen("session", "--show skin --light 0,0 --device wgpu:0").1 == drawn);
}

/// The left part of a picture's rows, with this width in pixels.
fn left((info, pixels): &(png::OutputInfo, Vec<u8>), width: usize) -> Vec<u8> {
    pixels.chunks(4 * info.width as usize).flat_map(|row| &row[..4 * width]).copied().collect()
}

#[test]
fn what_is_drawn_from_where_it_was_evaluated_is_what_the_host_hands_over() {
    let f = solved();
    let args = "render face.safetensors take.csv --frames 2..5 --size 90x70 --device wgpu:0";
    let said = f.done(&format!("{args} -v -o out/a{{frame}}.png --show shaded,wireframe"));
    assert!(said.contains("3 pictures evaluated and drawn on wgpu:0"), "{said}");
    assert!(said.contains(" evaluation, ") && said.contains(" drawing; "), "{said}");
    // Strains are computed on the host, so that the whole frame is handed over.
    f.done(&format!("{args} -o out/b{{frame}}.png --show shaded,wireframe,strain"));
    for frame in [2, 3, 4] {
        let [here, over] = ["a", "b"].map(|name| png(&f.read(&format!("out/{name}0000{frame}.png"))));
        assert_eq!((here.0.width, over.0.width), (180, 270));
        assert!(here.1 == left(&over, 180), "frame {frame}");
    }
}

#[test]
fn a_stage_and_a_truth_are_put_to_the_left() {
    let f = solved();
    let args = "render face.safetensors take.csv --frames 10..11 --size 90x70";
    f.done(&format!("{args} -o out/both{{frame}}.png --before shell"));
    f.done(&format!("{args} -o out/shell{{frame}}.png --stage shell"));
    f.done(&format!("{args} -o out/full{{frame}}.png"));
    f.done("animate face.safetensors take.csv -o out/truth.usd");
    f.done(&format!("{args} -o out/truth{{frame}}.png --compare out/truth.usd"));
    let [both, shell, full, truth] =
        ["both", "shell", "full", "truth"].map(|name| png(&f.read(&format!("out/{name}00010.png"))));
    // A line of words is below; two lines with errors.
    assert_eq!((both.0.width, both.0.height), (180, 70 + 24));
    assert_eq!((truth.0.width, truth.0.height), (270, 70 + 48));
    let columns = |picture: &(png::OutputInfo, Vec<u8>), from: usize| -> Vec<u8> {
        let rows = picture.1.chunks(4 * picture.0.width as usize).take(70);
        rows.flat_map(|row| &row[4 * from..][..4 * 90]).copied().collect()
    };
    assert!(shell.1 != full.1, "the shell is another shape");
    assert!(columns(&both, 0) == shell.1 && columns(&both, 90) == full.1);
    // A truth exported from the rig equals the rig's result, apart from the rounding of its normals.
    assert!(columns(&truth, 90) == full.1);
    let apart = columns(&truth, 0).iter().zip(&full.1).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(apart <= Some(2), "{apart:?}");
}

#[test]
fn the_error_from_a_truth_has_the_colour_of_its_millimetres() {
    let f = solved();
    // In the first frame the sheet is at rest. The truth has the whole sheet 0.6 mm nearer to the viewer.
    let nearer = |line: &str| match line.strip_prefix("v ") {
        Some(numbers) => {
            let mut numbers: Vec<f64> = numbers.split(' ').map(|x| x.parse().unwrap()).collect();
            numbers[2] += 0.06;
            format!("v {} {} {}\n", numbers[0], numbers[1], numbers[2])
        }
        None => format!("{line}\n"),
    };
    f.write("truth/first.obj", f.read_text("neutral.obj").lines().map(nearer).collect::<String>());
    f.write("frames.csv", "frame\n0\n");
    f.done("render face.safetensors take.csv -o out/e{frame}.png --size 90x70 --compare truth --truth-frames frames.csv --show error --error-range 0.8 --unlit");
    let (info, pixels) = png(&f.read("out/e00000.png"));
    let row = pixels.chunks(4 * info.width as usize).nth(35).unwrap();
    // Three quarters of the way along the colours, in Oklab: lightness 0.7575, chroma 0.13, hue 63.75
    // degrees.
    let expected = [233, 157, 80];
    for x in [30, 45, 60] {
        let found = &row[4 * x..][..3];
        assert!(found.iter().zip(expected).all(|(a, b): (&u8, u8)| a.abs_diff(b) <= 2), "{found:?} at {x}");
    }
    // Light shows the form: the same number has several colours.
    let colours = |options: &str| {
        f.done(&format!(
            "render face.safetensors take.csv -o out/map.png --size 90x70 --show detail --frames 8..9 {options}"
        ));
        let (_, pixels) = png(&f.read("out/map.png"));
        pixels
            .chunks(4)
            .map(|pixel| [pixel[0], pixel[1], pixel[2]])
            .collect::<std::collections::HashSet<_>>()
            .len()
    };
    let [lit, unlit] = ["", "--unlit"].map(colours);
    assert!(lit > 2 * unlit, "{lit} colours with light, {unlit} without");
}

/// A film and `--fps` resample a take as `animate` does. Without them, pictures are of the take's own frames.
#[test]
fn a_film_keeps_the_clock() {
    let f = solved();
    let drawn = |options: &str| {
        let output = f.rhytid(&format!("render face.safetensors {options}")).output().unwrap();
        assert!(output.status.success(), "{options}: {}", stderr(&output));
        let said: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (said["pictures"].as_u64().unwrap(), stderr(&output))
    };
    let small = "--size 64x64 --json";
    // The frames 4, 6 … 18 of 30 per second are the frames 2, 3 … 9 of 15.
    let (all, _) = drawn(&format!("take.csv -o own{{frame}}.png {small}"));
    let (half, _) = drawn(&format!("take.csv -o out/{{frame}}.png --fps 15 --frames 4..20 {small}"));
    assert_eq!((all, half), (20, 8));
    let names: Vec<String> = (2..10).map(|frame| format!("{frame:05}.png")).collect();
    assert_eq!(list(&f.path("out")), names);
    for frame in 2..10 {
        let half = png(&f.read(&format!("out/{frame:05}.png"))).1;
        let own = png(&f.read(&format!("own{:05}.png", 2 * frame))).1;
        let most = half.iter().zip(&own).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(most <= 2, "frame {frame} is off by {most} of 255");
    }
    // A take that lacks five frames: its film lasts as long as before.
    let gap = f.read_text("take.csv").lines().enumerate().fold(String::new(), |text, (line, row)| {
        if (8..13).contains(&line) { text } else { text + row + "\n" }
    });
    f.write("gap.csv", gap);
    let (film, said) = drawn(&format!("gap.csv -o gap.webp {small}"));
    assert_eq!(film, 20);
    assert!(said.contains("times are uneven: frame 7") && said.contains("resampled to 30"), "{said}");
    let (pictures, said) = drawn(&format!("gap.csv -o gap{{frame}}.png {small}"));
    assert_eq!(pictures, 15);
    assert!(!said.contains("uneven"), "{said}");
}

/// The limit on a file's size stands for a full disk.
#[test]
#[cfg(unix)]
fn what_has_no_room_leaves_nothing() {
    let f = solved();
    for ending in [
        "png",
        "webp",
        #[cfg(feature = "film")]
        "mp4",
    ] {
        let command = format!("render face.safetensors take.csv --size 320x240 -o out/face.{ending}");
        let script = r#"ulimit -f 8; exec "$0" $1"#;
        let output = std::process::Command::new("sh")
            .args(["-c", script, env!("CARGO_BIN_EXE_rhytid"), &command])
            // SwiftShader keeps compiled code in a file without a name, and does not survive the limit.
            .env_remove("VK_ADD_DRIVER_FILES")
            .current_dir(f.path("."))
            .output()
            .unwrap();
        assert_refused(&output, &["out/face", "no space left", "not written"]);
        f.assert_nothing_written();
    }
}

#[test]
fn textures_and_matcaps_are_those_of_images() {
    let f = Fixture::new();
    f.replace("neutral.obj", "# a sheet\n", "mtllib skin.mtl\nusemtl skin\n");
    f.write("skin.mtl", "newmtl skin\nmap_Kd maps/blue.png\n");
    f.write("maps/blue.png", image([0, 0, 255]));
    f.write("red.png", image([255, 0, 0]));
    f.write("damaged.png", &image([255, 0, 0])[..40]);
    f.done("solve face.toml -o face.safetensors");
    let args = "render face.safetensors take.csv --frames 2..3 --size 90x70";
    let seen = |name: &str, options: &str| {
        f.done(&format!("{args} -o {name}{{frame}}.png {options}"));
        let (_, pixels) = png(&f.read(&format!("{name}00002.png")));
        pixels[4 * (35 * 90 + 45)..][..3].to_vec()
    };
    let is = |pixel: &[u8], channel: usize| (0..3).all(|c| (pixel[c] > 60) == (c == channel));
    for (name, options, channel) in [
        ("own", "--show textured", 2),
        ("red", "--show textured --texture red.png", 0),
        ("mtl", "--show textured --texture skin.mtl", 2),
        ("obj", "--show textured --texture neutral.obj", 2),
        // From a session's own buffers.
        ("session", "--show textured --texture neutral.obj --device wgpu:0", 2),
        ("ball", "--show matcap --matcap red.png", 0),
    ] {
        let pixel = seen(name, options);
        assert!(is(&pixel, channel), "{name}: {pixel:?}");
    }
    let clay = seen("clay", "--show matcap");
    assert!(clay.iter().max().unwrap() - clay.iter().min().unwrap() < 40 && clay[0] > 60, "{clay:?}");

    f.write("other.mtl", "newmtl eye\nmap_Kd red.png\n");
    let textured = format!("{args} -o no.png --show textured");
    let without_materials = solved();
    without_materials.refused(&textured, &["has no materials", "--show textured", "--texture FILE"]);
    f.refused(&format!("{textured} --texture damaged.png"), &["damaged.png", "expected a sound PNG or JPEG"]);
    f.refused(
        &format!("{textured} --texture other.mtl"),
        &["materials eye", "the rig's are skin", "image itself"],
    );
    f.refused(&format!("{textured} --texture face.toml"), &["face.toml", "must end in"]);
    let without: String = (f.read_text("neutral.obj").lines().filter(|line| !line.starts_with("vt ")))
        .map(|line| match line.strip_prefix("f ") {
            Some(corners) => {
                let corners = corners.split(' ').map(|corner| corner.split('/').next().unwrap());
                format!("f {}\n", corners.collect::<Vec<_>>().join(" "))
            }
            None => format!("{line}\n"),
        })
        .collect();
    f.write("neutral.obj", without);
    f.done("solve face.toml -o bare.safetensors");
    f.refused(
        "render bare.safetensors take.csv -o no.png --show textured --texture red.png",
        &["bare.safetensors: has no texture coordinates", "vt in .obj"],
    );
}

#[test]
fn what_cannot_be_drawn_is_refused_in_a_sentence() {
    let f = solved();
    for (args, words) in [
        ("-o out/face.jpg", &["out/face.jpg", "expected .png", ".mp4 or .webp"][..]),
        ("-o out/{frame}.webp", &["out/{frame}.webp", "{frame} is for .png"]),
        ("-o out/face.webp --size 16385x10", &["16385 × 10 pixels", "expected 1 to"]),
        #[cfg(feature = "film")]
        ("-o out/face.mp4 --background none", &["--background none", "no transparency", ".webp"]),
        #[cfg(feature = "film")]
        ("-o out/face.mp4 --size 15x400", &["out/face.mp4: 15 × 400 pixels", "16 to 65535"]),
        #[cfg(feature = "film")]
        ("-o out/face.mp4 --size 0x10", &["expected width x height", "1 to 32768"]),
        ("-o out/face.png --size 0x10", &["expected width x height", "1 to 32768"]),
        ("-o out/face.png --size 100000x10", &["expected width x height", "1 to 32768"]),
        ("-o out/face.png --show influences", &["--show influences", "--vertex N"]),
        ("-o out/face.png --show influences --vertex 9999999", &["--vertex 9999999", "0 to"]),
        ("-o out/face.png --show error", &["--show error", "--compare TRUTH"]),
        ("-o out/face.png --before shell --stage shell", &["--before shell", "not before the --stage"]),
        ("-o out/face.png --before nothing", &["expected shell, large-scale or a rig file"]),
        ("-o out/face.png --before face.toml", &["face.toml: is a project file, expected a rig"]),
        ("-o out/face.png --compare poses", &["the truth has 1 frames and the take 20"]),
        ("-o out/face.png --background red", &["expected six digits", "none"]),
        ("-o out/face.png --size 30000x10", &["30000 × 10 pixels", "expected 1 to"]),
        ("-o out/face.png --show strain --stage shell --draw-on cpu:0", &["--draw-on cpu:0", "backend wgpu"]),
        (
            "-o out/face.png --draw-on wgpu:77",
            &["wgpu:77: there is no device to draw with", "rhytid devices"],
        ),
        ("-o out/face.png --show detail --stage large-scale", &["--show detail", "--stage full"]),
        ("-o out/face.png --frames 900..", &["900"]),
        ("-o nowhere/face.png", &["nowhere"]),
        ("-o out/face.png --count 400 --size 8000x8000", &["a page of", "ask for fewer or smaller"]),
    ] {
        f.refused(&format!("render face.safetensors take.csv {args}"), words);
    }
    f.assert_nothing_written();
}
