//! Our own reader gives back what was written.

use super::cases::{Case, cases};
use rhytid_formats::animation;

#[test]
fn what_was_written_is_read() {
    let folder = tempfile::tempdir().unwrap();
    for case in cases() {
        let (path, written) = case.export(folder.path());
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
        assert_eq!(summary.normals, animation.with_normals);
        assert_eq!(summary.head, animation.head.is_some());
        assert_eq!(summary.provenance.as_ref(), Some(&animation.provenance));
        let corners = animation.triangle_corners.as_flattened();
        let triangles: Vec<u32> = corners.iter().map(|&c| animation.faces.indices[c as usize]).collect();
        assert_eq!(summary.faces.indices, triangles);
        assert!(
            summary.faces.counts.len() * 3 == triangles.len() && summary.faces.counts.iter().all(|&n| n == 3)
        );

        let stated = written.error.unwrap().worst;
        assert!((summary.stated_error.unwrap() - stated).abs() <= 1e-9 * stated, "{label}");
        assert_eq!(summary.strain, animation.strain.is_some(), "{label}");
        let states_strain = summary.strain && options.max_error.is_some();
        assert_eq!(summary.stated_strain_error.is_some(), states_strain, "{label}");
        let mut strain_squares = 0.0;
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
            reader.normals(k, &mut out).unwrap();
            assert_eq!(out.len(), if summary.normals { animation.rest.len() * 3 } else { 0 });
            if summary.normals && !options.quantize && options.max_error.is_none() {
                for (found, given) in out.iter().zip(&animation.frames[k][1][..99]) {
                    assert!((found - given).abs() < 1e-5, "{label}: a normal in frame {k}");
                }
            }
            reader.strain(k, &mut out).unwrap();
            let strains = animation.strain.as_ref().map(|strain| strain[k].strains.as_flattened());
            assert_eq!(out.len(), strains.map_or(0, <[f32]>::len), "{label}");
            let squares = out.iter().zip(strains.unwrap_or_default()).map(|(a, b)| f64::from(a - b).powi(2));
            strain_squares += squares.clone().sum::<f64>();
            if options.max_error.is_none() {
                assert!(squares.fold(0.0, f64::max) < 1e-12, "{label}: a strain in frame {k}");
            }
            let head = reader.head(k).unwrap();
            assert_eq!(head.is_some(), animation.head.is_some());
            let (Some(head), Some(given)) = (head, &animation.head) else { continue };
            let given = given[k].matrix();
            for (found, given) in head.as_flattened().iter().zip(given.as_flattened()) {
                assert!((found - given).abs() < 2e-5, "{label}: {head:?} in frame {k}, expected {given:?}");
            }
        }
        let rms = (strain_squares / (summary.frames * summary.vertices) as f64).sqrt();
        let stated = summary.stated_strain_error.unwrap_or(rms);
        assert!((rms - stated).abs() < 1e-6, "{label}: strains {rms} off, stated {stated}");
    }
}
