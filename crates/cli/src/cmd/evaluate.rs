//! `rhytid evaluate`

use crate::args::TakeReading;
use crate::drawing::with_pictures;
use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::core::human;
use rhytid::evaluate::{self, Comparison, Errors, Evaluation, Faded, Regions, SkinErrors, Truth};
use rhytid::formats::sequence::Sequence;
use rhytid::formats::{mesh, tables};
use rhytid::report::Page;
use rhytid::{Face, Result, Rig};

/// The number of regions named on a line.
const NAMED: usize = 4;

/// Solves the face, evaluates it, and says what was found.
///
/// # Errors
/// As reading, solving and playing.
pub(super) fn run(args: &args::Evaluate, ui: &Ui) -> Result<()> {
    inputs::project(&args.project, "rhytid evaluate FACE.toml")?;
    let device = inputs::named_device(&args.device)?;
    let face = ui.timed("read", || inputs::face(&args.project, args.elsewhere.reach(), ui)).0?;
    // Before the solve, so that a mistake is reported at once.
    let meshes = args
        .truth
        .as_ref()
        .map(|path| Sequence::open(path, &face.neutral, &args.project, face.metres_per_unit));
    let meshes = meshes.transpose()?;
    let groups = args.groups.as_ref().map(|path| mesh::read_groups(&face.neutral, &args.project, path));
    let groups = groups.transpose()?;
    let devices = inputs::devices(device, ui)?;
    let reading = TakeReading {
        missing: args.missing,
        setup: args.setup.clone(),
        soft_markers: args.soft_markers,
        elsewhere: args.elsewhere,
        ..TakeReading::default()
    };
    let given = |rig: &Rig| {
        let regions = match &groups {
            Some(groups) => Regions::by_groups(rig.vertices(), groups)?,
            None => Regions::by_handles(rig),
        };
        let truth = match (meshes, &args.take) {
            (Some(meshes), Some(take)) => {
                let take = inputs::take(take, rig, &reading, ui)?;
                let frames = args.truth_frames.as_ref().map(|path| tables::read_frames(path, take.frames()));
                Some(Truth::new(meshes, frames.transpose()?, take)?)
            }
            _ => None,
        };
        Ok((regions, truth))
    };
    let (rig, found, maps) = evaluate::evaluate(&face, given, &devices, ui)?;
    if let Some(dir) = &args.report {
        let title = output::title(&args.project, &found.name);
        let page = Page { folder: dir, title: &title };
        let write =
            |painter: Option<&_>| rhytid::report::write_evaluation(page, &found, &maps, &rig, painter);
        ui.timed("write the report", || with_pictures("the report's pictures are", write)).0?;
    }
    ui.clear();
    match args.json.wanted {
        true => output::json(&found),
        false => output::say(&text(&face, &found)),
    }
}

fn text(face: &Face, found: &Evaluation) -> String {
    let mut text = format!(
        "{}: {} vertices, {}, {}; distances in mm",
        found.name,
        human::count(found.vertices),
        human::counted(found.handles, "handle"),
        human::counted(face.examples.len(), "example")
    );
    if let Some(comparisons) = &found.truth {
        let header = [
            "skin, from the truth",
            "RMS",
            "95 %",
            "99.9 %",
            "worst",
            "wrinkle band",
            "other parts",
            "most in",
        ];
        let rows = comparisons.iter().map(comparison);
        text += &format!("\n\n{}", table(header, rows));
    }
    if let Some(left_out) = &found.leave_one_out {
        let header =
            ["skin, left out", "RMS", "of the shell", "95 %", "99.9 %", "worst", "other parts", "most in"];
        let row = |name: &str, e: &Errors, shell: f64| {
            let SkinErrors { rms_mm, p95_mm, p99_9_mm, worst_mm } = e.skin;
            let [rms, shell, p95, p99_9, worst] = [rms_mm, shell, p95_mm, p99_9_mm, worst_mm].map(mm);
            [name.into(), rms, shell, p95, p99_9, worst, others(e), regions(e)]
        };
        let all = row("any of them", &left_out.all, left_out.shell_skin_rms_mm);
        let each = left_out.examples.iter().map(|e| row(&e.example, &e.errors, e.shell_skin_rms_mm));
        text += &format!("\n\n{}", table(header, std::iter::once(all).chain(each)));
        if let Some(line) = faded_line(&left_out.faded) {
            text += &format!("\n\n{line}");
        }
    }
    let noise = &found.noise;
    text += &format!(
        "\n\n{} mm of noise at the markers moves the skin by {} RMS, {} at most; most in {}",
        noise.noise_mm,
        mm(noise.errors.skin.rms_mm),
        mm(noise.errors.skin.worst_mm),
        regions(&noise.errors)
    );
    text
}

fn comparison(Comparison { method, errors: e, wrinkle_band_rms_mm }: &Comparison) -> [String; 8] {
    let SkinErrors { rms_mm, p95_mm, p99_9_mm, worst_mm } = e.skin;
    let numbers = [rms_mm, p95_mm, p99_9_mm, worst_mm, *wrinkle_band_rms_mm].map(mm);
    let [rms, p95, p99_9, worst, wrinkles] = numbers;
    [(*method).into(), rms, p95, p99_9, worst, wrinkles, others(e), regions(e)]
}

/// The RMS of what is not skin, if there is anything.
fn others(errors: &Errors) -> String {
    errors.others_rms_mm.map_or_else(|| "–".to_owned(), mm)
}

/// Where the linear band is faded to the shell, if anywhere.
pub(super) fn faded_line(faded: &[Faded]) -> Option<String> {
    let (first, more) = faded.split_at(faded.len().min(NAMED));
    let named: Vec<String> =
        first.iter().map(|f| format!("{} ({} % kept)", f.handle, (100.0 * f.kept).round())).collect();
    let more = match more.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    (!faded.is_empty()).then(|| {
        format!(
            "the linear band is faded to the shell around {}{more}: left-out examples are hardly better with it there",
            named.join(", ")
        )
    })
}

/// The regions of the skin with the largest errors.
fn regions(errors: &Errors) -> String {
    let worst = errors.skin_regions().take(NAMED);
    worst.map(|r| format!("{} {}", r.region, mm(r.rms_mm))).collect::<Vec<_>>().join(", ")
}

fn table<const N: usize>(header: [&str; N], rows: impl Iterator<Item = [String; N]>) -> String {
    output::table(&std::iter::once(header.map(str::to_owned)).chain(rows).collect::<Vec<_>>())
}

fn mm(value: f64) -> String {
    format!("{value:.3}")
}
