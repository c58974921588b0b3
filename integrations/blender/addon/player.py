"""Frames of one face: by its take, or by the places of its handles. What is here can be made again at any time."""

from __future__ import annotations

from collections import OrderedDict
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
import rhytid

from . import curves, mesh, project, scene_space, store, timing

#: The most bytes of frames that are kept for all faces together.
MOST_BYTES = 512 << 20

#: The frames that are computed ahead while a scene plays.
AHEAD = 16

#: The channels of a frame by their names.
Channels = dict[str, np.ndarray]


def device() -> str:
    """The device of the preferences."""
    addon = bpy.context.preferences.addons.get(__package__)
    return "auto" if addon is None else addon.preferences.device


@dataclass(frozen=True)
class Wish:
    """What decides the frames of a face that follows its take."""

    rig: str
    take: str
    rate: float
    #: `None` if the detail changes from frame to frame.
    detail: float | None
    channels: tuple[str, ...]
    regions: tuple[tuple[str, float, float], ...]
    device: str


def wish_of(object: bpy.types.Object, scene: bpy.types.Scene) -> Wish:
    """What the settings of a face ask for."""
    settings = object.rhytid
    is_keyed = any(curve.data_path == "rhytid.detail" for curve in curves.of_action(object))
    return Wish(
        rig=settings.rig_hash,
        take=settings.take_hash,
        rate=scene.render.fps / scene.render.fps_base,
        detail=None if is_keyed else settings.detail,
        channels=tuple(name for name in ("strain", "wrinkles", "sigma") if getattr(settings, name)),
        regions=tuple((item.name, item.detail, item.motion) for item in settings.regions),
        device=device(),
    )


def options_of(object: bpy.types.Object, wish: Wish, take: rhytid.Take) -> dict[str, Any]:
    """The options of `rhytid animate` for a wish. The file of edits is for this process alone."""
    # Blender has normals of its own.
    options: dict[str, Any] = {"no_normals": True, **{name: True for name in wish.channels}}
    rate = timing.resampled(wish.rate, take.rate)
    if rate is not None:
        options["fps"] = rate
    if wish.detail not in (None, 1.0):
        options["detail"] = wish.detail
    if any(region[1:] != (1, 1) for region in wish.regions):
        options["edit"] = write_edit(object, wish.regions)
    return options


def write_edit(object: bpy.types.Object, regions: tuple[tuple[str, float, float], ...]) -> str:
    """Writes painted regions as an edit file (docs/edits.md). Returns its path."""
    folder = store.folder() / "edit"
    folder.mkdir(exist_ok=True)
    vertices = mesh.positions(object.data)
    text = []
    for number, (group, detail, motion) in enumerate(regions):
        project.write_weights(folder / f"{number}.ply", "weight", vertices, mesh.weights(object, group))
        text += [f"[region.r{number}]", f'weights = "{number}.ply"', 'property = "weight"']
        text += ["[[detail]]", f'region = "r{number}"', f"by = {detail!r}"]
        text += ["[[gain]]", f'region = "r{number}"', f"by = {motion!r}"]
    path = folder / "edit.toml"
    path.write_text("\n".join(text) + "\n")
    return str(path)


#: The thread that computes ahead. It touches nothing of Blender.
_workers = ThreadPoolExecutor(1, "rhytid")


@dataclass
class Coming:
    """Frames that are being computed."""

    frames: range
    future: "Future[list[list[Channels]]]"


def computed(animations: list[rhytid.Animation], frames: range) -> list[list[Channels]]:
    """The frames of each animation."""
    of_each = [animation[frames.start : frames.stop] for animation in animations]
    return [[{name: frame[name] for name in frame.keys()} for frame in moment] for moment in zip(*of_each)]


