"""Keyword arguments as the words of the program's command line, which checks them."""

from __future__ import annotations

import os
from typing import Any


def words(options: dict[str, Any]) -> list[str]:
    """The options as words: `fps=24` is `--fps 24`, `strain=True` is `--strain`."""
    found: list[str] = []
    for name, value in options.items():
        option = "--" + name.rstrip("_").replace("_", "-")
        if value is None or value is False:
            continue
        if isinstance(value, dict):
            values: list[Any] = [f"{key}={of}" for key, of in value.items()]
        elif isinstance(value, (list, tuple, set)):
            values = list(value)
        else:
            values = [value]
        for each in values:
            found.append(option if each is True else f"{option}={word(each)}")
    return found


def word(value: Any) -> str:
    """One value as a word. `range(10, 20)` is `10..20`."""
    if isinstance(value, range):
        if value.step != 1:
            raise ValueError(f"{value!r}: frames go on one by one, expected a step of 1")
        return f"{value.start}..{value.stop}"
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    return repr(value) if isinstance(value, float) else str(value)
