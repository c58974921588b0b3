"""Frames of the scene as frames of a take. Needs no Blender.

Time counts in seconds: a take of 120 frames a second lasts as long in a scene of 24. The library brings the take to
the scene's rate (`fps` of `rhytid.Rig.play`), so that a scene's frame is a frame of the animation.
"""

from __future__ import annotations

from dataclasses import dataclass

#: Rates that differ by less are the same. 30000/1001 is written as 29.97 by many programs.
SAME = 1e-3


def resampled(scene_rate: float, take_rate: float) -> float | None:
    """The rate to bring a take to, or `None` if the scene has the take's."""
    return None if abs(scene_rate - take_rate) <= SAME else scene_rate


@dataclass(frozen=True)
class Place:
    """A moment between two frames of an animation."""

    before: int
    #: The part of the way to the next frame, from 0 to below 1.
    part: float


def place(frame: float, start: float, frames: int) -> Place:
    """Where a frame of the scene is in an animation of `frames` frames that begins at the scene's frame `start`.

    Before its start and after its end, the animation holds its first and its last frame.
    """
    at = min(max(frame - start, 0.0), frames - 1.0)
    before = int(at)
    part = at - before
    # A frame of the scene is a float32.
    if part < 1e-4 or part > 1 - 1e-4:
        return Place(round(at), 0.0)
    return Place(before, part)
