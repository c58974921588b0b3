"""Opens FOLDER/levels.usda and compares each of its variants with the file of that level, value by value."""

import sys
from pathlib import Path

from pxr import Usd
from stage import dump, validate

folder = Path(sys.argv[1])
files = [folder / name for name in sys.argv[2:]]
stage = Usd.Stage.Open(str(folder / "levels.usda"))
root = stage.GetDefaultPrim()
levels = root.GetVariantSet("LOD")
names = levels.GetVariantNames()
assert names == [f"LOD{i}" for i in range(len(files))], names
assert root.GetVariantSets().GetNames() == ["LOD"]
assert levels.GetVariantSelection() == "LOD0"
alone = [dump(Usd.Stage.Open(str(path))) for path in files]
assert all(len(expected) > 100 for expected in alone), "a level says little"
assert len({repr(sorted(expected.items())) for expected in alone}) == len(files), "two levels are alike"
# There and back, as somebody would who looks at each.
for i in [*range(len(files)), 0]:
    levels.SetVariantSelection(names[i])
    found = dump(stage)
    for name in {**alone[i], **found}:
        if found.get(name) != alone[i].get(name):
            sys.exit(f"{names[i]}: {name}: found {found.get(name)!r:.300}, expected {alone[i].get(name)!r:.300}")
    complaints = validate(stage)
    if complaints:
        sys.exit(f"{names[i]}: {complaints}")
print(f"{len(files)} levels are as their files")
