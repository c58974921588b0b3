//! The beginning of a page: what to do, and the findings that matter most.

use maud::{Markup, html};

/// More findings than this are not read.
const MOST: usize = 3;

/// A finding, with a picture of it where there is one.
pub(crate) struct Finding {
    pub words: Markup,
    pub picture: Option<Markup>,
}

/// The verdict, a sentence to act on, and at most three findings below it.
pub(crate) fn opening(verdict: &str, findings: &[Finding]) -> Markup {
    html! {
        section.opening {
            p.verdict { (verdict) }
            @if !findings.is_empty() {
                ol.findings {
                    @for Finding { words, picture } in findings.iter().take(MOST) {
                        li { @if let Some(picture) = picture { (picture) } p { (words) } }
                    }
                }
            }
        }
    }
}
