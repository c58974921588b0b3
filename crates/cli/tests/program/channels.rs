//! Every channel in every format that carries it: a part that lacks a channel is refused, and one changed
//! number is found. Nothing here names a channel: a kind that is added to the list is tested, too.

use crate::common::{Fixture, stderr};
use rhytid::core::channel::{self, Channel};
use rhytid::core::{ChannelKind, rig_file};
use rhytid::formats::animation::{self, Format};
use rhytid::formats::export::{Frame, Options, Scene};
use rhytid::{NoProgress, Rig};
use std::path::{Path, PathBuf};

const FRAMES: usize = 6;
const CHANGED: usize = 3;

fn fixture() -> (Fixture, Rig) {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let rig = rig_file::read(&f.path("face.safetensors")).unwrap();
    (f, rig)
}

/// The option that gives frames a kind that they lack by default, and the one that takes it away.
fn options(kind: ChannelKind) -> [String; 2] {
    match kind.is_default() {
        true => [String::new(), format!("--no-{kind}")],
        false => [format!("--{kind}"), String::new()],
    }
}

fn verify(f: &Fixture, name: &str) -> (i32, String) {
    let command = format!("verify {name} --rig face.safetensors --take take.csv --device cpu:0");
    let output = f.rhytid(&command).output().unwrap();
    let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), stderr(&output));
    (output.status.code().unwrap(), said)
}

/// The same animation without some channels and with changed numbers.
/// `change` gets the numbers of each kept channel in each frame.
fn rewrite(
    rig: &Rig,
    [from, to]: [&Path; 2],
    keeps: impl Fn(&Channel) -> bool,
    mut change: impl FnMut(usize, &[Channel], &mut [Vec<f32>]),
) {
    let mut reader = animation::open(from).unwrap();
    let summary = reader.summary().clone();
    let channels: Vec<Channel> = summary.channels.iter().filter(|channel| keeps(channel)).cloned().collect();
    let corners = rig.surface().triangle_corners().unwrap();
    // The normals of the first frame, since they do not matter here.
    let mut rest_normals = Vec::new();
    reader.channel(&channel::NORMALS, 0, &mut rest_normals).unwrap();
    let scene = Scene {
        rest_normals: channels.contains(&channel::NORMALS).then_some(rest_normals.as_chunks().0),
        channels: &channels[1..],
        frames: summary.frames,
        rate: summary.rate,
        first_time_code: summary.first_time_code,
        ..Scene::new(rig, &corners, summary.recipe.as_ref().unwrap())
    };
    let mut exporter = animation::create(to, &scene, &Options::default()).unwrap();
    for k in 0..summary.frames {
        let mut numbers = vec![Vec::new(); channels.len()];
        for (channel, numbers) in channels.iter().zip(&mut numbers) {
            reader.channel(channel, k, numbers).unwrap();
        }
        change(k, &channels, &mut numbers);
        let others = channels.iter().zip(&numbers).skip(1);
        let frame = Frame::new(&numbers[0]);
        exporter
            .frame(&others.fold(frame, |frame, (channel, numbers)| frame.with(channel, numbers)))
            .unwrap();
    }
    exporter.finish(&NoProgress).unwrap();
}

/// Changes one number of a channel, at a vertex where strains have a direction, if there are strains.
fn change_one(name: &str, k: usize, channels: &[Channel], numbers: &mut [Vec<f32>]) {
    if k != CHANGED {
        return;
    }
    let strains = channels.iter().position(|channel| channel.name == channel::STRAIN.name);
    let apart = |v: &usize| strains.map_or(0.0, |at| numbers[at][2 * v] - numbers[at][2 * v + 1]);
    let vertex = (0..numbers[0].len() / 3).max_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap();
    let at = channels.iter().position(|channel| channel.name == name).unwrap();
    numbers[at][vertex * channels[at].width] += 0.5;
}

