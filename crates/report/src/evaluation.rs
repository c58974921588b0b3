//! The page of an evaluation: the quality of a rig, and where it is low.

use crate::document::document;
use crate::map::{self, Figure};
use crate::opening::{Finding, opening};
use crate::painter::Painter;
use crate::shot::left_out;
use crate::skin::Skin;
use crate::written::{Page, write_texts};
use maud::{Markup, html};
use rhytid_core::{Error, Result, Rig, human, scale};
use rhytid_evaluate::{Comparison, Errors, Evaluation, LeaveOneOut, LeftOut, Map, RegionError, Subject};

/// The number of regions that are named for one example.
const NAMED: usize = 3;

/// Noise is worth a word where it moves a region by more than this multiple of its size per axis. A marker
/// itself moves by 1.7 times this size.
const LOUD: f64 = 3.0;

/// The number of regions that are listed at first.
const REGIONS: usize = 10;

/// Writes `evaluation.html` and `evaluation.json` to the folder of `to`. `maps` are of `rig`. Without a
/// `painter`, the page has a sentence in place of the maps.
///
/// # Errors
/// [`Error::Io`] if a file cannot be written. [`Error::Device`] and [`Error::Input`] if the painter cannot
/// draw. [`Error::Internal`] if a map has other vertices than the rig.
pub fn write_evaluation(
    to: Page<'_>,
    found: &Evaluation,
    maps: &[Map],
    rig: &Rig,
    painter: Option<&Painter>,
) -> Result<()> {
    if maps.iter().any(|map| map.values.len() != rig.vertices()) {
        return Err(Error::Internal("a map of the evaluation has other vertices than the rig".into()));
    }
    let page = page(to.title, found, maps, rig, painter)?;
    let json =
        serde_json::to_string(found).map_err(|e| Error::Internal(format!("the evaluation as JSON: {e}")))?;
    write_texts(to.folder, [("evaluation.html", page), ("evaluation.json", json)])
}

fn page(
    title: &str,
    found: &Evaluation,
    maps: &[Map],
    rig: &Rig,
    painter: Option<&Painter>,
) -> Result<String> {
    let about = html! {
        "Evaluation of the rig: " (human::count(found.vertices)) " vertices, " (human::counted(found.handles, "handle"))
        ", " (human::counted(rig.examples().len(), "example"))
    };
    let drawn = painter.map(|painter| Drawn::new(maps, rig, painter)).transpose()?;
    let of = |subject: Subject| drawn.as_ref().map(|drawn| drawn.section(subject));
    let main = html! {
        (opening(&verdict(found), &findings(found, maps, drawn.as_ref())))
        @if painter.is_none() { (left_out()) }
        @if let Some(comparisons) = &found.truth {
            section {
                h2 { "Distance from the truth" }
                p { "The tables cover all frames of the truth. “learned” and “chapter” are the rig by either method. “shell” is the thin "
                    "shell alone, which no example influences. “blendshapes” mixes the examples with weights from 0 to 1, and “components” "
                    "mixes their principal components with any weights. “components+shell” adds the shell, moved by what that leaves of "
                    "the markers. The wrinkle band is the RMS error without its smooth part." }
                (methods(comparisons))
                (method_regions(comparisons))
                @if let Some(maps) = of(Subject::Truth) { (maps) }
            }
        }
        section {
            h2 { "Error of examples that are left out" }
            @match &found.leave_one_out {
                Some(errors) => {
                    p { "Each example is left out in turn, and the others predict its smooth part. The table shows the error of this "
                        "prediction, over the skin by area. The level is pessimistic, because each example is far from the others. "
                        "Another scan helps most where the error is large." }
                    (examples(errors))
                    @if let Some(maps) = of(Subject::LeaveOneOut) { (maps) }
                }
                None => p { "Only a rig of the learned method has these numbers, and only with examples." }
            }
        }
        section {
            h2 { "Effect of marker noise" }
            p { "Every marker gets " (found.noise.noise_mm) " mm of noise per axis, at rest and in the examples. The skin then moves by "
                (mm(found.noise.errors.skin.rms_mm)) " mm RMS, and by " (mm(found.noise.errors.skin.worst_mm)) " mm at most."
                @if let Some(others) = found.noise.errors.others_rms_mm { " Other parts move by " (mm(others)) " mm RMS." } }
            @if let Some(maps) = of(Subject::Noise) { (maps) }
        }
    };
    Ok(document(title, &about, &main))
}

/// How good the rig is, and what to do about it.
fn verdict(found: &Evaluation) -> String {
    let region = |errors: &Errors| errors.skin_regions().next().map(|worst| worst.region.clone());
    if let Some(own) = found.truth.as_ref().and_then(|all| all.first()) {
        let look =
            region(&own.errors).map_or(String::new(), |region| format!(" Look at the {region} first."));
        return format!(
            "The skin is {} mm from the truth (RMS), and 95 % of it within {} mm.{look}",
            short(own.errors.skin.rms_mm),
            short(own.errors.skin.p95_mm),
        );
    }
    match &found.leave_one_out {
        Some(LeaveOneOut { all, .. }) => {
            let next = region(all).map_or(String::new(), |region| {
                format!(" If you scan one more expression, choose one that moves the {region}.")
            });
            format!(
                "An expression without a scan is about {} mm off on the skin (RMS).{next}",
                short(all.skin.rms_mm)
            )
        }
        None => {
            "No example was left out, so how good the rig is can only be seen by comparing it with a truth."
                .to_owned()
        }
    }
}

