//! A frame as a picture, once for each thing to show.

use super::frames::{Before, Evaluated};
use super::images;
use super::shape::Shape;
use super::skin::SkinLook;
use crate::args::{self, Show};
use clap::ValueEnum;
use rhytid::devices::wgpu::Wgpu;
use rhytid::geometry::{PrincipalStrains, StrainGauge};
use rhytid::render::{
    Anchor, Camera, FrameBuffers, Heat, LINE, Look, Mark, Offscreen, Overlay, Picture, Renderer, Sheet,
    Sphere, Strains, View, around_handles, distances, influence_marks, letter_scale, marker_marks,
    tangent_frame_marks,
};
use rhytid::{Result, Rig};
use std::time::Duration;

/// Draws the pictures.
pub(super) struct Pictures<'a> {
    rig: &'a Rig,
    cells: Vec<Cell>,
    /// The name of each side, written below its cells; `None` if the result is alone.
    words: Option<[String; 3]>,
    renderer: Renderer,
    skin: Option<SkinLook>,
    overlay: Overlay,
    /// How far marks are moved towards the camera, in mesh units. The chord between two markers would
    /// otherwise run below the skin.
    lift: f32,
    /// The vertex whose influences are shown.
    vertex: Option<usize>,
    page: Offscreen,
    frame: FrameBuffers,
    view: View,
    background: [u8; 4],
    /// The points that fit into the picture; `None` for a camera that goes around.
    framed: Option<Vec<[f32; 3]>>,
    /// Whether maps have no light.
    unlit: bool,
    strains: Option<Strains>,
    gauge: Option<StrainGauge>,
    millimetres: f32,
}

/// One of the drawings that stand side by side for a frame.
struct Cell {
    show: Show,
    heat: Option<Heat>,
    side: Side,
}

/// The source of a cell's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Truth,
    Before,
    Result,
}

impl Side {
    const ALL: [Self; 3] = [Self::Truth, Self::Before, Self::Result];

    fn shape<'a>(self, frame: &Evaluated<'a>) -> Shape<'a> {
        match self {
            Self::Truth => frame.truth,
            Self::Before => frame.before,
            Self::Result => frame.result,
        }
    }

    fn has(self, show: Show) -> bool {
        match show {
            Show::Detail | Show::Sigma => self == Self::Result,
            Show::Error => self != Self::Truth,
            _ => true,
        }
    }
}

impl<'a> Pictures<'a> {
    /// Pictures of `size` pixels for each thing to show, drawn by `wgpu`. `before` is the shape to put beside
    /// the result.
    pub(super) fn new(
        args: &args::Render,
        rig: &'a Rig,
        before: Option<&Before>,
        wgpu: &Wgpu,
        size: [u32; 2],
    ) -> Result<Self> {
        let (device, queue) = (wgpu.device(), wgpu.queue());
        let heat = |show| match show {
            Show::Strain | Show::Strain1 | Show::Strain2 | Show::Markers => {
                Some(Heat::Signed(args.strain_range))
            }
            Show::Detail => Some(Heat::From0(args.detail_range)),
            Show::Sigma => Some(Heat::From0(args.sigma_range)),
            Show::Error => Some(Heat::From0(args.error_range)),
            _ => None,
        };
        let sides = Side::ALL.into_iter().filter(|side| match side {
            Side::Truth => args.compare.is_some(),
            Side::Before => before.is_some(),
            Side::Result => true,
        });
        let sides: Vec<Side> = sides.collect();
        let cells = args.show.iter().flat_map(|&show| {
            let sides = sides.iter().filter(move |side| side.has(show));
            sides.map(move |&side| Cell { show, heat: heat(show), side })
        });
        let [before, result] =
            before.map_or_else(|| [String::new(), "result".to_owned()], |before| before.words.clone());
        let is_skin = args.show.contains(&Show::Skin);
        let mut renderer =
            Renderer::new(device, queue, &rig.surface().faces, &rig.surface().triangles, Offscreen::TARGET)?;
        images::give(&mut renderer, rig, args)?;
        Ok(Self {
            rig,
            cells: cells.collect(),
            words: (sides.len() > 1).then(|| ["truth".to_owned(), before, result]),
            renderer,
            skin: is_skin.then(|| SkinLook::new(args, rig, wgpu)).transpose()?,
            overlay: Overlay::new(device, queue, Offscreen::TARGET)?,
            lift: 0.1 * Sphere::around(&rig.handles().rest).radius,
            vertex: args.vertex,
            page: Offscreen::new(device, queue, size)?,
            frame: FrameBuffers::new(device, queue, rig.vertices())?,
            view: View { turn: args.turn, raise: args.raise, lens: args.lens },
            background: args.background.map_or(Sheet::PAPER, |background| background.0),
            framed: match (args.turntable, args.whole) {
                (true, _) => None,
                (false, true) => Some(rig.surface().rest.clone()),
                (false, false) => Some(around_handles(&rig.handles().rest, &rig.surface().rest)),
            },
            unlit: args.unlit,
            strains: args
                .show
                .contains(&Show::Strain)
                .then(|| Strains::new(&rig.surface().faces, &rig.surface().rest)),
            gauge: args
                .show
                .iter()
                .any(|show| matches!(show, Show::Strain1 | Show::Strain2))
                .then(|| StrainGauge::of_surface(rig.surface())),
            millimetres: 1e3 * rig.surface().metres_per_unit as f32,
        })
    }

