"""The tab Take: a capture file, empties, or the tracks of a clip as the take of a face."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import rhytid
from bpy.props import StringProperty

from . import face, mesh, play, scene_space, store, tracks
from .problem import Problem, reported
from .work import Job, Long, Progress

#: The most markers on the timeline, worst first.
MOST_MARKERS = 100
#: How markers on the timeline that are ours begin.
PREFIX = "Rhytid: "


@dataclass
class Read:
    """A take as it is kept, and what clean-up found."""

    csv: bytes
    name: str
    frames: int
    rate: float
    report: dict[str, Any] | None


def read(path: Path, rig: rhytid.Rig, head_moves: bool, progress: Progress) -> Read:
    """Reads a take, and cleans it if it is raw."""
    report = None
    with tempfile.TemporaryDirectory() as folder:
        clean = Path(folder) / "clean.csv"
        if head_moves or rhytid.info(path)["kind"] == "raw_take":
            world = {"world": True} if head_moves and path.suffix.lower() == ".csv" else {}
            report = rhytid.prepare(path, rig=rig, output=clean, progress=progress, **world)["report"]
            take = rhytid.Take.open(clean, rig)
        else:
            take = rhytid.Take.open(path, rig, progress=progress)
            take.save(clean)
        return Read(clean.read_bytes(), path.name, len(take), take.rate, report)


class OpenTake(Long, bpy.types.Operator):
    """Read a take from a file; a raw one is cleaned"""

    bl_idname = "rhytid.open_take"
    bl_label = "Open Take"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(subtype="FILE_PATH", description="The take; without it, the path of the panel")

    def job(self, context: bpy.types.Context) -> Job:
        object = mesh.face_of(context)
        self.object = object.name
        rig = store.rig(object)
        given = self.filepath or object.rhytid.take_path
        if not given:
            raise Problem("no file is chosen; choose the take's file first")
        path, head_moves = Path(bpy.path.abspath(given)), object.rhytid.head_moves
        return lambda progress: read(path, rig, head_moves, progress)

    def finish(self, context: bpy.types.Context, result: Read) -> set[str]:
        object = face.still_there(self.object)
        if self.filepath:
            object.rhytid.take_path = self.filepath
        return put(self, context, object, result)


def put(operator: bpy.types.Operator, context: bpy.types.Context, object: bpy.types.Object, read: Read) -> set[str]:
    """Keeps a take, marks what clean-up found, and lets the face follow it."""
    store.put_take(object, read.csv, read.name)
    marks = [] if read.report is None else marks_of(read.report)
    mark(context.scene, object, marks)
    object.rhytid.source = "TAKE"
    object.rhytid.playing = True
    rate = context.scene.render.fps / context.scene.render.fps_base
    last = object.rhytid.start + (read.frames - 1) / read.rate * rate
    context.scene.frame_end = max(context.scene.frame_end, int(np.ceil(last)))
    if object.name in play.problems:
        raise Problem(play.problems[object.name])
    operator.report({"INFO"}, f"{read.name}: {read.frames} frames at {read.rate:g} a second")
    return {"FINISHED"}


@dataclass(frozen=True)
class Mark:
    """Something that clean-up found in a frame of the take."""

    time: float
    text: str


def mark(scene: bpy.types.Scene, object: bpy.types.Object, marks: list[Mark]) -> None:
    """Puts markers on the timeline in place of those of the take before."""
    for marker in [marker for marker in scene.timeline_markers if marker.name.startswith(PREFIX)]:
        scene.timeline_markers.remove(marker)
    rate = scene.render.fps / scene.render.fps_base
    for found in marks[:MOST_MARKERS]:
        frame = round(object.rhytid.start + found.time * rate)
        scene.timeline_markers.new(PREFIX + found.text, frame=frame)


def marks_of(report: dict[str, Any]) -> list[Mark]:
    """What clean-up found, in the order of time. Where there is too much, the longest stay."""
    labels, rate = report["labels"], report["rate"]
    events = sorted(report["events"], key=lambda event: -event["frames"])[:MOST_MARKERS]
    marks = []
    for event in sorted(events, key=lambda event: event["first"]):
        named = [labels[event[who]] for who in ("marker", "other") if event[who] is not None]
        kind = event["kind"].replace("_", " ")
        marks.append(Mark(event["first"] / rate, f"{' and '.join(named)}: {kind}" if named else kind))
    return marks


def sampled(context: bpy.types.Context, object: bpy.types.Object, owners: list[bpy.types.Object]) -> np.ndarray:
    """Frames × N × 3 places of objects in the face's coordinates, in each frame of the scene's range."""
    scene = context.scene
    before = scene.frame_current
    found = []
    # The face itself need not follow.
    play.paused.add(object.name)
    try:
        for frame in range(scene.frame_start, scene.frame_end + 1):
            scene.frame_set(frame)
            places = np.array([tuple(owner.matrix_world.translation) for owner in owners])
            found.append(scene_space.in_object(object, places))
    finally:
        play.paused.discard(object.name)
        scene.frame_set(before)
    return np.array(found)


def label_of(name: str, labels: list[str]) -> str | None:
    """The handle that an object or a track is called as: its name, also before Blender's `.001`."""
    if name in labels:
        return name
    stem, dot, number = name.rpartition(".")
    return stem if dot and number.isdigit() and stem in labels else None


