//! `rhytid explain`

use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::core::HandleId;
use rhytid::core::HandleShare;
use rhytid::core::rig_file;
use rhytid::core::{Explanation, SurfacePoint};
use rhytid::{Result, Rig};
use serde::Serialize;

/// Rows of each table.
const ROWS: usize = 8;

/// Says what drives vertices in a frame.
///
/// # Errors
/// As reading; [`rhytid::Error::Input`] for a frame or a vertex that is not there.
pub(super) fn run(args: &args::Explain, ui: &Ui) -> Result<()> {
    inputs::rig_and_take(&args.rig, &args.take, "rhytid explain RIG TAKE --frame N --vertex V")?;
    let rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    let take = inputs::take(&args.take, &rig, &args.reading, ui)?;
    let take = inputs::frame(&take, args.frame, &args.take)?;
    let time = take.times[0];
    let handles = take.handle_positions(&rig.handles().labels)?;
    let (handles, _) = handles.as_chunks();
    let explain = |&vertex: &usize| Ok(Explained::new(vertex, &rig.explain(vertex, handles)?, &rig));
    let vertices: Vec<Explained> = args.vertex.iter().map(explain).collect::<Result<_>>()?;
    ui.clear();
    let wrinkles_along = if rig.vector_wrinkles() { "mesh axes" } else { "tangent, bitangent, normal" };
    if args.json.wanted {
        return output::json(&Report { frame: args.frame, time, wrinkles_along, vertices });
    }
    let texts = vertices.iter().map(|vertex| vertex.text(args.frame, time));
    output::say(&texts.collect::<Vec<_>>().join("\n\n"))
}

/// The JSON that is printed.
#[derive(Serialize)]
struct Report {
    frame: usize,
    /// In seconds.
    time: f64,
    /// The axes of the three numbers of wrinkles.
    #[serde(rename = "folds_along")]
    wrinkles_along: &'static str,
    vertices: Vec<Explained>,
}

/// Everything that drives a vertex, the largest first.
#[derive(Serialize)]
struct Explained {
    vertex: usize,
    /// The vertex's handle, if it is one.
    handle: Option<String>,
    follows: Vec<Weight>,
    strain_edges: Vec<Edge>,
    anchors: Vec<Weight>,
    from_rest: f64,
    /// The nearest first.
    examples: Vec<Example>,
    /// The wrinkles of all examples together.
    #[serde(rename = "folds_mm")]
    wrinkles_mm: [f64; 3],
}

#[derive(Serialize)]
struct Weight {
    handle: String,
    weight: f64,
}

#[derive(Serialize)]
struct Edge {
    handles: [String; 2],
    weight: f64,
    strain: f64,
}

#[derive(Serialize)]
struct Example {
    name: String,
    distance: f64,
    #[serde(rename = "folds_mm")]
    wrinkles_mm: [f64; 3],
}

impl Explained {
    fn new(vertex: usize, explanation: &Explanation, rig: &Rig) -> Self {
        let millimetres = |wrinkle: [f64; 3]| wrinkle.map(|x| x * 1e3 * rig.surface().metres_per_unit);
        let label = |handle: HandleId| rig.handles().labels[handle.index()].clone();
        let weights = |shares: &[HandleShare]| {
            let weight = |share: &HandleShare| Weight { handle: label(share.handle), weight: share.weight };
            shares.iter().map(weight).collect()
        };
        let edges = explanation.edges.iter().map(|edge| Edge {
            handles: rig.handles().strain_edges[edge.edge.index()].map(label),
            weight: edge.weight,
            strain: edge.strain,
        });
        let examples = explanation.examples.iter().zip(&rig.examples().names).map(|(share, name)| Example {
            name: name.clone(),
            distance: share.distance,
            wrinkles_mm: millimetres(share.wrinkle),
        });
        let mut examples: Vec<Example> = examples.collect();
        examples.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        let is_handle = |point: &SurfacePoint| point.vertex().is_some_and(|v| v.index() == vertex);
        Self {
            vertex,
            handle: rig.handles().points.iter().position(is_handle).map(HandleId::from_index).map(label),
            follows: weights(&explanation.handles),
            strain_edges: edges.collect(),
            anchors: weights(&explanation.anchors),
            from_rest: explanation.from_rest,
            examples,
            wrinkles_mm: millimetres(explanation.wrinkle()),
        }
    }

    fn text(&self, frame: usize, time: f64) -> String {
        let is_handle = self.handle.iter().map(|label| format!(", the handle {label},")).collect::<String>();
        let mut text = format!("vertex {}{is_handle} in frame {frame} ({time:.3} s)", self.vertex);
        let mut part = |titles: [&str; 3], rows: Vec<[String; 3]>| {
            if rows.is_empty() {
                return;
            }
            let more = rows.len().saturating_sub(ROWS);
            let titles = std::iter::once(titles.map(str::to_owned));
            let rows: Vec<[String; 3]> = titles.chain(rows.into_iter().take(ROWS)).collect();
            text += "\n\n";
            text += &output::table(&rows);
            if more > 0 {
                text += &format!("\nand {more} more");
            }
        };
        let weights = |weights: &[Weight]| {
            let row = |w: &Weight| [w.handle.clone(), format!("{:.3}", w.weight), String::new()];
            weights.iter().map(row).collect::<Vec<_>>()
        };
        part(["follows", "by", ""], weights(&self.follows));
        let edge = |edge: &Edge| {
            let strain = format!("{:+.1} %", 100.0 * edge.strain);
            [edge.handles.join(" – "), format!("{:.3}", edge.weight), strain]
        };
        part(["strain edge", "weight", "strain"], self.strain_edges.iter().map(edge).collect());
        part(["anchor", "weight", ""], weights(&self.anchors));
        let length = |wrinkle: &[f64; 3]| wrinkle.iter().map(|x| x * x).sum::<f64>().sqrt();
        let example = |e: &Example| {
            [e.name.clone(), format!("{:.3}", e.distance), format!("{:.3} mm", length(&e.wrinkles_mm))]
        };
        part(["example", "how far", "of the wrinkles"], self.examples.iter().map(example).collect());
        text += &format!(
            "\n\n{:.3} from rest; the wrinkles are {:.3} mm together",
            self.from_rest,
            length(&self.wrinkles_mm)
        );
        text
    }
}
