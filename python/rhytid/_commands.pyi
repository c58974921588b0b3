# Written by stubs.py from the program's list of options. Do not edit.
import os
from collections.abc import Mapping, Sequence
from typing import Any, Callable, Literal, TypedDict, Union

from typing_extensions import Unpack

from ._progress import Progress
from ._rhytid import Face, Rig, Take

#: A path, a name or a number; `range(10, 20)` for frames; for a file also what is in memory.
Value = Union[str, os.PathLike[str], float, range, Face, Rig, Take]
#: Several values; a dictionary for options such as `--map LABEL=NAME`.
Values = Union[Value, Sequence[Value], Mapping[str, object]]
#: A file, or what is in memory.
Place = Union[str, os.PathLike[str], Face, Rig, Take]

class Result(dict[str, Any]):
    def to_pandas(self, key: str | None = ...) -> Any: ...

class Files:
    def __init__(self, command: str) -> None: ...
    def __enter__(self) -> Files: ...
    def __exit__(self, *_: object) -> None: ...
    def path(self, ending: str) -> Any: ...

COMMANDS: dict[str, Callable[..., Result]]

class DemoOptions(TypedDict, total=False):
    vertices: Value

def demo(dir: Place | None = ..., *, progress: Progress = ..., **options: Unpack[DemoOptions]) -> Result: ...

class NewOptions(TypedDict, total=False):
    output: Value
    examples: Value
    take: Value
    frame: Value
    at: Values
    rigid: Values
    subject: Value
    rate: Value
    shapes: Values
    part: Value
    unit: Value

def new(neutral: Place, *, progress: Progress = ..., **options: Unpack[NewOptions]) -> Result: ...

class SolveOptions(TypedDict, total=False):
    allow_elsewhere: bool
    output: Value
    pack: Value
    max_error: Value

def solve(project: Place, *, progress: Progress = ..., **options: Unpack[SolveOptions]) -> Result: ...

class AnimateOptions(TypedDict, total=False):
    output: Value
    frames: Value
    fps: Value
    start_frame: Value
    head: Literal["keep", "drop", "bake"]
    textures: Literal["copy", "embed", "refer", "none"]
    prim_path: Value
    mesh_name: Value
    metres: bool
    subdivision: Literal["none", "catmullClark"]
    over: bool
    no_normals: bool
    velocities: bool
    sigma: bool
    strain: bool
    wrinkles: bool
    wrinkle_group: Values
    masks: Value
    masks_to: Value
    strain_curves: Value
    groups: Value
    edit: Value
    missing: Literal["hold", "error"]
    setup: Value
    shapes: Values
    soft_markers: bool
    force: bool
    allow_elsewhere: bool
    take_unit: Literal["mm", "cm", "m", "in", "ft"]
    take_axes: Value
    take_rate: Value
    onto: Value
    listen: Union[bool, Value]
    record: Value
    timeout: Value
    address: Value
    world: bool
    rigid: Values
    unit: Literal["mm", "cm", "m", "in", "ft"]
    axes: Value
    neutral: Value
    stage: Literal["shell", "large-scale", "full"]
    fade_detail: bool
    detail: Value
    detail_of: Values
    refine: bool
    compressed: bool
    max_error: Value
    targets: Value
    quantize: bool
    meshopt: bool
    materials: Literal["each", "one"]
    vertex_ids: bool
    device: Value

def animate(rig: Place, takes: Union[Place, Sequence[Place]] | None = ..., *, progress: Progress = ..., **options: Unpack[AnimateOptions]) -> Result: ...

class RenderOptions(TypedDict, total=False):
    output: Value
    frames: Value
    fps: Value
    count: Value
    size: Value
    background: Value
    show: Union[Literal["shaded", "gouraud", "flat", "skin", "wireframe", "matcap", "textured", "markers", "influences", "frames", "strain", "strain1", "strain2", "detail", "sigma", "error"], Sequence[Literal["shaded", "gouraud", "flat", "skin", "wireframe", "matcap", "textured", "markers", "influences", "frames", "strain", "strain1", "strain2", "detail", "sigma", "error"]]]
    before: Value
    vertex: Value
    matcap: Value
    texture: Value
    hide: Values
    strain_range: Value
    detail_range: Value
    sigma_range: Value
    error_range: Value
    unlit: bool
    light: Value
    exposure: Value
    tone: Literal["neutral", "agx"]
    turn: Value
    raise_: Value
    whole: bool
    turntable: bool
    lens: Value
    edit: Value
    compare: Value
    truth_frames: Value
    missing: Literal["hold", "error"]
    setup: Value
    shapes: Values
    soft_markers: bool
    force: bool
    allow_elsewhere: bool
    take_unit: Literal["mm", "cm", "m", "in", "ft"]
    take_axes: Value
    take_rate: Value
    stage: Literal["shell", "large-scale", "full"]
    fade_detail: bool
    detail: Value
    detail_of: Values
    device: Value
    draw_on: Value

