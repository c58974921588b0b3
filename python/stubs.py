"""Writes `rhytid/_commands.pyi`: the types of the commands' options, from the program's own list of them.

`python stubs.py` writes the file; `python stubs.py --check` fails if it is not as it would be written.
"""

import pathlib
import sys

from rhytid import _rhytid
from rhytid._commands import python_name

HEAD = '''# Written by stubs.py from the program's list of options. Do not edit.
import os
from collections.abc import Mapping, Sequence
from typing import Any, Callable, Literal, TypedDict, Union

from typing_extensions import Unpack

from ._progress import Progress
from ._rhytid import Face, Rig, Take

#: A path, a name or a number; `range(10, 20)` for frames; for a file also what is in memory.
Value = Union[str, os.PathLike[str], float, range, Face, Rig, Take]
#: Several values; a dictionary for options such as `--map LABEL=NAME`.
Values = Union[Value, Sequence[Value], Mapping[str, object]]
#: A file, or what is in memory.
Place = Union[str, os.PathLike[str], Face, Rig, Take]

class Result(dict[str, Any]):
    def to_pandas(self, key: str | None = ...) -> Any: ...

class Files:
    def __init__(self, command: str) -> None: ...
    def __enter__(self) -> Files: ...
    def __exit__(self, *_: object) -> None: ...
    def path(self, ending: str) -> Any: ...

COMMANDS: dict[str, Callable[..., Result]]
'''


def kind(option):
    """The type of an option's value."""
    if option["is_flag"]:
        return "bool"
    if option["choices"]:
        named = "Literal[" + ", ".join(f'"{choice}"' for choice in option["choices"]) + "]"
        return f"Union[{named}, Sequence[{named}]]" if option["is_list"] else named
    value = "Values" if option["is_list"] else "Value"
    return f"Union[bool, {value}]" if option["may_be_empty"] else value


def stub():
    """The text of the file."""
    text = HEAD
    names = []
    for command in _rhytid.option_list():
        name = python_name(command["name"])
        names.append(name)
        title = "".join(part.capitalize() for part in name.split("_")) + "Options"
        options = [option for option in command["options"] if not option["is_place"]]
        places = [option for option in command["options"] if option["is_place"]]
        text += f"\nclass {title}(TypedDict, total=False):\n"
        text += "".join(f"    {python_name(option['name'])}: {kind(option)}\n" for option in options) or "    pass\n"
        arguments = ""
        for place in places:
            of = "Union[Place, Sequence[Place]]" if place["is_list"] else "Place"
            arguments += f"{place['name']}: {of}, " if place["is_required"] else f"{place['name']}: {of} | None = ..., "
        if name != "render":
            text += f"\ndef {name}({arguments}*, progress: Progress = ..., **options: Unpack[{title}]) -> Result: ...\n"
    # The parts of `animate` that an animation in memory has.
    animate = next(command for command in _rhytid.option_list() if command["name"] == "animate")
    options = [option for option in animate["options"] if not option["is_place"]]
    text += "\nclass PlayOptions(TypedDict, total=False):\n"
    for option in options:
        if option["name"] not in ("output", "device"):
            text += f"    {python_name(option['name'])}: {kind(option)}\n"
    text += "\n__all__ = [" + ", ".join(f'"{name}"' for name in names if name != "render") + "]\n"
    return text


path = pathlib.Path(__file__).parent / "rhytid" / "_commands.pyi"
if sys.argv[1:] == ["--check"]:
    if path.read_text() != stub():
        sys.exit(f"{path}: not as it is written now; run `cargo xtask python --stubs`")
else:
    path.write_text(stub())
