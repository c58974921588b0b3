//! `rhytid render`: pictures of frames, on every device that draws.

use crate::common::{Fixture, list};

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
    // At least as wide as four pictures, or as two legends.
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
    f.done("render face.safetensors take.csv -o out/face.apng --frames 2..6 --size 60x50");
    f.done("render face.safetensors take.csv -o out/around.apng --frames 2..3 --size 60x50 --turntable --count 8");
    f.done("render face.safetensors take.csv -o out/around-{frame}.png --frames 2..3 --size 60x50 --turntable --count 2");
    for (file, frames) in [("face", 4), ("around", 8)] {
        let bytes = f.read(&format!("out/{file}.apng"));
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        assert_eq!(reader.info().animation_control.unwrap().num_frames, frames);
        let mut pictures = Vec::new();
        for _ in 0..frames {
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            let delay = reader.info().frame_control.unwrap();
            assert_eq!(f64::from(delay.delay_num) / f64::from(delay.delay_den), 1.0 / 30.0);
            pictures.push(pixels);
        }
        assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]), "{file} stands still");
        if file == "around" {
            let [front, back] = [0, 1].map(|i| png(&f.read(&format!("out/around-0000{i}.png"))).1);
            assert!(pictures[0] == front && pictures[4] == back, "from the front and from behind");
        }
    }
    let whole = f.read("out/face.apng");
    let refused =
        f.rhytid("render face.safetensors take.csv -o out/face.apng --draw-on wgpu:77").output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(f.read("out/face.apng") == whole);
}

#[test]
fn what_cannot_be_drawn_is_refused_in_a_sentence() {
    let f = solved();
    for (args, words) in [
        ("-o out/face.jpg", &["out/face.jpg", "expected .png", ".mp4, .webp or .apng"][..]),
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
        ("-o out/face.png --background red", &["expected six digits", "none"]),
        ("-o out/face.png --size 30000x10", &["30000 × 10 pixels", "expected 1 to"]),
        ("-o out/face.png --show strain --stage shell --draw-on cpu:0", &["--draw-on cpu:0", "backend wgpu"]),
        ("-o out/face.png --draw-on wgpu:77", &["wgpu:77: there is none to draw with", "rhytid devices"]),
        ("-o out/face.png --show detail --stage large-scale", &["--show detail", "--stage full"]),
        ("-o out/face.png --frames 900..", &["900"]),
        ("-o nowhere/face.png", &["nowhere"]),
        ("-o out/face.png --count 400 --size 8000x8000", &["a page of", "ask for fewer or smaller"]),
    ] {
        f.refused(&format!("render face.safetensors take.csv {args}"), words);
    }
    f.assert_nothing_written();
}