class ExportShapesOptions(TypedDict, total=False):
    output: Value
    handles: bool
    no_normals: bool
    textures: Literal["copy", "embed", "refer", "none"]
    prim_path: Value
    mesh_name: Value
    metres: bool
    subdivision: Literal["none", "catmullClark"]
    targets: Value
    materials: Literal["each", "one"]
    force: bool
    device: Value

def export_shapes(rig: Place, *, progress: Progress = ..., **options: Unpack[ExportShapesOptions]) -> Result: ...

class StitchOptions(TypedDict, total=False):
    output: Value
    levels: bool

def stitch(parts: Union[Place, Sequence[Place]], *, progress: Progress = ..., **options: Unpack[StitchOptions]) -> Result: ...

class FarmOptions(TypedDict, total=False):
    rig: Value
    output: Value
    kind: Value
    animate: Value
    film: Value
    film_fps: Value
    minutes: Value
    chunk: Value
    local: Value
    device: Value

def farm(takes: Union[Place, Sequence[Place]] | None = ..., *, progress: Progress = ..., **options: Unpack[FarmOptions]) -> Result: ...

class SendOptions(TypedDict, total=False):
    rig: Value
    to: Value
    rate: Value
    loop: bool
    frames: Value

def send(take: Place, *, progress: Progress = ..., **options: Unpack[SendOptions]) -> Result: ...

class HandlesOptions(TypedDict, total=False):
    allow_elsewhere: bool
    count: Value
    frame: Value
    at: Values
    rigid: Values
    subject: Value
    rate: Value
    part: Value
    unit: Literal["mm", "cm", "m", "in", "ft"]
    output: Value
    picture: Value

def handles(project: Place, take: Place | None = ..., *, progress: Progress = ..., **options: Unpack[HandlesOptions]) -> Result: ...

class PrepareOptions(TypedDict, total=False):
    rig: Value
    output: Value
    report: Value
    setup: Value
    allow_elsewhere: bool
    fps: Value
    write_markers: Value
    world: bool
    rate: Value
    map: Values
    markers: Value
    subject: Value
    rigid: Values
    unit: Literal["mm", "cm", "m", "in", "ft"]
    axes: Value
    neutral: Value
    skip: Union[Literal["head", "head-low-pass", "align", "proportions", "swaps", "outliers", "slides", "gaps", "low-pass"], Sequence[Literal["head", "head-low-pass", "align", "proportions", "swaps", "outliers", "slides", "gaps", "low-pass"]]]
    max_gap: Value
    filter: Value
    head_low_pass: Value
    pose: Values
    swap: Values
    drop: Values
    hold: Values
    force: bool

def prepare(raw: Place, *, progress: Progress = ..., **options: Unpack[PrepareOptions]) -> Result: ...

class CorrectOptions(TypedDict, total=False):
    frame: Value
    output: Value
    edit: Value
    missing: Literal["hold", "error"]
    setup: Value
    shapes: Values
    soft_markers: bool
    force: bool
    allow_elsewhere: bool
    take_unit: Literal["mm", "cm", "m", "in", "ft"]
    take_axes: Value
    take_rate: Value

def correct(rig: Place, take: Place, *, progress: Progress = ..., **options: Unpack[CorrectOptions]) -> Result: ...

class TransferOptions(TypedDict, total=False):
    from_: Value
    to: Value
    allow_elsewhere: bool
    output: Value
    landmarks: Value
    with_linear_band: bool
    examples: Value
    report: Value

def transfer(*, progress: Progress = ..., **options: Unpack[TransferOptions]) -> Result: ...

class PackOptions(TypedDict, total=False):
    output: Value
    max_error: Value
    missing: Literal["hold", "error"]
    setup: Value
    shapes: Values
    soft_markers: bool
    force: bool
    allow_elsewhere: bool
    take_unit: Literal["mm", "cm", "m", "in", "ft"]
    take_axes: Value
    take_rate: Value

def pack(rig: Place, take: Place | None = ..., *, progress: Progress = ..., **options: Unpack[PackOptions]) -> Result: ...

class LodOptions(TypedDict, total=False):
    levels: Value
    output: Value
    missing: Literal["hold", "error"]
    setup: Value
    shapes: Values
    soft_markers: bool
    force: bool
    allow_elsewhere: bool
    take_unit: Literal["mm", "cm", "m", "in", "ft"]
    take_axes: Value
    take_rate: Value

def lod(rig: Place, take: Place | None = ..., *, progress: Progress = ..., **options: Unpack[LodOptions]) -> Result: ...

class DoctorOptions(TypedDict, total=False):
    allow_elsewhere: bool

