"""Progress of long work: a callback, or a bar on standard error."""

from __future__ import annotations

import sys
from typing import Any, Callable, Optional, Union

Callback = Callable[[str, int, int], object]
#: What `progress=` takes: `True` for a bar, or a function of the step's name and its done and total units.
Progress = Union[bool, Callback, None]


class Bar:
    """A bar for each step, by tqdm where it is installed, else a line for each step."""

    def __init__(self) -> None:
        self._step = ""
        self._bar: Any = None

    def __call__(self, step: str, done: int, total: int) -> None:
        if step != self._step:
            self._begin(step, total)
        if self._bar is not None:
            self._bar.n = done
            self._bar.refresh()
            if done >= total:
                self._close()

    def _begin(self, step: str, total: int) -> None:
        self._close()
        self._step = step
        try:
            from tqdm.auto import tqdm
        except ImportError:
            print(f"{step} …", file=sys.stderr)
        else:
            self._bar = tqdm(total=total, desc=step, leave=False)

    def _close(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None


def callback(progress: Progress) -> Optional[Callback]:
    """The function that is told of progress, if any is."""
    if progress is True:
        return Bar()
    if progress is None or progress is False:
        return None
    if not callable(progress):
        raise TypeError(f"progress is {progress!r}, expected True, or a function of (step, done, total)")
    return progress
