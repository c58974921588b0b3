"""The exceptions. Each has the library's sentence: what was found, what was expected, and what to do."""


class Error(Exception):
    """Everything that Rhytid raises."""


class InputError(Error, ValueError):
    """The input is at fault. `kind` says in a word what is wrong, such as `MissingMarkers`."""

    kind: str = ""


class FileError(Error, OSError):
    """A file cannot be read or written."""

    def __str__(self) -> str:
        # OSError would add the number.
        return str(self.args[1]) if len(self.args) > 1 else super().__str__()


class MissingFileError(FileError, FileNotFoundError):
    """A file is not there."""


class DeviceError(Error, RuntimeError):
    """A device failed, or there is none of that name."""


class Cancelled(Error):
    """The work was stopped. Nothing was written."""


class InternalError(Error, RuntimeError):
    """A fault of Rhytid itself: please report it."""
