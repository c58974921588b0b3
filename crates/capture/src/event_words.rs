//! What a person should read of a clean-up: a sentence for each kind of event.
use crate::clean::MODEL_CONFIDENCE;
use crate::{Event, Kind, Pose};
use rhytid_core::{Remedy, Warning, human};
use std::cmp::{Ordering, Reverse};

/// Steps that a warning names.
const NAMED_STEPS: usize = 3;

/// A pose that is less like its example is worth a look.
const LIKE: f64 = 0.6;

/// A warning about poses that differ from their example.
pub(crate) fn unlike(poses: &[Pose]) -> Option<String> {
    let worst =
        poses.iter().min_by(|a, b| a.likeness.total_cmp(&b.likeness)).filter(|pose| pose.likeness < LIKE)?;
    Some(format!(
        "in frame {} the actor's expression differs from the example “{}” (likeness {:.2} of 1); look at \
         this frame, or leave the pose out",
        worst.frame, worst.example, worst.likeness
    ))
}

/// Warnings that a person should read before the take is used: a sentence for each kind of event.
pub(crate) fn not_to_be_trusted(events: &[Event], labels: &[String], rate: f64) -> Vec<Warning> {
    let of = |kind: Kind| events.iter().filter(move |e| e.kind == kind);
    let never: Vec<&str> = of(Kind::NeverSeen).filter_map(|e| Some(&labels[e.marker?][..])).collect();
    let mut sentences = Vec::new();
    let seconds = |frame: usize| frame as f64 / rate;
    if let Some(first) = of(Kind::Slide).max_by_key(|e| (e.frames, Reverse(e.first))) {
        let name = |marker: Option<usize>| marker.map_or("another place", |j| &labels[j][..]);
        let warning = Warning::from(format!(
            "a label slid off its marker {}, and these stretches were cut out: in the longest, {} slid to {} \
             in frames {}..{} ({:.2} s); look at it: `skip` of slides keeps such stretches, `drop` cuts out \
             a stretch by hand",
            human::counted(of(Kind::Slide).count(), "time"),
            name(first.marker),
            name(first.other),
            first.first,
            first.first + first.frames,
            seconds(first.first)
        ));
        sentences.push(warning.with_remedies(&[Remedy::KeepSlides, Remedy::DropStretch]));
    }
    sentences.extend(shuffled(events, labels, rate));
    let mut steps: Vec<&Event> = of(Kind::Step).collect();
    if !steps.is_empty() {
        let count = steps.len();
        steps.sort_by(|a, b| b.distance_mm.partial_cmp(&a.distance_mm).unwrap_or(Ordering::Equal));
        steps.truncate(NAMED_STEPS);
        let of_step = |e: &&Event| {
            let name = e.marker.map_or("", |j| &labels[j][..]);
            format!(
                "{name} by {:.0} mm in frame {} ({:.2} s)",
                e.distance_mm.unwrap_or(0.0),
                e.first,
                seconds(e.first)
            )
        };
        let named: Vec<String> = steps.iter().map(of_step).collect();
        let warning = Warning::from(format!(
            "markers move against their neighbours as no skin does, {}: {}{}; look for labels that are swapped \
             there, and exchange them or drop the stretch by hand",
            human::counted(count, "time"),
            named.join(", "),
            if count > NAMED_STEPS { " …" } else { "" }
        ));
        sentences.push(warning.with_remedies(&[Remedy::DropStretch]));
    }
    if let Some(worst) =
        of(Kind::Strain).max_by(|a, b| a.strain.partial_cmp(&b.strain).unwrap_or(Ordering::Equal))
    {
        let name = |marker: Option<usize>| marker.map_or("", |j| &labels[j][..]);
        sentences.push(
            format!(
                "between {} and {} the skin is stretched by {} in frame {} ({:.2} s), far beyond any \
                 example (such stretches: {}); look for a label that slid or was swapped, or that names \
                 another place on the rig",
                name(worst.marker),
                name(worst.other),
                human::percent(worst.strain.unwrap_or(0.0), 0),
                worst.first,
                seconds(worst.first),
                human::count(of(Kind::Strain).count())
            )
            .into(),
        );
    }
    if !never.is_empty() {
        let what = "their markers are never seen";
        sentences.push(
            format!("handles that follow their neighbours, because {what}: {}", never.join(", ")).into(),
        );
    }
    if let Some(longest) = of(Kind::Lost).max_by_key(|e| (e.frames, Reverse(e.first))) {
        sentences.push(format!(
            "{} gaps could not be filled soundly, and have a confidence of 0: the longest lasts {:.1} s from \
             frame {}",
            of(Kind::Lost).count(),
            longest.frames as f64 / rate,
            longest.first
        ).into());
    }
    sentences
}

