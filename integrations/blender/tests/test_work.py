"""Long work: its progress is shown while it goes on, Esc stops it, and errors of the thread are reports."""

from __future__ import annotations

import time
import unittest
from types import SimpleNamespace

import rhytid

from support import demo, module


class Context:
    """A window, as far as long work knows it."""

    def __init__(self) -> None:
        self.shown: list[str | None] = []
        self.timers = 0
        self.window = object()
        self.workspace = SimpleNamespace(status_text_set=self.shown.append)
        self.window_manager = SimpleNamespace(
            event_timer_add=self._add, event_timer_remove=self._remove, modal_handler_add=lambda _: None
        )

    def _add(self, _period: float, window: object) -> str:
        self.timers += 1
        return "timer"

    def _remove(self, _timer: str) -> None:
        self.timers -= 1


class Work(unittest.TestCase):
    def operator(self, job):
        """An operator that does a job, and keeps its reports and its result."""

        class Operator(module("work").Long):
            def __init__(self) -> None:
                self.reports: list[tuple[set[str], str]] = []
                self.result = None

            def job(self, _context):
                return job

            def finish(self, _context, result):
                self.result = result
                return {"FINISHED"}

            def report(self, kind, text):
                self.reports.append((kind, text))

        return Operator()

    def until_it_ends(self, operator, context, esc_at: float | None = None) -> set[str]:
        """Sends events as a window does."""
        self.assertEqual(operator._start(context), {"RUNNING_MODAL"})
        start, result = time.monotonic(), {"PASS_THROUGH"}
        while result in ({"PASS_THROUGH"}, {"RUNNING_MODAL"}) and time.monotonic() < start + 60:
            time.sleep(0.01)
            is_esc = esc_at is not None and time.monotonic() > start + esc_at
            kind, esc_at = ("ESC", None) if is_esc else ("TIMER", esc_at)
            # Other events are the window's own.
            self.assertEqual(operator.modal(context, SimpleNamespace(type="MOUSEMOVE", value="")), {"PASS_THROUGH"})
            result = operator.modal(context, SimpleNamespace(type=kind, value="PRESS"))
        self.assertEqual(context.timers, 0)
        self.assertIsNone(context.shown[-1])
        return result

    def test_progress_is_shown_and_the_result_comes(self) -> None:
        def job(progress):
            for done in range(10):
                progress("read", done, 10)
                time.sleep(0.03)
            return 7

        operator, context = self.operator(job), Context()
        self.assertEqual(self.until_it_ends(operator, context), {"FINISHED"})
        self.assertEqual(operator.result, 7)
        self.assertIn("Rhytid: read 50 %    (Esc stops)", context.shown)

    def test_esc_stops_a_solve(self) -> None:
        face = rhytid.Face.open(demo / "face.toml")

        def job(progress):
            # It would go on for ever.
            while True:
                face.solve(progress=progress)

        operator, context = self.operator(job), Context()
        self.assertEqual(self.until_it_ends(operator, context, esc_at=0.3), {"CANCELLED"})
        self.assertEqual((operator.result, operator.reports), (None, [({"INFO"}, "Stopped")]))
        self.assertIn("Rhytid: stopping …", context.shown)

    def test_an_error_is_a_report(self) -> None:
        operator, context = self.operator(lambda _progress: rhytid.Rig.open("none.safetensors")), Context()
        self.assertEqual(self.until_it_ends(operator, context), {"CANCELLED"})
        [(kind, text)] = operator.reports
        self.assertEqual(kind, {"ERROR"})
        self.assertIn("none.safetensors", text)
        # What nobody expects keeps its traceback.
        broken = self.operator(lambda _progress: {}["missing"])
        with self.assertRaises(KeyError):
            self.until_it_ends(broken, Context())