@dataclass
class Player:
    """A take on its rig, on a device."""

    wish: Wish
    #: One animation, or those without and with all detail where the detail changes from frame to frame.
    animations: list[rhytid.Animation]
    kept: "OrderedDict[int, list[Channels]]" = field(default_factory=OrderedDict)
    bytes: int = 0
    #: The frame that was shown before.
    last: int | None = None
    coming: "Coming | None" = None

    @classmethod
    def of(cls, object: bpy.types.Object, wish: Wish) -> "Player":
        rig, take = store.rig(object), store.take(object)
        options = options_of(object, wish, take)
        details = [{}] if wish.detail is not None else [{"detail": 0.0}, {}]
        return cls(wish, [rig.play(take, device=wish.device, **options, **detail) for detail in details])

    def __len__(self) -> int:
        return len(self.animations[0])

    def _frame(self, number: int) -> list[Channels]:
        if number not in self.kept and self.coming is not None and number in self.coming.frames:
            coming, self.coming = self.coming, None
            for each, frame in zip(coming.frames, coming.future.result()):
                self._keep(each, frame)
        if number not in self.kept:
            self._keep(number, computed(self.animations, range(number, number + 1))[0])
        if self.last is not None and number == self.last + 1:
            self._look_ahead(number + 1)
        self.last = number
        self.kept.move_to_end(number)
        return self.kept[number]

    def _keep(self, number: int, frame: list[Channels]) -> None:
        if number not in self.kept:
            self.bytes += size(frame)
            self.kept[number] = frame

    def _look_ahead(self, first: int) -> None:
        """Has the next frames computed while the scene shows those before them."""
        while first in self.kept:
            first += 1
        if self.coming is None and self.last is not None and first <= self.last + AHEAD and first < len(self):
            frames = range(first, min(first + AHEAD, len(self)))
            self.coming = Coming(frames, _workers.submit(computed, self.animations, frames))

    def at(self, place: timing.Place, detail: float) -> Channels:
        """The channels of a moment. Between two frames, they are on straight lines."""
        frames = self._frame(place.before)
        channels = frames[-1]
        if len(frames) > 1:
            channels = {**channels, "positions": mixed(frames[0]["positions"], frames[1]["positions"], detail)}
        if place.part > 0:
            later = self.at(timing.Place(place.before + 1, 0), detail)
            channels = {name: mixed(channels[name], later[name], place.part) for name in channels}
        return channels

    def forget_one(self) -> None:
        """Drops the frame that was shown longest ago."""
        _, frame = self.kept.popitem(last=False)
        self.bytes -= size(frame)


def mixed(before: np.ndarray, after: np.ndarray, part: float) -> np.ndarray:
    return before + np.float32(part) * (after - before)


def size(frames: list[Channels]) -> int:
    return sum(array.nbytes for channels in frames for array in channels.values())


def control_positions(object: bpy.types.Object, rig: rhytid.Rig) -> np.ndarray:
    """H × 3 places of the handles by the objects or the bones that move them. The others are at rest."""
    settings = object.rhytid
    number = {label: i for i, label in enumerate(rig.labels)}
    found: dict[int, Any] = {}
    if settings.controls is not None:
        for control in settings.controls.all_objects:
            if control.rhytid_handle in number:
                found[number[control.rhytid_handle]] = control.matrix_world.translation
    if settings.armature is not None and settings.armature.type == "ARMATURE":
        for bone in settings.armature.pose.bones:
            if bone.name in number:
                found[number[bone.name]] = settings.armature.matrix_world @ bone.head
    positions = rig.handles.copy()
    if found:
        places = np.array([tuple(place) for place in found.values()])
        positions[list(found)] = scene_space.in_object(object, places)
    return positions


@dataclass
class Follower:
    """A rig on a device, for handles that are dragged or keyed."""

    wish: tuple[str, str]
    animator: rhytid.Animator

    @classmethod
    def of(cls, object: bpy.types.Object, wish: tuple[str, str]) -> "Follower":
        name = wish[1]
        return cls(wish, store.rig(object).animator(None if name == "auto" else name))

    def at(self, handles: np.ndarray, detail: float) -> Channels:
        """The vertices for H × 3 handles. The detail is a part of the motion that can be multiplied."""
        positions = self.animator(handles)
        if detail != 1:
            positions = mixed(self.animator.read("large_scale"), positions, detail)
        return {"positions": positions}
