"""What USD's own validators say of a file: UsdValidation in new versions, the compliance checker in old ones."""

import tempfile
from pathlib import Path

from pxr import Usd, UsdGeom

try:
    from pxr import UsdValidation
except ImportError:
    UsdValidation = None
    from pxr import UsdUtils


def validate(path):
    """All complaints of all validators about the file, as a list of texts."""
    if UsdValidation is None:
        checker = UsdUtils.ComplianceChecker()
        checker.CheckCompliance(str(path))
        return checker.GetErrors() + checker.GetFailedChecks() + checker.GetWarnings()
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) >= 20, f"only {len(validators)} validators are registered"
    context = UsdValidation.ValidationContext(validators)
    return [error.GetErrorAsString() for error in context.Validate(Usd.Stage.Open(str(path)))]


def check_that_validators_complain():
    """A stage without metadata must not pass, or the silence about ours would mean nothing."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bad.usda"
        stage = Usd.Stage.CreateNew(str(path))
        UsdGeom.Mesh.Define(stage, "/mesh")
        stage.Save()
        complaints = " ".join(validate(path))
    for expected in ["metersPerUnit", "upAxis", "defaultPrim"]:
        assert expected in complaints, f"the validators do not miss {expected}: {complaints}"
