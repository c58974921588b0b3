"""Long work: on a thread of its own, with its progress in the status bar. Esc stops it.

Without a window, and when an operator is called from a script, the work is done at once.
"""

from __future__ import annotations

import threading
from typing import Any, Callable

import bpy

from .problem import EXPECTED, Stopped, reported, run, sentence, warnings

#: What a step of the work calls: the step's name, and its done and total units.
Progress = Callable[[str, int, int], None]
#: Work that touches no datablock of Blender.
Job = Callable[[Progress], Any]

#: How often the window is told of progress, in seconds.
PERIOD = 0.1


def silent(_step: str, _done: int, _total: int) -> None:
    """The progress that nobody looks at."""


class Thread(threading.Thread):
    """A job on its way."""

    def __init__(self, job: Job) -> None:
        super().__init__(daemon=True)
        self.job = job
        self.text = "Rhytid"
        self.stops = False
        self.result: Any = None
        self.error: BaseException | None = None
        self.said: list[str] = []

    def run(self) -> None:
        with warnings() as self.said:
            try:
                self.result = self.job(self.progress)
            except BaseException as error:  # It is raised again in the main thread.
                self.error = error

    def progress(self, step: str, done: int, total: int) -> None:
        """Tells of progress. What it raises stops the library."""
        if self.stops:
            raise Stopped
        self.text = f"Rhytid: {step} {100 * done // total} %" if total else f"Rhytid: {step}"


class Long:
    """What operators with long work inherit. They have `job` and `finish`, and are called as any operator."""

    _thread: Thread
    _timer: bpy.types.Timer

    def job(self, context: bpy.types.Context) -> Job:
        """Reads what the work needs from Blender. The result does not touch Blender."""
        raise NotImplementedError

    def finish(self, context: bpy.types.Context, result: Any) -> set[str]:
        """Puts the result of the work into Blender."""
        raise NotImplementedError

    @reported
    def execute(self, context: bpy.types.Context) -> set[str]:
        return self.finish(context, self.job(context)(silent))

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if bpy.app.background or context.window is None:
            return self.execute(context)
        return run(self, Long._start, context)

    def _start(self, context: bpy.types.Context) -> set[str]:
        self._thread = Thread(self.job(context))
        self._thread.start()
        self._timer = context.window_manager.event_timer_add(PERIOD, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        thread = self._thread
        if event.type == "ESC" and event.value == "PRESS":
            thread.stops = True
            context.workspace.status_text_set("Rhytid: stopping …")
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if thread.is_alive():
            if not thread.stops:
                context.workspace.status_text_set(f"{thread.text}    (Esc stops)")
            return {"PASS_THROUGH"}
        context.workspace.status_text_set(None)
        context.window_manager.event_timer_remove(self._timer)
        return self._ended(context)

    def _ended(self, context: bpy.types.Context) -> set[str]:
        thread = self._thread
        for text in thread.said:
            self.report({"WARNING"}, text)
        if isinstance(thread.error, Stopped):
            self.report({"INFO"}, "Stopped")
        elif isinstance(thread.error, EXPECTED):
            self.report({"ERROR"}, sentence(thread.error))
        elif thread.error is not None:
            raise thread.error
        else:
            return run(self, type(self).finish, context, thread.result)
        return {"CANCELLED"}
