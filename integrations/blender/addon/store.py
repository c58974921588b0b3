"""Where the rig and the take of a face are: packed in the .blend file, or the rig beside it.

A text datablock carries the bytes as a property. Such a datablock is no part of the scene, so that no evaluation of
the scene copies it. The object has the hashes. What is in memory is a copy that can be read again at any time.
"""

from __future__ import annotations

import hashlib
import tempfile
import zlib
from collections import OrderedDict
from pathlib import Path
from typing import Any, Callable

import bpy
import rhytid

from .problem import Problem

#: The names of the properties of the datablock.
RIG, TAKE = "rhytid_rig", "rhytid_take"
#: The most rigs, and the most takes, that are kept in memory.
MOST = 4

_read: dict[str, "OrderedDict[str, Any]"] = {RIG: OrderedDict(), TAKE: OrderedDict()}
_folder: tempfile.TemporaryDirectory[str] | None = None


def folder() -> Path:
    """A folder for this process's temporary files."""
    global _folder
    if _folder is None:
        _folder = tempfile.TemporaryDirectory(prefix="rhytid-blender-")
    return Path(_folder.name)


def forget() -> None:
    """Drops all that is in memory, and the temporary files."""
    global _folder
    for kept in _read.values():
        kept.clear()
    if _folder is not None:
        _folder.cleanup()
        _folder = None


def digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def bytes_of(save: Callable[[Path], None], ending: str) -> bytes:
    """What `save` writes, as bytes."""
    path = folder() / f"written{ending}"
    save(path)
    data = path.read_bytes()
    path.unlink()
    return data


def _datablock(object: bpy.types.Object) -> bpy.types.Text:
    """The datablock of an object, which no other object changes with it."""
    settings = object.rhytid
    shared = any(other.rhytid.data == settings.data for other in bpy.data.objects if other != object)
    if settings.data is None or shared:
        former = settings.data
        settings.data = bpy.data.texts.new(f"{object.name}.rhytid")
        settings.data.from_string("The rig and the take of a face. The add-on Rhytid reads them.\n")
        if former is not None and TAKE in former:
            put(settings.data, TAKE, bytes(former[TAKE]))
    return settings.data


def put(datablock: bpy.types.Text, name: str, data: bytes) -> None:
    """Gives a datablock a property of bytes."""
    # Bytes that replace others end at the first zero.
    if name in datablock:
        del datablock[name]
    datablock[name] = data


def put_rig(object: bpy.types.Object, data: bytes) -> None:
    """Keeps a rig where the settings of the object say.

    Raises `Problem` if it is to be beside a .blend file that is not saved yet.
    """
    settings = object.rhytid
    datablock = _datablock(object)
    if settings.store == "BESIDE":
        if not bpy.data.filepath:
            raise Problem("the .blend file is not saved yet, so that nothing can be beside it; save it first")
        path = Path(bpy.data.filepath).with_name(f"{bpy.path.clean_name(object.name)}.safetensors")
        path.write_bytes(data)
        settings.rig_path = f"//{path.name}"
        if RIG in datablock:
            del datablock[RIG]
    else:
        put(datablock, RIG, data)
        settings.rig_path = ""
    settings.rig_hash = digest(data)


def put_take(object: bpy.types.Object, csv: bytes, name: str) -> None:
    """Keeps a clean take, as Rhytid's CSV, in the .blend file."""
    put(_datablock(object), TAKE, zlib.compress(csv, 6))
    object.rhytid.take_hash = digest(csv)
    object.rhytid.take_name = name


def rig(object: bpy.types.Object) -> rhytid.Rig:
    """The rig of a face.

    Raises `Problem` if there is none, or if it is not what the solve made.
    """
    settings = object.rhytid
    if not settings.rig_hash:
        raise Problem(f"the face {object.name} has no rig yet; press Solve in the tab Handles")

    def read() -> rhytid.Rig:
        data = _rig_bytes(object)
        if digest(data) != settings.rig_hash:
            raise Problem(f"the rig of {object.name} is not the one that was solved; solve the face again")
        return opened(data, ".safetensors", rhytid.Rig.open)

    return _kept(RIG, settings.rig_hash, read)


def _rig_bytes(object: bpy.types.Object) -> bytes:
    settings = object.rhytid
    if settings.rig_path:
        path = Path(bpy.path.abspath(settings.rig_path))
        if not path.is_file():
            raise Problem(f"{path}: the rig of {object.name} is not there; put the file back, or solve the face again")
        return path.read_bytes()
    if settings.data is None or RIG not in settings.data:
        raise Problem(f"the rig of {object.name} is gone from the .blend file; solve the face again")
    return bytes(settings.data[RIG])


def take(object: bpy.types.Object) -> rhytid.Take:
    """The take of a face.

    Raises `Problem` if there is none, or if it is damaged.
    """
    settings = object.rhytid
    if not settings.take_hash:
        raise Problem(f"the face {object.name} has no take yet; open one in the tab Take")
    of_face = rig(object)

    def read() -> rhytid.Take:
        if settings.data is None or TAKE not in settings.data:
            raise Problem(f"the take of {object.name} is gone from the .blend file; open the take again")
        try:
            data = zlib.decompress(bytes(settings.data[TAKE]))
        except zlib.error:
            data = b""
        if digest(data) != settings.take_hash:
            raise Problem(f"the take of {object.name} is damaged; open the take again")
        return opened(data, ".csv", lambda path: rhytid.Take.open(path, of_face))

    # The same take may be of another rig.
    return _kept(TAKE, f"{settings.take_hash} {settings.rig_hash}", read)


def opened(data: bytes, ending: str, read: Callable[[Path], Any]) -> Any:
    """What `read` reads from bytes."""
    path = folder() / f"{digest(data)[:16]}{ending}"
    path.write_bytes(data)
    try:
        return read(path)
    finally:
        path.unlink()


def _kept(kind: str, key: str, read: Callable[[], Any]) -> Any:
    kept = _read[kind]
    if key not in kept:
        kept[key] = read()
        while len(kept) > MOST:
            kept.popitem(last=False)
    kept.move_to_end(key)
    return kept[key]
