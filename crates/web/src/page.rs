//! The results, as a piece of the page.
use crate::face::{ALLOWED, Face};
use maud::html;
use rhytid_conformance::{Report, Verdict};

/// The text of a report and of a face: a piece of HTML for the page that ran them.
pub fn page(report: &Report, face: &Face) -> String {
    let passed = report.passed() && face.passed();
    html! {
        p .verdict .passed[passed] .failed[!passed] {
            @if passed { "Passed: this browser computes the same results as other devices." }
            @else { "Failed: do not trust the results of this browser." }
        }
        @for device in &report.devices {
            dl {
                div { dt { "device" } dd { (device.device.name) } }
                div { dt { "driver" } dd { (device.device.driver) } }
                @if device.software_driver {
                    div { dt { "kind" } dd { "a software driver; the results say nothing about how fast or exact a GPU is" } }
                }
                @if let Some(bytes) = device.device.max_binding_bytes {
                    div { dt { "largest binding" } dd { (binding(bytes)) } }
                }
                div { dt { "outcomes" } dd {
                    (device.count(Verdict::Pass)) " of " (device.outcomes.len()) " passed in "
                    (format!("{:.1} s", device.wall_seconds))
                } }
                div { dt { "a face of " (face.vertices) " vertices in " (face.frames()) " poses" } dd {
                    "off by at most " (format!("{:.1e}", face.off)) " of its size; " (format!("{ALLOWED:.0e}")) " is allowed"
                } }
            }
            div .wide { table {
                thead { tr {
                    th { "stage" } th { "kernel" } th .number { "cases" } th .number { "of bound" } th .number { "ulp" }
                } }
                tbody {
                    @for stage in device.summary() {
                        tr {
                            td { (stage.stage) } td { (stage.kernel) } td .number { (stage.cases) }
                            td .number { (format!("{:.3}", stage.part_of_bound)) }
                            td .number { (stage.ulp.map_or_else(|| "–".to_owned(), |ulp| format!("{ulp:.2}"))) }
                        }
                    }
                }
            } }
            @let exceptions = device.outcomes.iter().filter(|outcome| outcome.verdict != Verdict::Pass);
            @for outcome in exceptions {
                p .failed[!outcome.is_acceptable()] {
                    (outcome.verdict.to_string()) ": " (outcome.name) ": " (outcome.reason)
                }
            }
        }
    }
    .into_string()
}

/// `1024 MiB`, `64 KiB`.
fn binding(bytes: u64) -> String {
    if bytes >= 1 << 20 { format!("{} MiB", bytes >> 20) } else { format!("{} KiB", bytes >> 10) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_backend_cpu::Cpu;
    use rhytid_conformance::{Case, Suite, run_device};
    use rhytid_core::{Backend, Device};

    #[test]
    fn what_failed_is_named_and_what_is_written_is_escaped() {
        let info = Cpu::devices().unwrap().remove(0);
        let device = Device::open::<Cpu>(&info).unwrap();
        // The must-pass list reports cases that did not run.
        let first = |_: &Case, done: usize, _: usize| done < 1;
        let mut report = run_device(&device, Suite::Quick, first);
        report.device.name = "<b>A & B</b>".into();
        let report = Report::new(Suite::Quick, None, vec![report], Vec::new());
        let face = Face { vertices: 1, handle_positions: vec![0.0; 3], positions: vec![0.0; 3], off: 1e-7 };
        let html = page(&report, &face);
        for part in [
            "&lt;b&gt;A &amp; B",
            "Failed",
            "must-pass",
            "did not report",
            "1.0e-7 of its size",
            "fine_scale",
        ] {
            assert!(html.contains(part), "{part} is missing in:\n{html}");
        }
        assert!(!html.contains("<b>"), "{html}");
        assert_eq!([binding(64 << 10), binding(1 << 30)], ["64 KiB", "1024 MiB"]);
    }
}