#[test]
fn one_changed_number_of_any_channel_in_any_format_is_found() {
    let (f, rig) = fixture();
    let mut found = 0;
    for kind in ChannelKind::ALL {
        for extension in ["usd", "usda", "usdz", "glb", "gltf"] {
            let name = format!("{kind}.{extension}");
            if !Format::from_extension(Path::new(&name)).unwrap().carries(kind) {
                f.refused(
                    &format!("animate face.safetensors take.csv --{kind} -o {name}"),
                    &[&format!("--{kind} is for")],
                );
                continue;
            }
            f.done(&format!(
                "animate face.safetensors take.csv --device cpu:0 --frames 0..{FRAMES} {} -o {name}",
                options(kind)[0]
            ));
            assert_eq!(verify(&f, &name).0, 0, "{name}: {}", verify(&f, &name).1);
            let channels = animation::open(&f.path(&name)).unwrap().summary().channels.clone();
            let of_kind: Vec<&Channel> =
                channels.iter().filter(|channel| channel.kind == Some(kind)).collect();
            assert!(!of_kind.is_empty(), "{name} has nothing of it");
            for channel in of_kind.into_iter().chain([&channel::POSITIONS]) {
                let changed = format!("changed.{extension}");
                let paths = [f.path(&name), f.path(&changed)];
                rewrite(
                    &rig,
                    paths.each_ref().map(PathBuf::as_path),
                    |_| true,
                    |k, channels, numbers| change_one(&channel.name, k, channels, numbers),
                );
                let (code, said) = verify(&f, &changed);
                assert!(
                    code == 1
                        && said.contains(&*channel.words)
                        && said.contains(&format!("first in frame {CHANGED}")),
                    "{name}, {}: {code} {said}",
                    channel.name
                );
                found += 1;
            }
        }
    }
    assert!(found > 40, "{found}");
}

#[test]
fn a_part_without_a_channel_is_no_part_and_a_file_without_it_is_not_sound() {
    let (f, rig) = fixture();
    for kind in ChannelKind::ALL {
        let [with, without] = options(kind);
        let part = |frames: &str, option: &str, name: &str| {
            f.done(&format!(
                "animate face.safetensors take.csv --device cpu:0 --frames {frames} {option} -o {name}"
            ));
        };
        part("0..4", &with, "a.usd");
        part("4..7", &with, "b.usd");
        part("4..7", &without, "c.usd");
        f.done("stitch a.usd b.usd -o whole.usda");
        assert_eq!(verify(&f, "whole.usda").0, 0, "{kind}");
        f.refused("stitch a.usd c.usd -o out/whole.usda", &["c.usd", kind.name()]);
        // The recipe still lists the channel.
        let paths = [f.path("a.usd"), f.path("lacks.usd")];
        rewrite(
            &rig,
            paths.each_ref().map(PathBuf::as_path),
            |channel| channel.kind != Some(kind),
            |_, _, _| {},
        );
        let (code, said) = verify(&f, "lacks.usd");
        assert!(code == 1 && said.contains("lacks, expected has"), "{kind}: {code} {said}");
    }
}

/// A sound file whose numbers were then all multiplied by a factor.
#[test]
fn sigma_times_ten_is_not_sound() {
    let (f, rig) = fixture();
    f.done("animate face.safetensors take.csv --device cpu:0 --frames 0..4 --sigma -o a.usda");
    let paths = [f.path("a.usda"), f.path("changed.usda")];
    rewrite(
        &rig,
        paths.each_ref().map(PathBuf::as_path),
        |_| true,
        |_, channels, numbers| {
            let sigma = channels.iter().position(|channel| channel.name == channel::SIGMA.name).unwrap();
            numbers[sigma].iter_mut().for_each(|x| *x *= 10.0);
        },
    );
    let (code, said) = verify(&f, "changed.usda");
    assert!(code == 1 && said.contains("standard deviations"), "{code} {said}");
}

/// A handle's name has no meaning, even if it reads “… as it was”.
#[test]
fn a_handle_called_as_it_was_means_nothing() {
    let (f, rig) = fixture();
    let (old, new) = (&rig.handles().labels[4], format!("{} as it was", rig.handles().labels[1]));
    let renamed = |text: String| {
        let mut lines = text.lines().map(str::to_owned).collect::<Vec<_>>();
        for line in &mut lines {
            let cell = |cell: &str| match cell.strip_prefix(old.as_str()) {
                Some(rest) if ["", "_x", "_y", "_z"].contains(&rest) => format!("{new}{rest}"),
                _ => cell.to_owned(),
            };
            *line = line.split(',').map(cell).collect::<Vec<_>>().join(",");
        }
        lines.join("\n") + "\n"
    };
    f.done("animate face.safetensors take.csv --device cpu:0 --frames 0..12 -o plain.usd");
    for name in ["markers.csv", "take.csv"] {
        f.write(name, renamed(f.read_text(name)));
    }
    f.done("solve face.toml -o odd.safetensors");
    assert_eq!(rig_file::read(&f.path("odd.safetensors")).unwrap().handles().labels[4], new);
    f.done("animate odd.safetensors take.csv --device cpu:0 --frames 0..12 -o odd.usd");
    let [mut plain, mut odd] = ["plain.usd", "odd.usd"].map(|name| animation::open(&f.path(name)).unwrap());
    let [mut a, mut b] = [Vec::new(), Vec::new()];
    for frame in 0..12 {
        plain.positions(frame, &mut a).unwrap();
        odd.positions(frame, &mut b).unwrap();
        assert_eq!(a, b, "frame {frame}");
    }
}