def doctor(project: Place, *, progress: Progress = ..., **options: Unpack[DoctorOptions]) -> Result: ...

class InfoOptions(TypedDict, total=False):
    allow_elsewhere: bool

def info(file: Place, *, progress: Progress = ..., **options: Unpack[InfoOptions]) -> Result: ...

class EvaluateOptions(TypedDict, total=False):
    truth: Value
    take: Value
    truth_frames: Value
    groups: Value
    missing: Literal["hold", "error"]
    setup: Value
    soft_markers: bool
    allow_elsewhere: bool
    report: Value
    device: Value

def evaluate(project: Place, *, progress: Progress = ..., **options: Unpack[EvaluateOptions]) -> Result: ...

class CoverageOptions(TypedDict, total=False):
    missing: Literal["hold", "error"]
    setup: Value
    shapes: Values
    soft_markers: bool
    force: bool
    allow_elsewhere: bool
    take_unit: Literal["mm", "cm", "m", "in", "ft"]
    take_axes: Value
    take_rate: Value
    top: Value
    plan: Value
    candidates: Value
    report: Value
    take_examples: Value
    output: Value

def coverage(rig: Place, take: Place, *, progress: Progress = ..., **options: Unpack[CoverageOptions]) -> Result: ...

class ExplainOptions(TypedDict, total=False):
    frame: Value
    vertex: Values
    missing: Literal["hold", "error"]
    setup: Value
    shapes: Values
    soft_markers: bool
    force: bool
    allow_elsewhere: bool
    take_unit: Literal["mm", "cm", "m", "in", "ft"]
    take_axes: Value
    take_rate: Value

def explain(rig: Place, take: Place, *, progress: Progress = ..., **options: Unpack[ExplainOptions]) -> Result: ...

class VerifyOptions(TypedDict, total=False):
    rig: Value
    take: Value
    clip: Value
    edit: Value
    setup: Value
    shapes: Value
    allow_elsewhere: bool
    device: Value
    take_unit: Literal["mm", "cm", "m", "in", "ft"]
    take_axes: Value
    take_rate: Value

def verify(file: Place, *, progress: Progress = ..., **options: Unpack[VerifyOptions]) -> Result: ...

class DevicesOptions(TypedDict, total=False):
    pass

def devices(*, progress: Progress = ..., **options: Unpack[DevicesOptions]) -> Result: ...

class ConformOptions(TypedDict, total=False):
    device: Value
    report: Value
    quick: bool

def conform(*, progress: Progress = ..., **options: Unpack[ConformOptions]) -> Result: ...

class BenchOptions(TypedDict, total=False):
    device: Value
    vertices: Value
    method: Literal["learned", "chapter"]
    frames: Value
    storage: Literal["f32", "f16", "clustered"]
    growth: bool
    plot: Value

def bench(rig: Place | None = ..., *, progress: Progress = ..., **options: Unpack[BenchOptions]) -> Result: ...

class ManOptions(TypedDict, total=False):
    pass

def man(dir: Place | None = ..., *, progress: Progress = ..., **options: Unpack[ManOptions]) -> Result: ...

class PlayOptions(TypedDict, total=False):
    frames: Value
    fps: Value
    start_frame: Value
    head: Literal["keep", "drop", "bake"]
    textures: Literal["copy", "embed", "refer", "none"]
    prim_path: Value
    mesh_name: Value
    metres: bool
    subdivision: Literal["none", "catmullClark"]
    over: bool
    no_normals: bool
    velocities: bool
    sigma: bool
    strain: bool
    wrinkles: bool
    wrinkle_group: Values
    masks: Value
    masks_to: Value
    strain_curves: Value
    groups: Value
    edit: Value
    missing: Literal["hold", "error"]
    setup: Value
    shapes: Values
    soft_markers: bool
    force: bool
    allow_elsewhere: bool
    take_unit: Literal["mm", "cm", "m", "in", "ft"]
    take_axes: Value
    take_rate: Value
    onto: Value
    listen: Union[bool, Value]
    record: Value
    timeout: Value
    address: Value
    world: bool
    rigid: Values
    unit: Literal["mm", "cm", "m", "in", "ft"]
    axes: Value
    neutral: Value
    stage: Literal["shell", "large-scale", "full"]
    fade_detail: bool
    detail: Value
    detail_of: Values
    refine: bool
    compressed: bool
    max_error: Value
    targets: Value
    quantize: bool
    meshopt: bool
    materials: Literal["each", "one"]
    vertex_ids: bool

__all__ = ["demo", "new", "solve", "animate", "export_shapes", "stitch", "farm", "send", "handles", "prepare", "correct", "transfer", "pack", "lod", "doctor", "info", "evaluate", "coverage", "explain", "verify", "devices", "conform", "bench", "man"]
