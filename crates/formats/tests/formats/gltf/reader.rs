//! Rhytid's own reader returns the same frames that were written.

use super::cases::{Case, cases};
use rhytid_core::ChannelKind;
use rhytid_core::channel::{self, Channel};
use rhytid_formats::animation::{self, Format};

#[test]
fn what_was_written_is_read() {
    let folder = tempfile::tempdir().unwrap();
    for case in cases() {
        let (path, written) = case.export(folder.path());
        let triangle_corners = case.corners();
        let Case { animation, options, label, .. } = case;
        let mut reader = animation::open(&path).unwrap_or_else(|e| panic!("{label}: {e}"));
        let summary = reader.summary().clone();
        assert_eq!(summary.name, animation.name);
        assert_eq!(summary.vertices, animation.rest.len());
        assert_eq!(summary.frames, animation.frames.len());
        assert_eq!((summary.rate, summary.first_time_code), (animation.rate, animation.first_time_code));
        assert_eq!(
            (summary.metres_per_unit, summary.up_axis),
            (animation.metres_per_unit, animation.up_axis)
        );
        assert_eq!(summary.has(&channel::NORMALS), animation.with_normals);
        assert_eq!(summary.head, animation.head.is_some());
        let stated = summary.recipe.as_ref().unwrap();
        assert_eq!(stated.difference(&animation.recipe, &[]), None, "{label}");
        assert_eq!(summary.fitted, options.max_error.is_some() && summary.frames > 1, "{label}");
        let corners = triangle_corners.as_flattened();
        let triangles: Vec<u32> = corners.iter().map(|&c| animation.faces.indices[c as usize]).collect();
        assert_eq!(summary.faces.indices, triangles);
        assert!(
            summary.faces.counts.len() * 3 == triangles.len() && summary.faces.counts.iter().all(|&n| n == 3)
        );

        let stated = written.errors[0].worst;
        assert!((summary.stated_error.unwrap().worst - stated).abs() <= 1e-9 * stated, "{label}");
        let fitted = options.max_error.is_some();
        let format = Format::from_extension(&path).unwrap();
        let stored = format.stored(&animation.channels(), fitted);
        let names = |channels: &[Channel]| {
            let mut names: Vec<_> = channels.iter().map(|channel| channel.name.clone()).collect();
            names.sort_unstable();
            names
        };
        assert_eq!(names(&summary.channels[1..]), names(&stored), "{label}");
        // The file states the error of an attribute over all channels in it.
        let mut squares: Vec<(Channel, f64)> = stored
            .iter()
            .filter(|channel| channel.name != "normals")
            .map(|channel| (channel.clone(), 0.0))
            .collect();
        let mut out = Vec::new();
        // In any order.
        for k in (0..summary.frames).rev() {
            reader.positions(k, &mut out).unwrap();
            assert_eq!(out.len(), animation.rest.len() * 3);
            for (found, given) in out.as_chunks::<3>().0.iter().zip(animation.frames[k][0].as_chunks::<3>().0)
            {
                let squares = found.iter().zip(given).map(|(a, b)| f64::from(a - b).powi(2));
                let off = squares.sum::<f64>().sqrt();
                assert!(off <= stated, "{label}: {off} in frame {k}, stated {stated}");
            }
            reader.channel(&channel::NORMALS, k, &mut out).unwrap();
            let has_normals = summary.has(&channel::NORMALS);
            assert_eq!(out.len(), if has_normals { animation.rest.len() * 3 } else { 0 });
            if has_normals && !options.quantize && options.max_error.is_none() {
                for (found, given) in out.iter().zip(&animation.frames[k][1][..99]) {
                    assert!((found - given).abs() < 1e-5, "{label}: a normal in frame {k}");
                }
            }
            for (channel, sum) in &mut squares {
                reader.channel(channel, k, &mut out).unwrap();
                let expected = &animation.other(channel).unwrap()[k];
                assert_eq!(out.len(), expected.len(), "{label}: {}", channel.name);
                let squares = out.iter().zip(expected).map(|(a, b)| f64::from(a - b).powi(2));
                *sum += squares.clone().sum::<f64>();
                if !fitted {
                    assert!(squares.fold(0.0, f64::max) < 1e-12, "{label}: {} in frame {k}", channel.name);
                }
            }
            let head = reader.head(k).unwrap();
            assert_eq!(head.is_some(), animation.head.is_some());
            let (Some(head), Some(given)) = (head, &animation.head) else { continue };
            let given = given[k].matrix();
            for (found, given) in head.as_flattened().iter().zip(given.as_flattened()) {
                assert!((found - given).abs() < 2e-5, "{label}: {head:?} in frame {k}, expected {given:?}");
            }
        }
        for (channel, sum) in &squares {
            let rms = (sum / (summary.frames * summary.vertices) as f64).sqrt();
            let stated = summary.stated_channel_error(channel);
            assert_eq!(stated.is_some(), fitted, "{label}: {}", channel.name);
            let Some(stated) = stated else { continue };
            match channel.kind {
                Some(ChannelKind::Strain) => {
                    assert!((rms - stated.rms).abs() < 1e-6, "{label}: {rms}, {}", stated.rms);
                }
                // It is one of three in its attribute.
                _ => assert!(rms <= stated.rms + 1e-6, "{label}: {rms}, {}", stated.rms),
            }
        }
    }
}
