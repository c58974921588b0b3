//! Vicon's CSV.
use super::{has_no_rate, is_missing, read, refused, warns};
use rhytid_formats::raw_take::decode;

const NAME: &str = "trial.csv";

/// All sections that Nexus writes, with trajectories among them.
const FILE: &str = "\
Events\n120\nSubject,Context,Name,Time (s),Description\nAnna,Left,Foot Strike,1.25,x\nAnna,General,Clap,2.5,\n\n\
Devices\n1200\n,,AMTI - Force,,\nFrame,Sub Frame,Fx,Fy,Fz\n,,N,N,N\n1,0,1,2,3\n1,1,1,2,3\n\n\
Model Outputs\n120\n,,Anna:LKneeAngles,,\nFrame,Sub Frame,X,Y,Z\n,,deg,deg,deg\n241,0,10,20,30\n\n\
Trajectories\n120\n,,Anna:jaw00,,,Anna:lip,,,Trajectory Count\nFrame,Sub Frame,X,Y,Z,X,Y,Z,Count\n\
,,mm,mm,mm,mm,mm,mm,\n241,0,1,2,3,4,5,6,2\n242,0,1.5,2,3,,,,1\n243,0,2,2,3,7,8,9,2\n\n\
Joints\n120\n,,Anna:Head,,\nFrame,Sub Frame,RX,RY,RZ\n,,deg,deg,deg\n241,0,1,2,3\n";

#[test]
fn trajectories_are_found_among_other_sections() {
    let take = read(FILE.as_bytes(), NAME);
    assert_eq!(take.warnings, [""; 0]);
    assert_eq!(take.tracks.labels, ["Anna:jaw00", "Anna:lip"]);
    assert_eq!(take.metres_per_unit, Some(0.001));
    assert_eq!(take.tracks.times, [240.0 / 120.0, 241.0 / 120.0, 242.0 / 120.0]);
    let p = &take.tracks.positions;
    assert_eq!((p[0], p[1], p[2]), ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [1.5, 2.0, 3.0]));
    assert!(is_missing(&p[3]));
    assert_eq!(p[5], [7.0, 8.0, 9.0]);
    let events: Vec<(&str, f64)> = take.recording.events.iter().map(|e| (e.name.as_str(), e.time)).collect();
    assert_eq!(events, [("Left Foot Strike", 1.25), ("General Clap", 2.5)]);

    let alone = &FILE[FILE.find("Trajectories\n").unwrap()..FILE.find("Joints").unwrap()];
    let alone = read(alone.as_bytes(), NAME);
    assert_eq!(format!("{:?}", alone.tracks), format!("{:?}", take.tracks));
    // Velocities beside the positions are no markers.
    let with = FILE.replace("X,Y,Z,Count", "X,Y,Z,X',Y',Z'").replace(",mm,\n", ",mm,mm/s,mm/s,mm/s\n");
    assert_eq!(read(with.as_bytes(), NAME).tracks.labels, take.tracks.labels);
}

/// As Vicon's Workstation and Nexus 1 write it.
const WORKSTATION: &str = "\
ANALOG\n1000,Hz\nSample #,Fx\n1,0.5\n2,0.5\n\n\
TRAJECTORIES\n100,Hz\n,Anna:jaw00,,,Anna:lip,,\nField #,X,Y,Z,X,Y,Z\n11,1,2,3,4,5,6\n12,1.5,2,3,,,\n\n\
EVENTS\n100,Hz\n";

#[test]
fn older_programs_of_vicon_have_other_words() {
    for text in [WORKSTATION, &WORKSTATION[WORKSTATION.find("TRAJ").unwrap()..]] {
        let take = read(text.as_bytes(), NAME);
        assert_eq!(take.tracks.labels, ["Anna:jaw00", "Anna:lip"]);
        assert_eq!(take.tracks.times, [10.0 / 100.0, 11.0 / 100.0]);
        assert_eq!(take.tracks.positions[..2], [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        assert!(is_missing(&take.tracks.positions[3]));
        // The program writes no line of units.
        assert!(take.metres_per_unit.is_none() && warns(&take, "names no unit"), "{:?}", take.warnings);
        assert_eq!(take.warnings.len(), 1, "{:?}", take.warnings);
    }
}

#[test]
fn what_is_wrong_is_said() {
    let without = FILE.replace("Trajectories\n", "Something\n");
    let said = refused(without.as_bytes(), NAME);
    assert!(said.contains("no section Trajectories, but Model Outputs, Devices, Joints, Events"), "{said}");
    let rate = FILE.replace("Trajectories\n120", "Trajectories\nx");
    has_no_rate(rate.as_bytes(), NAME);
    assert_eq!(decode(rate.as_bytes(), NAME, Some(60.0)).unwrap().tracks.times[0], 4.0);
    let unit = read(FILE.replace("mm", "").as_bytes(), NAME);
    assert!(unit.metres_per_unit.is_none() && warns(&unit, "the line of units names no unit"));
    assert!(
        refused(FILE.replace("1.5,2,3", "1.5,two,3").as_bytes(), NAME).contains("line 28: cell 4 is \"two\"")
    );
    let start = FILE.find("Trajectories").unwrap();
    for cut in 0..FILE.len() {
        match decode(&FILE.as_bytes()[..cut], NAME, None) {
            Ok(take) => super::check(&take),
            Err(_) => assert!(cut < start + 150, "{cut}"),
        }
    }
}