/// What matters most, each with its map.
fn findings(found: &Evaluation, maps: &[Map], drawn: Option<&Drawn<'_>>) -> Vec<Finding> {
    let picture = |subject: Subject, title: &str| {
        let place = maps.iter().position(|map| map.subject == subject && map.title.ends_with(title))?;
        Some(drawn?.figures[place].again.clone())
    };
    let places = |errors: &Errors| {
        let named = errors.skin_regions().take(NAMED);
        named.map(|r| format!("{} ({} mm)", r.region, short(r.rms_mm))).collect::<Vec<_>>().join(", ")
    };
    let mut findings = Vec::new();
    if let Some(own) = found.truth.as_ref().and_then(|all| all.first()) {
        findings.push(Finding {
            words: html! { b { "Farthest from the truth: " } (places(&own.errors)) "." },
            picture: picture(Subject::Truth, own.method),
        });
    }
    let left_out = found.leave_one_out.iter().flat_map(|left_out| &left_out.examples);
    let mut by_error: Vec<&LeftOut> = left_out.collect();
    by_error.sort_by(|a, b| b.errors.skin.rms_mm.total_cmp(&a.errors.skin.rms_mm));
    if let Some(worst) = by_error.first() {
        findings.push(Finding {
            words: html! {
                b { "Hardest without a scan: " (worst.example) "." } " Left out, it is " (short(worst.errors.skin.rms_mm))
                " mm off, most in " (places(&worst.errors)) ". Scan another expression of this kind."
            },
            picture: picture(Subject::LeaveOneOut, &worst.example),
        });
    }
    let noise = &found.noise;
    let worst = noise.errors.skin_regions().next().map_or(0.0, |region| region.rms_mm);
    findings.push(Finding {
        words: html! {
            @if worst > LOUD * noise.noise_mm {
                b { "Noise of the markers shows in " (places(&noise.errors)) "." } " Use soft markers, or more handles there."
            } @else {
                b { "Noise of the markers does no harm." } " " (noise.noise_mm) " mm of it moves no region by more than " (short(worst)) " mm."
            }
        },
        picture: picture(Subject::Noise, ""),
    });
    findings
}

/// All maps, drawn.
struct Drawn<'a> {
    maps: &'a [Map],
    /// The numbers of the maps on the skin.
    of_skin: Vec<Vec<f32>>,
    figures: Vec<Figure>,
    /// What is inside the skin, by subject, with the end of its scale.
    inside: Vec<Inside>,
    painter: &'a Painter,
}

/// The first map of a subject, without the skin.
struct Inside {
    subject: Subject,
    figure: Figure,
    end: f32,
    values: Vec<f32>,
}

impl Inside {
    /// Its numbers, as far as there are any: all that is drawn has one.
    fn finite(&self) -> Vec<f32> {
        self.values.iter().copied().filter(|x| !x.is_nan()).collect()
    }
}

impl<'a> Drawn<'a> {
    fn new(maps: &'a [Map], rig: &Rig, painter: &'a Painter) -> Result<Self> {
        let skin = Skin::new(rig);
        let of_skin: Vec<Vec<f32>> = maps.iter().map(|map| skin.only(&map.values)).collect();
        let of = |i: usize, id: &str, title: Markup, values: &[f32], end: f32| map::Map {
            id: format!("{id}-{}", i + 1),
            title,
            positions: &rig.surface().rest,
            values: values.to_vec(),
            end,
            markers: false,
        };
        let on_skin = maps.iter().enumerate().map(|(i, map)| {
            let end = end_of(maps, &of_skin, map.subject);
            of(i, "map", html! { (map.title) }, &of_skin[i], end)
        });
        let figures = map::figures(painter, rig, &skin.triangles(), &on_skin.collect::<Vec<_>>())?;
        let mut inside = Vec::new();
        let triangles = skin.inside();
        for subject in [Subject::Truth, Subject::Noise] {
            let first = maps.iter().position(|map| map.subject == subject);
            let Some(i) = first.filter(|_| !triangles.is_empty()) else { continue };
            let mut of_inside = vec![f32::NAN; maps[i].values.len()];
            for &v in triangles.iter().flatten() {
                of_inside[v as usize] = maps[i].values[v as usize];
            }
            let end = scale::end(std::iter::once(of_inside.as_slice()));
            let title = html! { (maps[i].title) ": mouth, eyes and other parts, without the skin" };
            let map = of(i, "inside", title, &of_inside, end);
            let figure = map::figures(painter, rig, &triangles, &[map])?.pop();
            inside.extend(figure.map(|figure| Inside { subject, figure, end, values: of_inside }));
        }
        Ok(Self { maps, of_skin, figures, inside, painter })
    }