/// A warning about labels that were put right, and about markers that were dropped where labels may be wrong.
fn shuffled(events: &[Event], labels: &[String], rate: f64) -> Option<Warning> {
    let is_dropped = |e: &&Event| e.confidence <= MODEL_CONFIDENCE;
    let (dropped, put_right): (Vec<&Event>, Vec<&Event>) =
        events.iter().filter(|e| e.kind == Kind::Shuffled).partition(is_dropped);
    let stretch = |of: &[&Event]| {
        let longest = of.iter().max_by_key(|e| (e.frames, Reverse(e.first)))?;
        let is_in = |e: &&&Event| e.first == longest.first && e.frames == longest.frames;
        let names: Vec<&str> =
            of.iter().filter(is_in).filter_map(|e| Some(labels[e.marker?].as_str())).collect();
        Some(format!(
            "{} in frames {}..{} ({:.2} s)",
            names.join(", "),
            longest.first,
            longest.first + longest.frames,
            longest.first as f64 / rate
        ))
    };
    let of_dropped = stretch(&dropped).map(|longest| {
        let times = human::counted(dropped.len(), "time");
        format!(
            "positions were dropped and filled {times}, with a low confidence; the longest stretch is that of {longest}"
        )
    });
    let sentence = match (stretch(&put_right), of_dropped) {
        (None, None) => return None,
        (Some(longest), None) => {
            format!("labels change places, and were put right; the longest stretch is that of {longest}")
        }
        (None, Some(dropped)) => {
            format!(
                "labels seem to change places, and markers are not where the motion of the others expects \
                 them: {dropped}"
            )
        }
        (Some(longest), Some(dropped)) => format!(
            "labels change places, and were put right where that is clear; the longest stretch is that of \
             {longest}; elsewhere {dropped}"
        ),
    };
    let warning =
        Warning::from(format!("{sentence}; look at these frames, and drop by hand what is still wrong"));
    Some(warning.with_remedies(&[Remedy::DropStretch]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clean::SHUFFLED_CONFIDENCE;
    use crate::events::event;

    #[test]
    fn only_what_became_of_labels_is_said_of_them() {
        let labels: Vec<String> = ["chin", "lip", "brow"].map(String::from).into();
        let put_right = |marker: usize| event(Kind::Shuffled, marker, 100..160, SHUFFLED_CONFIDENCE);
        let dropped = |marker: usize| event(Kind::Shuffled, marker, 300..312, MODEL_CONFIDENCE);
        let said = |events: &[Event]| shuffled(events, &labels, 120.0).map(|w| w.sentence().to_owned());
        assert_eq!(said(&[]), None);
        let words = said(&[put_right(0), put_right(1)]).unwrap();
        assert!(
            words.contains("were put right;") && words.contains("chin, lip in frames 100..160"),
            "{words}"
        );
        assert!(!words.contains("dropped and filled"), "{words}");
        let words = said(&[dropped(1), dropped(2)]).unwrap();
        assert!(
            words.contains("2 times") && words.contains("lip, brow in frames 300..312 (2.50 s)"),
            "{words}"
        );
        assert!(!words.contains("put right"), "{words}");
        let words = said(&[put_right(0), put_right(1), dropped(1)]).unwrap();
        assert!(words.contains("chin, lip in frames 100..160"), "{words}");
        assert!(words.contains("elsewhere positions were dropped and filled 1 time"), "{words}");
    }
}
