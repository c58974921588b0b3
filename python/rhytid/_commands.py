"""A function for each command of the program that prints JSON, made from the program's own list of options.

`rhytid evaluate FACE.toml --truth SCANS` is `rhytid.evaluate("FACE.toml", truth="SCANS")`. The result is what
the command prints with `--json`.
"""

from __future__ import annotations

import inspect
import keyword
import os
import tempfile
from pathlib import Path
from typing import Any, Callable

from . import _rhytid
from ._options import word, words
from ._progress import Progress, callback


class Result(dict):  # type: ignore[type-arg]
    """What a command found, as plain values. docs/cli.md lists the keys."""

    def to_pandas(self, key: str | None = None) -> Any:
        """The list under `key` as a data frame, a row for each entry. Without `key`, all as one row.

        `leave_one_out.regions` is the key `regions` below the key `leave_one_out`.
        """
        import pandas

        found: Any = self
        for part in key.split(".") if key else []:
            found = found[part]
        return pandas.json_normalize(found)


#: Commands that write down where their files are. Files of what is in memory would be gone by then.
KEEPING_PATHS = ("farm",)


class Files:
    """Files of rigs, takes and faces that are in memory, for as long as a command reads them."""

    def __init__(self, command: str) -> None:
        self._command = command
        self._folder: tempfile.TemporaryDirectory[str] | None = None

    def __enter__(self) -> "Files":
        return self

    def __exit__(self, *_: object) -> None:
        if self._folder is not None:
            self._folder.cleanup()

    def path(self, ending: str) -> Path:
        if self._folder is None:
            self._folder = tempfile.TemporaryDirectory(prefix="rhytid-")
        folder = Path(self._folder.name)
        return folder / f"{len(list(folder.iterdir()))}{ending}"

    def word(self, place: str, value: Any) -> str:
        """A place of the command line: a path, or what is in memory."""
        if isinstance(value, (_rhytid.Rig, _rhytid.Take)):
            if self._command in KEEPING_PATHS:
                what = type(value).__name__.lower()
                raise ValueError(f"{place}: expected a path, found a {what} in memory; save it, and give its path")
            path = self.path(".safetensors" if isinstance(value, _rhytid.Rig) else ".csv")
            value.save(path)
            return os.fspath(path)
        if isinstance(value, _rhytid.Face):
            if value.path is None:
                raise ValueError(f"{place}: the face was made from arrays, expected one that a project file has")
            return os.fspath(value.path)
        return word(value)


def make(command: dict[str, Any]) -> Callable[..., Result]:
    """The function of a command."""
    name = command["name"]
    places = [option for option in command["options"] if option["is_place"]]
    keywords = [option for option in command["options"] if not option["is_place"]]

    def function(*given: Any, progress: Progress = None, **options: Any) -> Result:
        bound = signature.bind(*given, **options)
        with Files(name) as files:
            line = [name]
            for place in places:
                value = bound.arguments.get(place["name"])
                if value is None:
                    continue
                values = value if isinstance(value, (list, tuple)) else [value]
                line += [files.word(place["name"], each) for each in values]
            known = {python_name(option["name"]): option["name"] for option in keywords}
            chosen = {known[key]: value for key, value in bound.arguments.items() if key in known}
            in_memory = (_rhytid.Face, _rhytid.Rig, _rhytid.Take)
            for key, value in chosen.items():
                if isinstance(value, in_memory):
                    chosen[key] = files.word(key, value)
            return Result(_rhytid.call(line + words(chosen), callback(progress)))

    kinds = inspect.Parameter
    parameters = [
        kinds(place["name"], kinds.POSITIONAL_OR_KEYWORD, default=kinds.empty if place["is_required"] else None)
        for place in places
    ]
    parameters += [kinds(python_name(option["name"]), kinds.KEYWORD_ONLY, default=None) for option in keywords]
    signature = inspect.Signature(parameters)
    function.__name__ = function.__qualname__ = python_name(name)
    function.__module__ = "rhytid"
    function.__signature__ = signature  # type: ignore[attr-defined]
    function.__doc__ = documentation(command)
    return function


def python_name(name: str) -> str:
    """An option's name in Python: `from_` for `--from`, which Python keeps for itself."""
    name = name.replace("-", "_")
    return name + "_" if keyword.iskeyword(name) else name


def documentation(command: dict[str, Any]) -> str:
    """The docstring: what the command does, and a line for each option."""
    lines = [command["about"] + ".", ""]
    for option in command["options"]:
        help = (option["help"] or "").splitlines()
        choices = f" ({', '.join(option['choices'])})" if option["choices"] else ""
        lines.append(f"{python_name(option['name'])}: {help[0] if help else ''}{choices}")
    text = "\n".join(_rhytid.keyword(line) for line in lines)
    return f"{text}\n\nReturns what `rhytid {command['name']} --json` prints; docs/cli.md lists the keys."


#: The functions by their names.
COMMANDS: dict[str, Callable[..., Result]] = {
    python_name(command["name"]): make(command) for command in _rhytid.option_list()
}
globals().update(COMMANDS)
#: `render` gives pictures (`_picture`).
__all__ = [name for name in COMMANDS if name != "render"]
