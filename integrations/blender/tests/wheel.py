"""A wheel of the package as it is, without maturin: for tests."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path


def wheel(package: Path, version: str, folder: Path) -> Path:
    """Packs the folder that has `rhytid` into a wheel of the version."""
    path = folder / f"rhytid-{version}-cp310-abi3-manylinux_2_17_x86_64.whl"
    about = f"rhytid-{version}.dist-info"
    with zipfile.ZipFile(path, "w") as archive:
        names = []
        for file in sorted((package / "rhytid").iterdir()):
            if file.is_file():
                names.append(f"rhytid/{file.name}")
                archive.write(file, names[-1])
        texts = {
            "METADATA": f"Metadata-Version: 2.1\nName: rhytid\nVersion: {version}\n",
            "WHEEL": "Wheel-Version: 1.0\nGenerator: tests\nRoot-Is-Purelib: false\nTag: cp310-abi3-manylinux_2_17_x86_64\n",
        }
        texts["RECORD"] = "".join(f"{name},,\n" for name in [*names, *(f"{about}/{name}" for name in [*texts, "RECORD"])])
        for name, text in texts.items():
            archive.writestr(f"{about}/{name}", text)
    return path


if __name__ == "__main__":
    print(wheel(Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3])))
