"""Opens each FOLDER/*/renamed.* with USD and compares it with the whole.usd beside it, value by value."""

import sys
from pathlib import Path

from pxr import Usd, UsdGeom
from stage import dump, validate

renamed = sorted(Path(sys.argv[1]).glob("*/renamed.*"))
for path in renamed:
    expected = dump(Usd.Stage.Open(str(path.parent / "whole.usd")))
    stage = Usd.Stage.Open(str(path))
    found = dump(stage)
    assert len(expected) > 100, "the whole says little"
    for name in {**expected, **found}:
        if found.get(name) != expected.get(name):
            sys.exit(f"{path}: {name}: found {found.get(name)!r:.300}, expected {expected.get(name)!r:.300}")
    mesh = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    for name, varies in [("points", True), ("faceVertexCounts", False), ("faceVertexIndices", False)]:
        assert mesh.GetAttribute(name).ValueMightBeTimeVarying() == varies, name
    complaints = validate(stage)
    if complaints:
        sys.exit(f"{path}: {complaints}")
print(f"{len(renamed)} renamed files play as the whole")
