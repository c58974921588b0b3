//! What a take says of labels that nobody asked for. Alone in its file: it listens to the process's log.
use rhytid_formats::take::{Missing, decode};
use std::sync::Mutex;

struct Listener(Mutex<Vec<String>>);

impl log::Log for Listener {
    fn enabled(&self, _: &log::Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &log::Record<'_>) {
        self.0.lock().unwrap().push(format!("{} {}", record.level(), record.args()));
    }

    fn flush(&self) {}
}

static LISTENER: Listener = Listener(Mutex::new(Vec::new()));

#[test]
fn labels_that_are_not_wanted_are_one_warning() {
    log::set_logger(&LISTENER).unwrap();
    log::set_max_level(log::LevelFilter::Trace);
    let take = |labels: usize| {
        let columns: String = (0..labels).map(|i| format!(",m{i}_x,m{i}_y,m{i}_z")).collect();
        format!("time{columns}\n0{}\n1{}\n", ",1".repeat(labels * 3), ",2".repeat(labels * 3))
    };
    let wanted = ["m1".to_owned()];
    let said = || std::mem::take(&mut *LISTENER.0.lock().unwrap());

    decode(take(11).as_bytes(), "take.csv", Some(&wanted), Missing::Error).unwrap();
    assert_eq!(
        said(),
        ["WARN take.csv: columns of no handle are left out (10 labels): \
          \"m0\", \"m2\", \"m3\", \"m4\", \"m5\", \"m6\", \"m7\", \"m8\" and 2 more"]
    );
    decode(take(3).as_bytes(), "take.csv", Some(&wanted), Missing::Error).unwrap();
    assert_eq!(said(), ["WARN take.csv: columns of no handle are left out (2 labels): \"m0\", \"m2\""]);
    decode(take(3).as_bytes(), "take.csv", None, Missing::Error).unwrap();
    assert_eq!(said(), [""; 0]);
}
