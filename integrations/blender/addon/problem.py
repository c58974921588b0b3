"""What goes wrong, as reports with the library's sentences."""

from __future__ import annotations

import logging
from contextlib import contextmanager
from typing import Any, Callable, Iterator

import rhytid


class Problem(Exception):
    """Something that the user can mend. Its text is one sentence."""


class Stopped(Exception):
    """The user pressed Esc."""


#: What becomes a report. Anything else is a fault of the extension, and is shown with its traceback.
EXPECTED = (rhytid.Error, Problem, ValueError)


def sentence(error: BaseException) -> str:
    """The text of a report: it begins with a capital letter, as Blender's do, unless it begins with a file."""
    text = str(error)
    first = text.split(" ", 1)[0]
    return text if any(sign in first for sign in "/\\.:_") else text[:1].upper() + text[1:]


class Kept(logging.Handler):
    """Keeps the library's warnings until somebody can report them."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.texts: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        if text not in self.texts:
            self.texts.append(text)


@contextmanager
def warnings() -> Iterator[list[str]]:
    """The library's warnings, from whatever thread they come."""
    logger, kept = logging.getLogger("rhytid"), Kept()
    logger.addHandler(kept)
    try:
        yield kept.texts
    finally:
        logger.removeHandler(kept)


def run(operator: Any, function: Callable[..., set[str]], *arguments: Any) -> set[str]:
    """What `function` does for an operator. Errors and the library's warnings are reports."""
    with warnings() as said:
        try:
            result = function(operator, *arguments)
        except Stopped:
            operator.report({"INFO"}, "Stopped")
            result = {"CANCELLED"}
        except EXPECTED as error:
            operator.report({"ERROR"}, sentence(error))
            result = {"CANCELLED"}
    for text in said:
        operator.report({"WARNING"}, text)
    return result


def reported(execute: Callable[[Any, Any], set[str]]) -> Callable[[Any, Any], set[str]]:
    """An `execute` whose errors are reports. Blender counts its arguments."""

    def method(self: Any, context: Any) -> set[str]:
        return run(self, execute, context)

    method.__doc__ = execute.__doc__
    return method
