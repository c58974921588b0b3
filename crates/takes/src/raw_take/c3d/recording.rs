//! The place of a C3D file in its session: time code and events.
use super::super::{labels, timecode};
use super::header::Header;
use super::parameters::Parameters;
use rhytid_core::{Recording, TakeEvent, Timecode};

/// Reads what is there; `first` is the number of the first frame.
pub(super) fn read(header: &Header, parameters: &Parameters<'_>, first: u32) -> Recording {
    let mut events = of_group(parameters);
    if events.is_empty() {
        // The header has events only in old files, or the first of those of the group.
        let sound = header.events.iter().filter(|(_, time)| time.is_finite());
        events = sound.map(|(label, time)| TakeEvent { name: labels::text(label), time: *time }).collect();
    }
    let timecode = ["TIMECODE", "SMPTE"].into_iter().find_map(|group| timecode_of(parameters, group));
    Recording { timecode, started: None, first_frame: Some(i64::from(first)), events }
}

/// The events of the group EVENT. Their times are pairs of minutes and seconds.
fn of_group(parameters: &Parameters<'_>) -> Vec<TakeEvent> {
    let texts = |name: &str| -> Vec<String> {
        parameters.texts("EVENT", name).unwrap_or_default().into_iter().map(labels::text).collect()
    };
    let (names, contexts) = (texts("LABELS"), texts("CONTEXTS"));
    let times = parameters.numbers("EVENT", "TIMES");
    let used = parameters.count("EVENT", "USED").map_or(usize::MAX, |used| used as usize);
    let mut events = Vec::new();
    for (place, pair) in times.as_chunks::<2>().0.iter().enumerate().take(used) {
        let [minutes, seconds] = *pair;
        let time = 60.0 * minutes + seconds;
        let of = |texts: &[String]| texts.get(place).cloned().unwrap_or_default();
        let name = format!("{} {}", of(&contexts), of(&names)).trim().to_owned();
        if time.is_finite() {
            events.push(TakeEvent { name, time });
        }
    }
    events
}

/// The time code of a group that has a number for each of its parts, or one text.
fn timecode_of(parameters: &Parameters<'_>, group: &str) -> Option<Timecode> {
    let number = |names: &[&str]| names.iter().find_map(|name| parameters.number(group, name));
    let whole = |names: &[&str]| {
        let number = number(names).filter(|number| number.fract() == 0.0)?;
        (0.0..=f64::from(u16::MAX)).contains(&number).then_some(number as u32)
    };
    let text = |names: &[&str]| {
        let texts = names.iter().find_map(|name| parameters.texts(group, name));
        texts.and_then(|texts| texts.first().map(|text| labels::text(text)))
    };
    let standard = text(&["STANDARD", "FORMAT", "TYPE"]).unwrap_or_default();
    let by_parts = whole(&["HOURS", "HOUR"]).zip(whole(&["MINUTES", "MINUTE"])).map(|(hours, minutes)| {
        let [seconds, frames, subframes] =
            [&["SECONDS", "SECOND"], &["FRAMES", "FRAME"], &["SUBFRAMES", "SUBFRAME"]]
                .map(|names| whole(names).unwrap_or(0));
        Timecode { hours, minutes, seconds, frames, subframes, rate: None, drop_frame: false }
    });
    let by_text = || timecode::parse(&text(&["TIMECODE", "START", "OFFSET", "VALUE", "TIME"])?);
    let mut timecode = by_parts.filter(timecode::is_sound).or_else(by_text)?;
    let rate = number(&["RATE", "FRAME_RATE", "FPS", "STANDARD"]).filter(|&rate| timecode::is_rate(rate));
    timecode.rate = rate.or_else(|| timecode::rate(&standard));
    timecode.drop_frame |=
        timecode::drops(&standard) || number(&["DROP", "DROPFRAME", "DROP_FRAME"]) == Some(1.0);
    Some(timecode)
}