    /// The maps of a subject on one scale, and what is inside the skin on another.
    fn section(&self, subject: Subject) -> Markup {
        let is_of = |(map, _): &(&Map, _)| map.subject == subject;
        let values = self.maps.iter().zip(&self.of_skin).filter(is_of).map(|(_, values)| values.as_slice());
        let end = end_of(self.maps, &self.of_skin, subject);
        html! {
            (map::scale(self.painter, end, "mm", "not skin", values))
            div.maps {
                @for (_, figure) in self.maps.iter().zip(&self.figures).filter(|(map, _)| map.subject == subject) { (figure.markup) }
            }
            @for inside in self.inside.iter().filter(|inside| inside.subject == subject) {
                (map::scale(self.painter, inside.end, "mm", "", std::iter::once(inside.finite().as_slice())))
                div.maps { (inside.figure.markup) }
            }
        }
    }
}

/// The end of the scale of a subject's maps.
fn end_of(maps: &[Map], of_skin: &[Vec<f32>], subject: Subject) -> f32 {
    let of_subject = maps.iter().zip(of_skin).filter(|(map, _)| map.subject == subject);
    scale::end(of_subject.map(|(_, values)| values.as_slice()))
}

fn methods(comparisons: &[Comparison]) -> Markup {
    let has_others = comparisons.iter().any(|c| c.errors.others_rms_mm.is_some());
    html! {
        table {
            thead { tr {
                th { "method" } @for name in ["skin, RMS", "95 %", "99.9 %", "worst", "wrinkle band"] { th.number { (name) } }
                @if has_others { th.number { "other parts, RMS" } }
            } }
            tbody {
                @for Comparison { method, errors, wrinkle_band_rms_mm } in comparisons {
                    @let skin = errors.skin;
                    tr {
                        th { (method) }
                        @for value in [skin.rms_mm, skin.p95_mm, skin.p99_9_mm, skin.worst_mm, *wrinkle_band_rms_mm] {
                            td.number { (mm(value)) }
                        }
                        @if let Some(others) = errors.others_rms_mm { td.number { (mm(others)) } }
                    }
                }
            }
        }
        p { "All numbers are in millimetres." @if has_others { " Other parts are the inside of the mouth, teeth, eyes and all else that is not skin." } }
    }
}

/// The RMS error of each region by each method. The regions are in the order of the first method's.
fn method_regions(comparisons: &[Comparison]) -> Markup {
    let Some(first) = comparisons.first() else { return html! {} };
    let of = |errors: &Errors, region: &str| {
        errors.regions.iter().find(|r| r.region == region).map_or("–".to_owned(), |r| mm(r.rms_mm))
    };
    let (shown, others) = first.errors.regions.split_at(first.errors.regions.len().min(REGIONS));
    let rows = |regions: &[RegionError]| {
        html! {
            table {
                thead { tr { th { "region (RMS)" } @for c in comparisons { th.number { (c.method) } } } }
                tbody {
                    @for region in regions {
                        tr {
                            th { (region.region) }
                            @for c in comparisons { td.number { (of(&c.errors, &region.region)) } }
                        }
                    }
                }
            }
        }
    };
    html! {
        (rows(shown))
        @if !others.is_empty() {
            details { summary { (human::counted(others.len(), "more region")) } (rows(others)) }
        }
    }
}

fn examples(left_out: &LeaveOneOut) -> Markup {
    let row = |name: &str, errors: &Errors, shell: f64| {
        let worst = errors.skin_regions().take(NAMED);
        let worst: Vec<String> = worst.map(|r| format!("{} {}", r.region, mm(r.rms_mm))).collect();
        html! { tr {
            th { (name) } td.number { (mm(errors.skin.rms_mm)) } td.number { (mm(shell)) } td.number { (mm(errors.skin.p95_mm)) }
            td.number { (mm(errors.skin.worst_mm)) } td { (worst.join(", ")) }
        } }
    };
    html! {
        table {
            thead { tr { th { "left-out example" } th.number { "skin, RMS" } th.number { "of the shell" } th.number { "95 %" } th.number { "worst" }
                th { "worst regions" } } }
            tbody {
                (row("any of them", &left_out.all, left_out.shell_skin_rms_mm))
                @for example in &left_out.examples { (row(&example.example, &example.errors, example.shell_skin_rms_mm)) }
            }
        }
        @if !left_out.faded.is_empty() {
            p { "The linear band is faded to the shell around these handles: left-out examples are hardly better with it there. "
                "The list says how much of it is kept." }
            ul.plain { @for faded in &left_out.faded { li { (faded.handle) ", " (format!("{:.0} %", 100.0 * faded.kept)) } } }
        }
        p { "All numbers are in millimetres." }
    }
}

/// Millimetres as in a sentence.
fn short(value: f64) -> String {
    match value {
        small if small < 0.1 => format!("{small:.3}"),
        small if small < 10.0 => format!("{small:.2}"),
        large => format!("{large:.0}"),
    }
}

fn mm(value: f64) -> String {
    format!("{value:.3}")
}
