//! Every command and flag. Parsing, help, man pages and shell completions are all made from these files.

mod animate;
mod channels;
mod correct;
mod explain;
mod farm;
mod fine_detail;
mod help;
mod judge;
mod live;
mod lod;
mod pack;
mod placing;
mod prepare;
#[cfg(feature = "wgpu")]
mod render;
mod setup;
#[cfg(feature = "wgpu")]
mod skin;
mod solve;
mod transfer;
mod usd_layer;
mod values;
#[cfg(feature = "view")]
mod view;
mod written;

pub(crate) use animate::Animate;
pub(crate) use channels::{formats, option};
use clap::{FromArgMatches, Parser, Subcommand};
use clap_complete::Shell;
pub(crate) use correct::Correct;
pub(crate) use explain::Explain;
pub(crate) use farm::{Farm, FarmTask, FilmChoice, StepName};
pub(crate) use fine_detail::FineDetail;
pub(crate) use help::{DOCS, command};
pub(crate) use judge::{Bench, Conform, Coverage, Evaluate};
pub(crate) use live::{FramesChoice, Send};
pub(crate) use lod::Lod;
pub(crate) use pack::Pack;
pub(crate) use placing::{Handles, New, Placement, TakeReading, again};
pub(crate) use prepare::Prepare;
#[cfg(feature = "wgpu")]
pub(crate) use render::{Background, BeforeChoice, Render, Show};
pub(crate) use setup::Setup;
pub(crate) use solve::{Demo, Doctor, Solve};
use std::ffi::OsString;
use std::path::PathBuf;
pub(crate) use transfer::Transfer;
pub(crate) use values::{
    Elsewhere, HeadChoice, Json, MaterialsChoice, ShapesChoice, StageChoice, UnitChoice,
};
#[cfg(feature = "view")]
pub(crate) use view::View;
pub(crate) use written::{ExportShapes, Stitch, Verify};

/// Headings of options.
const INPUT: &str = "Input";
const SPACE: &str = "Space and unit";
const LIVE: &str = "Live";
const OUTPUT: &str = "Output";
const SIDE_FILES: &str = "More files";
#[cfg(feature = "wgpu")]
const SHOW: &str = "What is shown";
#[cfg(feature = "wgpu")]
const CAMERA: &str = "Camera";
const QUALITY: &str = "Quality";
const GLTF: &str = "glTF";
const USD: &str = "USD";
const DEVICE: &str = "Device";
const GLOBAL: &str = "General";

/// From face scans and marker tracks to detailed facial animation.
///
/// `solve` turns a neutral scan, its handles and a few expression scans into a rig, once per face. `animate`
/// plays marker takes on the rig and writes files for DCC tools.
#[derive(Debug, Parser)]
#[command(
    name = "rhytid",
    version,
    arg_required_else_help = true,
    disable_help_flag = true,
    after_help = "\
Examples:
  rhytid demo
  rhytid new neutral.obj --take session.c3d
  rhytid solve FACE.toml -o FACE.safetensors
  rhytid animate FACE.safetensors TAKE.csv -o FACE.usd

Exit codes:
  0  done
  1  a fault of Rhytid's own or of a device
  2  a mistake in the input or the command line, a file that cannot be read or written, or stopped by Ctrl-C

docs/cli.md describes the command line."
)]
pub(crate) struct Args {
    /// Show no progress and no summary; warnings and errors only.
    #[arg(short, long, global = true, conflicts_with = "verbose", help_heading = GLOBAL)]
    pub quiet: bool,

    /// Say more: times, settings and lists; twice for everything.
    #[arg(short, long, global = true, action = clap::ArgAction::Count, help_heading = GLOBAL)]
    pub verbose: u8,

    /// The most pixels of a picture that is read, width times height.
    ///
    /// A small file can hold a picture of any size. Each pixel takes up to 8 bytes of memory.
    #[arg(long, global = true, value_name = "N", default_value_t = rhytid::core::MOST_PIXELS, value_parser = clap::value_parser!(u64).range(1..), hide_short_help = true, help_heading = GLOBAL)]
    pub max_pixels: u64,

