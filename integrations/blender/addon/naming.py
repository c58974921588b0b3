"""Names of handles on the left and on the right. Needs no Blender."""

from __future__ import annotations

import re

#: The two sides in every spelling, longest first. A side stands at an end of the name, or between its words.
PAIRS = (("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT"), ("l", "r"), ("L", "R"))


def mirrored(name: str) -> str | None:
    """The name on the other side, or `None` for a name that says no side: `brow_l` is `brow_r`."""
    for pair in PAIRS:
        for here, there in (pair, pair[::-1]):
            end = re.fullmatch(rf"(.*[_.\- ]){here}", name)
            if end:
                return end[1] + there
            start = re.fullmatch(rf"{here}([_.\- ].*)", name)
            if start:
                return there + start[1]
            if len(here) > 1 and name.endswith(here):
                return name[: -len(here)] + there
    return None


def free(name: str, taken: set[str]) -> str:
    """The name, with a number behind it if there is one such already: `chin`, `chin_2`."""
    if name not in taken:
        return name
    number = 2
    while f"{name}_{number}" in taken:
        number += 1
    return f"{name}_{number}"
