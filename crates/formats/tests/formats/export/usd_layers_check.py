"""Opens each FOLDER/N.usda with FOLDER/N.usdc and compares what USD makes of them."""

import sys
from pathlib import Path

# The oldest version reads files only once Usd is there.
from pxr import Sdf, Usd  # noqa: F401

count = 0
values = 0
for text in sorted(Path(sys.argv[1]).glob("*.usda")):
    layers = [Sdf.Layer.FindOrOpen(str(path)) for path in (text, text.with_suffix(".usdc"))]
    assert all(layers), f"{text}: does not open"
    lines = [layer.ExportToString().splitlines() for layer in layers]
    for number, pair in enumerate(zip(*lines)):
        if pair[0] != pair[1]:
            sys.exit(f"{text}, line {number}: {pair[0]:.500} in text, {pair[1]:.500} in binary")
    if len(lines[0]) != len(lines[1]):
        sys.exit(f"{text}: {len(lines[0])} lines in text, {len(lines[1])} in binary")
    values += len(lines[0])
    count += 1
assert values > 50 * count, f"only {values} lines"
print(f"{count} layers are the same")