    /// Print help: a summary with -h, everything with --help.
    #[arg(short, long, global = true, action = clap::ArgAction::Help, help_heading = GLOBAL)]
    help: Option<bool>,

    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

impl Args {
    /// From the words of a command line, the program's name first. Help and mistakes end the process.
    pub(crate) fn read(words: &[OsString]) -> Self {
        let matches = command().get_matches_from(words);
        Self::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
    }
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Make a face and a performance in code, solve and animate it: no input needed.
    #[command(after_help = "\
Examples:
  rhytid demo
  rhytid demo /tmp/face --vertices 530000")]
    Demo(Demo),

    /// Make a project of a neutral scan, expression scans and a take.
    ///
    /// Finds the expressions and a take beside the neutral, the unit, the up axis and the place of each
    /// marker. Writes a project file with a comment at each choice, the table of handles and a picture of
    /// them. Ends with the commands that come next.
    #[command(after_help = "\
Examples:
  rhytid new scans/anna/neutral.obj
  rhytid new neutral.obj --examples poses --take session.c3d -o anna")]
    New(New),

    /// Show a rig in a window: drag markers, play takes, see what drives a vertex.
    ///
    /// H lists the keys. Rigs and takes can be dropped on the window, too.
    #[cfg(feature = "view")]
    #[command(after_help = "\
Examples:
  rhytid view FACE.safetensors TAKE.csv
  rhytid view FACE.safetensors --listen
  rhytid view FACE.safetensors TAKE.csv --device cpu:0

docs/viewing.md says what can be done there.")]
    View(View),

    /// Solve a face: scans, handles and examples become a rig.
    #[command(after_help = "\
Examples:
  rhytid solve FACE.toml
  rhytid solve scans/anna/face.toml -o rigs/anna.safetensors --quiet")]
    Solve(Solve),