class TakeObjects(Long, bpy.types.Operator):
    """Take the selected empties of the scene as markers; they are called as the handles"""

    bl_idname = "rhytid.take_objects"
    bl_label = "Take from Empties"
    bl_options = {"REGISTER", "UNDO"}

    def job(self, context: bpy.types.Context) -> Job:
        object = mesh.face_of(context)
        self.object = object.name
        rig, scene = store.rig(object), context.scene
        named = {label_of(other.name, rig.labels): other for other in context.selected_objects if other != object}
        named.pop(None, None)
        if not named:
            raise Problem(
                f"no selected object is called as a handle, such as {rig.labels[0]}; select the empties, the face last"
            )
        positions = sampled(context, object, list(named.values()))
        return job_of(object, rig, positions, list(named), scene, "empties")

    def finish(self, context: bpy.types.Context, result: Read) -> set[str]:
        return put(self, context, face.still_there(self.object), result)


def job_of(
    object: bpy.types.Object,
    rig: rhytid.Rig,
    positions: np.ndarray,
    labels: list[str],
    scene: bpy.types.Scene,
    name: str,
) -> Job:
    """The work that makes a take of frames × markers × 3 positions, which begin at the scene's first frame."""
    object.rhytid.start = scene.frame_start
    head_moves = object.rhytid.head_moves
    rate = scene.render.fps / scene.render.fps_base

    def make(progress: Progress) -> Read:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{name}.csv"
            rhytid.Take(positions.astype(float), labels, rate=rate).save(path)
            found = read(path, rig, head_moves, progress)
            return Read(found.csv, name, found.frames, found.rate, found.report)

    return make


class TakeClip(Long, bpy.types.Operator):
    """Take the tracks of a movie clip, seen by the scene's camera; they are called as the handles"""

    bl_idname = "rhytid.take_clip"
    bl_label = "Take from Clip"
    bl_options = {"REGISTER", "UNDO"}

    def job(self, context: bpy.types.Context) -> Job:
        object = mesh.face_of(context)
        self.object = object.name
        rig, scene, clip = store.rig(object), context.scene, object.rhytid.clip
        if clip is None:
            raise Problem("no movie clip is chosen; choose the clip whose tracks are the markers")
        if scene.camera is None:
            raise Problem("the scene has no camera; place one as it saw the face when the clip was filmed")
        tracks_of = {label_of(track.name, rig.labels): track for track in clip.tracking.tracks}
        tracks_of.pop(None, None)
        if not tracks_of:
            raise Problem(
                f"no track of {clip.name} is called as a handle, such as {rig.labels[0]}; rename the tracks"
            )
        labels = list(tracks_of)
        frames = range(scene.frame_start, scene.frame_end + 1)
        image = np.zeros((len(frames), len(labels), 2))
        seen = np.zeros((len(frames), len(labels)), bool)
        for column, track in enumerate(tracks_of.values()):
            for row, frame in enumerate(frames):
                # The clip's first frame is at `frame_start`, and its own frames count from 1.
                marker = track.markers.find_frame(frame - clip.frame_start + 1)
                if marker is not None and not marker.mute:
                    image[row, column], seen[row, column] = marker.co, True
        positions = in_space(context, object, rig, labels, image)
        return job_of(object, rig, tracks.filled(positions, seen), labels, scene, clip.name)

    def finish(self, context: bpy.types.Context, result: Read) -> set[str]:
        return put(self, context, face.still_there(self.object), result)


def in_space(
    context: bpy.types.Context,
    object: bpy.types.Object,
    rig: rhytid.Rig,
    labels: list[str],
    image: np.ndarray,
) -> np.ndarray:
    """Frames × N × 3 places in the face's coordinates, each as far from the camera as its handle at rest."""
    render, camera = context.scene.render, context.scene.camera
    projection = camera.calc_matrix_camera(
        context.evaluated_depsgraph_get(),
        x=render.resolution_x,
        y=render.resolution_y,
        scale_x=render.pixel_aspect_x,
        scale_y=render.pixel_aspect_y,
    )
    seen_by = tracks.Camera(np.array(camera.matrix_world.inverted()), np.array(projection))
    rest = rig.handles[[rig.labels.index(label) for label in labels]].astype(float)
    depth_of = scene_space.in_world(object, rest)
    found = [scene_space.in_object(object, tracks.at_depth(seen_by, points, depth_of)) for points in image]
    return np.array(found)


CLASSES = (OpenTake, TakeObjects, TakeClip)


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)


def unregister() -> None:
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