    /// The size of all cells side by side.
    pub(super) fn size(&self) -> [u32; 2] {
        let [width, height] = self.page.size();
        [width.saturating_mul(self.cells.len() as u32), height + self.lines() * self.line()]
    }

    /// The time of lighting skin, if skin is shown.
    pub(super) fn lighting(&self) -> Option<Duration> {
        self.skin.as_ref().map(|skin| skin.time)
    }

    /// Pixels of a line of words.
    fn line(&self) -> u32 {
        LINE * letter_scale(self.page.size())
    }

    /// Lines of words below each cell.
    fn lines(&self) -> u32 {
        let has_numbers = self.cells.iter().any(|cell| cell.show == Show::Error);
        if self.words.is_some() { 1 + u32::from(has_numbers) } else { 0 }
    }

    /// What each cell shows, for the columns of a sheet. None for a single cell, and where words below say
    /// it.
    pub(super) fn titles(&self) -> Vec<String> {
        if self.words.is_some() || self.cells.len() < 2 {
            return Vec::new();
        }
        let name =
            |cell: &Cell| cell.show.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned());
        self.cells.iter().map(name).collect()
    }

    pub(super) fn legends(&self) -> Vec<(Heat, &'static str)> {
        let title = |show: Show| match show {
            Show::Strain | Show::Strain1 | Show::Strain2 | Show::Markers => "strain, ratio",
            Show::Sigma => "sigma, mm",
            Show::Error => "error, mm",
            _ => "detail, mm",
        };
        let of_cells = self.cells.iter().filter_map(|cell| Some((cell.heat?, title(cell.show))));
        let mut legends: Vec<_> = of_cells.collect();
        legends.dedup();
        legends
    }

    /// Draws a frame. The camera is turned by `turned` degrees more.
    pub(super) fn draw(&mut self, frame: &Evaluated<'_>, turned: f32) -> Result<Picture> {
        let [width, height] = self.page.size();
        let view = View { turn: self.view.turn + turned, ..self.view };
        let aspect = self.page.aspect();
        let camera = match &self.framed {
            Some(points) => Camera::framing(points, self.rig.surface().up_axis, view, aspect),
            None => Camera::around(
                Sphere::around(&self.rig.surface().rest),
                self.rig.surface().up_axis,
                view,
                aspect,
            ),
        };
        let mut picture = Picture::filled(self.size(), self.background);
        for (i, cell) in (0..).zip(&self.cells) {
            let shape = cell.side.shape(frame);
            let numbers = self.numbers(cell, frame);
            let vertices = frame.drawn_from.unwrap_or_else(|| {
                self.frame.set(shape.positions, shape.normals, &numbers);
                self.frame.vertices()
            });
            if cell.show == Show::Skin
                && let Some(skin) = &mut self.skin
            {
                skin.light(vertices, &camera, aspect)?;
            }
            let coloured = cell.heat.map(if self.unlit { Look::Heat } else { Look::LitHeat });
            let look = cell.show.look().or(coloured).unwrap_or(Look::Smooth);
            self.renderer.show(&camera, aspect, look);
            let marks = self.marks(cell, shape);
            if let Some(marks) = &marks {
                self.overlay.show(&camera, self.page.size(), self.lift, marks)?;
            }
            let part = self.page.draw(self.background, |pass| {
                match &self.skin {
                    Some(skin) if cell.show == Show::Skin => skin.renderer.draw(pass, vertices),
                    _ => self.renderer.draw(pass, vertices)?,
                }
                if marks.is_some() {
                    self.overlay.draw(pass);
                }
                Ok(())
            })?;
            picture.put(&part, [i * width, 0]);
            if let Some(words) = &self.words {
                // A picture of its own cuts long words at the end of the cell.
                let mut line = Picture::filled([width, self.lines() * self.line()], self.background);
                for (y, words) in (0..).zip(caption(cell, words, &numbers)) {
                    let top = [width as i32 / 2, 2 + y * self.line() as i32];
                    let scale = letter_scale(self.page.size());
                    line.write(&words, top, Anchor::Center, ink(self.background), scale);
                }
                picture.put(&line, [i * width, height]);
            }
        }
        Ok(picture)
    }

    /// The V numbers of a heat map.
    fn numbers(&self, cell: &Cell, frame: &Evaluated<'_>) -> Vec<f32> {
        let Shape { positions, .. } = cell.side.shape(frame);
        match cell.show {
            Show::Strain => {
                self.strains.as_ref().map(|strains| strains.measure(positions)).unwrap_or_default()
            }
            Show::Strain1 | Show::Strain2 => {
                let mut strains = PrincipalStrains::default();
                self.gauge.iter().for_each(|gauge| gauge.measure(positions.as_chunks().0, &mut strains));
                let which = usize::from(cell.show == Show::Strain2);
                strains.strains.iter().map(|of_vertex| of_vertex[which]).collect()
            }
            Show::Detail => distances(positions, frame.large_scale, self.millimetres),
            Show::Sigma => frame.sigma.iter().map(|sigma| sigma * self.millimetres).collect(),
            Show::Error => distances(positions, frame.truth.positions, self.millimetres),
            _ => Vec::new(),
        }
    }

    /// The marks to draw over the face.
    fn marks(&self, cell: &Cell, Shape { positions, normals }: Shape<'_>) -> Option<Vec<Mark>> {
        match cell.show {
            Show::Markers => Some(marker_marks(self.rig, positions, cell.heat?)),
            Show::Influences => Some(influence_marks(self.rig, positions, self.vertex?)),
            Show::Frames => Some(tangent_frame_marks(self.rig, positions, normals, 0.3 * self.lift)),
            _ => None,
        }
    }
}