    /// Play a take on a rig and write the animated mesh.
    #[command(after_help = "\
Examples:
  rhytid animate FACE.safetensors TAKE.csv -o FACE.usd
  rhytid animate FACE.safetensors TAKE.csv -o FACE.usd --velocities --frames 100..200
  rhytid animate FACE.safetensors session.c3d -o FACE.usd
  rhytid animate FACE.safetensors session.c3d -o FACE.usd --setup anna.toml --fps 24
  rhytid animate FACE.safetensors TAKE.csv -o FACE.usdz --fps 24 --missing hold
  rhytid animate FACE.safetensors TAKE.csv -o FACE.usd --fade-detail --head bake
  rhytid animate FACE.safetensors TAKE.csv -o FACE.usd --edit EDIT.toml
  rhytid animate FACE.safetensors TAKE.csv -o FACE.glb --compressed --quantize --meshopt
  rhytid animate FACE.safetensors TAKE.csv -o coarse.usd --stage large-scale --device cpu:0
  rhytid animate FACE.safetensors --listen --frames 2400 -o FACE.usd --record TAKE.csv
  rhytid animate FACE.safetensors walk.csv talk.csv -o FACE.glb --shapes 40
  rhytid animate FACE.safetensors TAKES/*.c3d -o OUT/
  rhytid animate FACE.safetensors TAKE.csv -o curves.csv --onto arkit.glb

docs/export.md says which format and which options suit which program.")]
    Animate(Box<Animate>),

    /// Draw frames of a take: a sheet, a picture for each, or one that moves.
    #[cfg(feature = "wgpu")]
    #[command(after_help = "\
Examples:
  rhytid render FACE.safetensors TAKE.csv -o sheet.png
  rhytid render FACE.safetensors TAKE.csv -o sheet.png --show shaded,strain,detail --frames 100..200 --turn 30
  rhytid render FACE.safetensors TAKE.csv -o pictures/{frame}.png --size 1280x720
  rhytid render FACE.safetensors TAKE.csv -o film.mp4
  rhytid render FACE.safetensors TAKE.csv -o around.webp --turntable --frames 60..61 --count 48 --background none

docs/render.md has pictures of what can be shown.")]
    Render(Box<Render>),

    /// Write a rig's examples as named shapes, for sliders.
    #[command(after_help = "\
Examples:
  rhytid export-shapes FACE.safetensors -o shapes.glb
  rhytid export-shapes FACE.safetensors -o shapes.usd --handles
  rhytid export-shapes FACE.safetensors -o shapes.glb --handles --force")]
    ExportShapes(ExportShapes),

    /// Put parts of a take, which `animate --frames` wrote, together as one USD file.
    ///
    /// OUT refers to the parts by value clips and holds no frames itself. Keep the parts where OUT expects
    /// them. With --levels it has levels of detail, one variant for each file.
    #[command(after_help = "\
Examples:
  rhytid stitch part1.usd part2.usd -o FACE.usd

The parts come from, on one machine or on several:
  rhytid animate FACE.safetensors TAKE.csv -o part1.usd --frames 0..2000
  rhytid animate FACE.safetensors TAKE.csv -o part2.usd --frames 2000..4000

Levels of detail come from `rhytid lod`, and each is animated:
  rhytid stitch --levels FACE.usd level1.usd level2.usd -o levels.usda")]
    Stitch(Stitch),

    /// Play many takes on many machines: write a job for a render farm.
    ///
    /// Each take is cut into chunks of frames that different machines evaluate. Schedulers of Open Job
    /// Description, such as Deadline Cloud, read the job's template.json. slurm.sh submits the job to Slurm.
    /// --local N runs it here. Without a take, the command says how far the job in DIR is. docs/farm.md says
    /// what a job costs.
    #[command(after_help = "\
Examples:
  rhytid farm TAKES/*.csv --rig FACE.safetensors -o JOB
  rhytid farm TAKES/*.csv --rig FACE.safetensors -o JOB --animate \"--velocities --fps 24\" --minutes 20
  rhytid farm TAKES/*.csv --rig FACE.safetensors -o JOB --local 2
  rhytid farm -o JOB
  rhytid farm -o JOB --local 2")]
    Farm(Box<Farm>),

    /// Do one task of a job, as a scheduler starts it.
    #[command(hide = true)]
    FarmTask(FarmTask),

    /// Send a take over the network as if it were captured now.
    ///
    /// The receiver is `animate --listen`, or any program that reads OSC. Each frame is a UDP datagram of its
    /// own; docs/live.md describes its content. The command cannot know whether anybody listens.
    #[command(after_help = "\
Examples:
  rhytid send TAKE.csv
  rhytid send TAKE.csv --rig FACE.safetensors --to 192.168.0.20:9000 --rate 240 --loop")]
    Send(Send),

    /// Place the handles: the markers of a take on the mesh, or so many spread over it.
    ///
    /// With a take, one frame near the neutral face is laid over the mesh. The take may have any unit and
    /// axes, and markers of a cap or head band are left out. The command writes the table that the project
    /// file names, with the distance of each handle from its marker, and a picture to look at.
    #[command(after_help = "\
Examples:
  rhytid handles FACE.toml session.c3d
  rhytid handles FACE.toml session.c3d --frame 30 --at chin=1042 --at nose=377
  rhytid handles FACE.toml --count 90 -o markers.csv")]
    Handles(Handles),

    /// Clean a raw take, as a capture system writes it, for a rig.
    ///
    /// RAW is C3D, TRC, Motive's CSV, Qualisys' TSV or the take's CSV. Unit, axes, rigid markers and neutral
    /// frames are found and reported unless they are given. docs/prepare.md explains each step. `animate`
    /// cleans raw takes in the same way.
    #[command(after_help = "\
Examples:
  rhytid prepare session.c3d --rig FACE.safetensors -o TAKE.csv --report report
  rhytid prepare session.trc --rig FACE.safetensors -o TAKE.csv --fps 30 --neutral 0..60
  rhytid prepare session.c3d --rig FACE.safetensors -o TAKE.csv --setup anna.toml
  rhytid prepare session.c3d --rig FACE.safetensors -o TAKE.csv --map chin=M12 --map brow=M7 --skip low-pass")]
    Prepare(Box<Prepare>),

    /// Write a frame as a mesh, to be sculpted.
    ///
    /// The sculpted mesh can become a correction of similar frames (EDIT.toml), or an example of the rig
    /// (FACE.toml). docs/edits.md says how.
    #[command(after_help = "\
Examples:
  rhytid correct FACE.safetensors TAKE.csv --frame 120 -o smile.obj
  rhytid correct FACE.safetensors TAKE.csv --frame 120 -o smile.obj --edit EDIT.toml")]
    Correct(Correct),

    /// Put the wrinkles of one face on another one, with another mesh.
    ///
    /// Handles of the same label say how the faces correspond. The first face is laid over the second. Each
    /// of its examples becomes an example of the second face, which is then solved. docs/transfer.md says
    /// what carries over and how to look at it.
    #[command(after_help = "\
Examples:
  rhytid transfer --from ANNA.safetensors --to BEN.toml -o BEN.safetensors
  rhytid transfer --from ANNA.safetensors --to BEN.toml -o BEN.safetensors --with-linear-band --report report
  rhytid transfer --from ANNA.safetensors --to BEN.toml -o BEN.safetensors --landmarks pairs.csv --examples made")]
    Transfer(Transfer),

    /// Make a rig file small, to send it.
    ///
    /// Numbers of the rig are rounded. No vertex is farther than --max-error from where the rig has it, in
    /// all examples and in all frames of TAKE. Every command and the page read the small file as they read
    /// any rig. docs/delivery.md compares it with other ways to send a performance.
    #[command(after_help = "\
Examples:
  rhytid pack FACE.safetensors -o small.safetensors
  rhytid pack FACE.safetensors TAKE.csv -o small.safetensors --max-error 0.02")]
    Pack(Box<Pack>),

    /// Make levels of detail: rigs on fewer vertices.
    ///
    /// Vertices go where the neutral, the examples and the frames of TAKE need them least. Markers are met on
    /// every level. Each level is a rig file of its own, with a table of where it has each vertex of the
    /// whole rig. docs/levels.md says how to use them.
    #[command(after_help = "\
Examples:
  rhytid lod FACE.safetensors -o levels/
  rhytid lod FACE.safetensors TAKE.csv --levels 4 -o levels/")]
    Lod(Box<Lod>),

    /// Look at a project for everything that would hurt its solve.
    ///
    /// Exits with 0 if the face can be solved and with 2 if it can't.
    #[command(after_help = "\
Examples:
  rhytid doctor FACE.toml
  rhytid doctor FACE.toml --json")]
    Doctor(Doctor),

    /// Say what is in a file: mesh, animation, rig, take, curves, table, project, setup or report.
    #[command(after_help = "\
Examples:
  rhytid info neutral.obj
  rhytid info FACE.safetensors --json
  rhytid info TAKE.csv
  rhytid info session.c3d
  rhytid info FACE.toml")]
    Info(Info),

    /// Find out how good a face's rig is, and where it is not.
    ///
    /// Without --truth it uses the examples alone: the error of each example if it is left out, and the
    /// effect of the markers' noise. --truth gives dense meshes that a take belongs to. It adds the rig's
    /// distance from them, beside the results of other methods with the same examples. docs/evaluate.md says
    /// how to read it.
    #[command(after_help = "\
Examples:
  rhytid evaluate FACE.toml
  rhytid evaluate FACE.toml --report report
  rhytid evaluate FACE.toml --truth scans/ --take TAKE.csv --truth-frames scanned.csv
  rhytid evaluate FACE.toml --truth dense.usd --take TAKE.csv --groups regions.obj --json")]
    Evaluate(Evaluate),

    /// Find what the take does that no example shows, and plan the scans to make.
    ///
    /// It says how uncertain the rig is about the take, and which frames to scan. Markers are enough for
    /// that: the rig may have no example. docs/coverage.md says what the numbers mean.
    #[command(after_help = "\
Examples:
  rhytid coverage FACE.safetensors TAKE.csv
  rhytid coverage FACE.safetensors TAKE.csv --top 3
  rhytid coverage FACE.safetensors TAKE.csv --json
  rhytid coverage FACE.safetensors TAKE.csv --plan 6 --report plan
  rhytid coverage FACE.safetensors TAKE.csv --plan 6 --take-examples dense.usd -o scans")]
    Coverage(Coverage),

    /// Say why vertices are where they are in a frame.
    ///
    /// Lists the handles, strain edges and examples that drive the vertices. The nearest example is the one
    /// that the frame resembles most around the vertex. The wrinkles of all examples together are added to
    /// the large scale there. `view` shows the same for a clicked vertex.
    #[command(after_help = "\
Examples:
  rhytid explain FACE.safetensors TAKE.csv --frame 120 --vertex 4711
  rhytid explain FACE.safetensors TAKE.csv --frame 120 --vertex 4711,4712 --json")]
    Explain(Explain),

    /// Read an animation back and compare it with a fresh evaluation.
    ///
    /// Exits with 0 if every vertex is where the file promises and with 1 if one is not.
    #[command(after_help = "\
Examples:
  rhytid verify FACE.usd --rig FACE.safetensors --take TAKE.csv
  rhytid verify FACE.glb --rig FACE.safetensors --take TAKE.csv --json")]
    Verify(Verify),

    /// List the devices that can evaluate a rig.
    #[command(after_help = "\
Examples:
  rhytid devices
  rhytid devices --json")]
    Devices(Devices),

    /// Find out which devices of this machine to trust, and how fast they are.
    ///
    /// Every kernel runs on made-up rigs of all sizes and is compared with a float64 reference. Only the
    /// rounding of float32 is allowed. Exits with 0 if every device passes and with 1 if one fails.
    #[command(after_help = "\
Examples:
  rhytid conform
  rhytid conform --quick
  rhytid conform --device vulkan:0 --report report")]
    Conform(Conform),

    /// Measure how fast devices are, stage by stage.
    ///
    /// Each time is compared with the time that its bytes take at the speed of the memory. That speed is
    /// measured in turns with the device. Without RIG, a rig of --vertices vertices is made, with 89 handles
    /// and six examples as in the chapter that the method is from. A rig of the learned method is measured in
    /// turns with one of the chapter's method. Nothing else should run meanwhile. docs/benchmarks.md has our
    /// figures.
    #[command(after_help = "\
Examples:
  rhytid bench
  rhytid bench --device all --vertices 100000
  rhytid bench --method chapter
  rhytid bench FACE.safetensors --device cpu:0 --frames 32 --storage f16
  rhytid bench --growth --plot bench.svg
  rhytid bench --json > bench.json")]
    Bench(Bench),

    /// Print completions for a shell.
    #[command(after_help = "\
Examples:
  rhytid completions bash > ~/.local/share/bash-completion/completions/rhytid
  rhytid completions zsh > ~/.zfunc/_rhytid
  rhytid completions fish > ~/.config/fish/completions/rhytid.fish")]
    Completions(Completions),

    /// Write man pages for every command.
    #[command(after_help = "\
Examples:
  rhytid man
  rhytid man ~/.local/share/man/man1")]
    Man(Man),

    /// Look at drivers for another process of this program, which their crashes then cannot end.
    #[command(hide = true)]
    Look(Look),
}

/// `rhytid look`
#[derive(Debug, clap::Args)]
pub(crate) struct Look {
    /// What to look at.
    pub request: Vec<String>,
}

/// `rhytid info`
#[derive(Debug, clap::Args)]
pub(crate) struct Info {
    /// The file. A mesh (.obj, .ply, .glb, .gltf), animation or blend shapes (.usd, .usda, .usdc, .usdz,
    /// .glb, .gltf), rig (.safetensors) or take (.csv, .c3d, .trc, .tsv). Also curves, a table of handles or
    /// markers (.csv), a project or setup (.toml) or a report (.json).
    pub file: PathBuf,

    #[command(flatten)]
    pub elsewhere: Elsewhere,

    #[command(flatten)]
    pub json: Json,
}

/// `rhytid devices`
#[derive(Debug, clap::Args)]
pub(crate) struct Devices {
    #[command(flatten)]
    pub json: Json,
}

/// `rhytid completions`
#[derive(Debug, clap::Args)]
pub(crate) struct Completions {
    /// The shell.
    pub shell: Shell,
}

/// `rhytid man`
#[derive(Debug, clap::Args)]
pub(crate) struct Man {
    /// The folder to write to; made if it does not exist.
    #[arg(default_value = "man")]
    pub dir: PathBuf,

    #[command(flatten)]
    pub json: Json,
}
