"""The tab Take, source Live: the face follows markers that come over the network, and can record them."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import bpy
import numpy as np
import rhytid
from bpy.props import FloatProperty

from . import face, mesh, play, player, store, take
from .problem import Problem, reported, run

#: How often the window looks for a new frame, in seconds.
PERIOD = 1 / 60


class Live(bpy.types.Operator):
    """Follow live markers, and keep them as the take; Esc ends"""

    bl_idname = "rhytid.live"
    bl_label = "Listen"
    bl_options = {"REGISTER", "UNDO"}

    seconds: FloatProperty(name="Seconds", default=0, min=0, description="How long to listen; 0 until Esc")

    def _begin(self, context: bpy.types.Context) -> bpy.types.Object:
        object = mesh.face_of(context)
        self.object, self.rig = object.name, store.rig(object)
        self.receiver = rhytid.Receiver(self.rig, object.rhytid.address)
        self.follower = player.Follower.of(object, (object.rhytid.rig_hash, player.device()))
        self.times: list[float] = []
        self.positions: list[np.ndarray] = []
        object.rhytid.playing = True
        play.paused.add(object.name)
        return object

    def _look(self) -> bool:
        """Shows the newest frame if it is a new one."""
        newest = self.receiver.newest()
        if newest is None or (self.times and newest.time <= self.times[-1]):
            return False
        self.times.append(newest.time)
        self.positions.append(newest.positions)
        object = face.still_there(self.object)
        play.show(object, self.follower.at(newest.positions, object.rhytid.detail))
        return True

    def _end(self, context: bpy.types.Context) -> set[str]:
        """Keeps what came as the take."""
        play.paused.discard(self.object)
        object = face.still_there(self.object)
        for text in self.receiver.warnings:
            self.report({"WARNING"}, text)
        if len(self.times) < 2:
            raise Problem(f"{self.receiver.address}: {len(self.times)} frames came, expected two or more; see docs/live.md")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "live.csv"
            times = np.array(self.times) - self.times[0]
            rhytid.Take(np.array(self.positions, float), self.rig.labels, times=times).save(path)
            return take.put(self, context, object, take.read(path, self.rig, False, lambda *_: None))

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        self._begin(context)
        try:
            end = time.monotonic() + self.seconds
            while time.monotonic() < end:
                self._look()
                time.sleep(PERIOD / 4)
        finally:
            play.paused.discard(self.object)
        return self._end(context)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if bpy.app.background or context.window is None:
            return self.execute(context)
        return run(self, Live._start, context)

    def _start(self, context: bpy.types.Context) -> set[str]:
        self._begin(context)
        self._timer = context.window_manager.event_timer_add(PERIOD, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        ended = event.type == "ESC" and event.value == "PRESS"
        if not ended and event.type == "TIMER":
            result = run(self, Live._show, context)
            ended = result == {"CANCELLED"}
        if not ended:
            return {"PASS_THROUGH"}
        context.workspace.status_text_set(None)
        context.window_manager.event_timer_remove(self._timer)
        play.paused.discard(self.object)
        return run(self, Live._end, context)

    def _show(self, context: bpy.types.Context) -> set[str]:
        self._look()
        counts = self.receiver.counts
        context.workspace.status_text_set(
            f"Rhytid: {self.receiver.address}, {counts['frames']} frames, {counts['lost']} lost    (Esc ends)"
        )
        return {"FINISHED"}


CLASSES = (Live,)


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)


def unregister() -> None:
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
