//! Real marker tracks, where `../shared/data` lies beside the repository.
use rhytid_formats::tables::read_handles;
use rhytid_formats::take::{Missing, read, write};
use rhytid_test_support::shared;
use std::io::Write;
use std::time::{Duration, Instant};

#[test]
fn the_real_markers_and_take_are_read_whole_and_fast() {
    let (Some(markers), Some(clean)) = (shared("data/markers.csv"), shared("data/takes/rom_3_clean.csv"))
    else {
        return;
    };
    let handles = read_handles(&markers).unwrap();
    assert_eq!((handles.labels.len(), handles.len()), (89, 89));
    assert_eq!((handles.labels[0].as_str(), handles.points[0].nearest_vertex().0), ("jaw00", 1278));

    let start = Instant::now();
    let take = read(&clean, Some(&handles.labels), Missing::Error).unwrap();
    let taken = start.elapsed();
    let _ = writeln!(std::io::stderr(), "{} frames read in {taken:.2?}", take.frames());
    assert_eq!((take.frames(), take.labels.len()), (4030, 89));
    assert_eq!(take.labels, handles.labels);
    // Fifty times the usual duration, for a busy machine.
    assert!(taken < Duration::from_secs(10), "{taken:?}");

    // The last row of the file, cell by cell, by other means.
    let text = std::fs::read_to_string(&clean).unwrap();
    let (header, last) = (text.lines().next().unwrap(), text.lines().last().unwrap());
    for (column, cell) in header.split(',').zip(last.split(',')) {
        let cell: f64 = cell.parse().unwrap();
        let Some((label, axis)) = column.rsplit_once('_') else {
            assert_eq!(take.times[4029], cell);
            continue;
        };
        let j = handles.labels.iter().position(|l| l == label).unwrap();
        let axis = ["x", "y", "z"].iter().position(|a| *a == axis).unwrap();
        assert_eq!(take.positions[4029 * 89 + j][axis], cell, "{column}");
    }

    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("copy.csv");
    write(&copy, &take).unwrap();
    assert_eq!(read(&copy, None, Missing::Error).unwrap(), take);
}

#[test]
fn the_real_take_has_its_true_rate_although_its_times_are_rounded() {
    let Some(clean) = shared("data/takes/rom_3_clean.csv") else { return };
    assert_eq!(read(&clean, None, Missing::Error).unwrap().rate(), 30.0);
}
