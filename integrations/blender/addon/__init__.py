"""Rhytid in Blender: from a scan, a few expressions and markers to an animated face.

The tabs of the sidebar are in the order of work: face, handles, take, play, bake. Each has a file for its operators.
What needs no Blender is in files of its own: `project`, `tracks`, `naming` and `timing`.
"""

from __future__ import annotations

from . import bake, draw, face, handles, live, panels, play, properties, store, take

#: In the order in which they are registered.
MODULES = (properties, face, handles, take, play, live, bake, panels, draw)


def register() -> None:
    for module in MODULES:
        module.register()


def unregister() -> None:
    for module in reversed(MODULES):
        module.unregister()
    store.forget()