/// The words below a cell. The first argument gives the names of the truth, the earlier shape and the result.
fn caption(cell: &Cell, [truth, before, result]: &[String; 3], numbers: &[f32]) -> Vec<String> {
    let side = match cell.side {
        Side::Truth => truth,
        Side::Before => before,
        Side::Result => result,
    };
    match cell.show {
        Show::Error => {
            let squares: f64 = numbers.iter().map(|x| f64::from(*x).powi(2)).sum();
            let rms = (squares / numbers.len().max(1) as f64).sqrt();
            let worst = numbers.iter().copied().fold(0.0, f32::max);
            let whose = if before.is_empty() { "error".to_owned() } else { format!("error: {side}") };
            vec![whose, format!("RMS {rms:.2}, worst {worst:.2} mm")]
        }
        Show::Strain => vec![format!("strain: {side}")],
        Show::Strain1 => vec![format!("strain 1: {side}")],
        Show::Strain2 => vec![format!("strain 2: {side}")],
        Show::Detail => vec!["detail".to_owned()],
        Show::Sigma => vec!["sigma".to_owned()],
        _ => vec![side.clone()],
    }
}

/// The colour of legible words on a background.
fn ink([r, g, b, opacity]: [u8; 4]) -> [u8; 3] {
    match [r, g, b].map(u32::from).iter().sum::<u32>() {
        _ if opacity == 0 => [128; 3],
        ..=383 => [222, 224, 228],
        _ => [20, 20, 24],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_a_frame_is_said_in_millimetres() {
        let cell = |show, side| Cell { show, heat: None, side };
        let words = ["truth", "", "result"].map(str::to_owned);
        let said = caption(&cell(Show::Error, Side::Result), &words, &[0.0, 3.0, 4.0, 0.0]);
        assert_eq!(said, ["error", "RMS 2.50, worst 4.00 mm"]);
        let words = ["truth", "shell", "result"].map(str::to_owned);
        assert_eq!(caption(&cell(Show::Error, Side::Before), &words, &[0.125])[0], "error: shell");
        assert_eq!(caption(&cell(Show::Shaded, Side::Truth), &words, &[]), ["truth"]);
        assert_eq!(caption(&cell(Show::Strain, Side::Result), &words, &[]), ["strain: result"]);
    }
}
