"""Opens files with USD, has them validated, and writes every sample of every attribute, bit for bit.

    python usd.py JOB

JOB is a JSON file: `files` to open and `out` (a folder). For file number i, `out`/i/NAME gets all time samples of the
attribute NAME one after the other, as USD has them in memory. Printed: USD's version; for each file the time codes of
each attribute's `samples`, and the scene as USD writes it when it is `flattened`, without what names the file.
Runs with the newest USD and with versions that have no UsdValidation yet.
"""

import json
import sys
from pathlib import Path

from pxr import Gf, Usd, UsdGeom, UsdUtils

try:
    from pxr import UsdValidation
except ImportError:
    UsdValidation = None


def complaints(path):
    """What USD finds wrong with a file."""
    if UsdValidation:
        validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        errors = UsdValidation.ValidationContext(validators).Validate(Usd.Stage.Open(str(path)))
        return [error.GetErrorAsString() for error in errors]
    checker = UsdUtils.ComplianceChecker()
    checker.CheckCompliance(str(path))
    return checker.GetErrors() + checker.GetFailedChecks() + checker.GetWarnings()


def check_that_there_are_complaints(folder):
    """A stage without metadata must not pass, or silence about ours would mean nothing."""
    path = folder / "bad.usda"
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.Mesh.Define(stage, "/mesh")
    stage.Save()
    found = " ".join(complaints(path))
    for word in ("upAxis", "defaultPrim"):
        assert word in found, f"USD does not miss {word}: {found}"


def bits(value):
    """A sample's bytes."""
    if isinstance(value, Gf.Matrix4d):
        # Its rows; a matrix by itself is no buffer.
        return b"".join(memoryview(value.GetRow(row)).tobytes() for row in range(4))
    return memoryview(value).tobytes()


def read(path, out):
    """Writes the samples of a file; returns what is printed of it."""
    found = complaints(path)
    assert not found, f"{path.name}: {found}"
    stage = Usd.Stage.Open(str(path))
    meshes = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    assert len(meshes) == 1, f"{path.name}: {len(meshes)} meshes, expected 1"
    [mesh] = meshes
    counts, indices = mesh.GetFaceVertexCountsAttr().Get(), mesh.GetFaceVertexIndicesAttr().Get()
    valid, reason = UsdGeom.Mesh.ValidateTopology(indices, counts, len(mesh.GetPointsAttr().Get()))
    assert valid, f"{path.name}: {reason}"

    out.mkdir()
    samples = {}
    for prim in stage.Traverse():
        for attribute in prim.GetAuthoredAttributes():
            if codes := attribute.GetTimeSamples():
                assert attribute.GetName() not in samples, f"two animated {attribute.GetName()}"
                samples[attribute.GetName()] = codes
                with open(out / attribute.GetName(), "wb") as file:
                    for code in codes:
                        file.write(bits(attribute.Get(code)))
    flattened = stage.Flatten(addSourceFileComment=False).ExportToString()
    return {"samples": samples, "flattened": flattened}


job = json.loads(Path(sys.argv[1]).read_text())
folder = Path(job["out"])
check_that_there_are_complaints(folder)
files = [read(Path(file), folder / str(number)) for number, file in enumerate(job["files"])]
print(json.dumps({"version": Usd.GetVersion(), "files": files}))
