"""Makes the zip that Blender installs. `cargo xtask blender` and the tests run it.

    python build.py VERSION WHEEL… ZIP

The zip has the add-on, its manifest with the version and the wheels, the licences and the wheels. The same input
gives the same bytes.
"""

from __future__ import annotations

import re
import sys
import zipfile
from pathlib import Path

HERE = Path(__file__).parent
#: The oldest moment that a zip can name.
MOMENT = (1980, 1, 1, 0, 0, 0)

#: Platforms of wheels, as Blender calls them.
PLATFORMS = (
    (r"^(many)?linux.*x86_64", "linux-x64"),
    (r"^(many)?linux.*aarch64", "linux-arm64"),
    (r"macosx.*arm64", "macos-arm64"),
    (r"macosx.*x86_64", "macos-x64"),
    (r"win_amd64", "windows-x64"),
    (r"win_arm64", "windows-arm64"),
)


def platform(wheel: Path) -> str:
    """Blender's name for the platform of a wheel."""
    tag = wheel.stem.rsplit("-", 1)[-1]
    for pattern, name in PLATFORMS:
        if re.search(pattern, tag):
            return name
    raise SystemExit(f"{wheel}: its platform is {tag}, expected one that Blender runs on, such as manylinux_2_34_x86_64")


def manifest(version: str, wheels: list[Path]) -> str:
    """The manifest of the add-on with what the build knows."""
    text = (HERE / "addon" / "blender_manifest.toml").read_text(encoding="utf-8")
    added = [f'version = "{version}"']
    added += ["wheels = [", *[f'  "./wheels/{wheel.name}",' for wheel in wheels], "]"]
    names = sorted({platform(wheel) for wheel in wheels})
    added.append("platforms = [" + ", ".join(f'"{name}"' for name in names) + "]")
    # The keys stand above the first table.
    before, table, after = text.partition("\n[")
    return before.rstrip() + "\n" + "\n".join(added) + "\n" + table + after


def build(version: str, wheels: list[Path], output: Path) -> None:
    """Writes the zip."""
    files = {"blender_manifest.toml": manifest(version, wheels).encode()}
    for path in sorted((HERE / "addon").glob("*.py")):
        files[path.name] = path.read_bytes()
    for path in sorted(HERE.parents[1].glob("LICENSE-*")):
        files[path.name] = path.read_bytes()
    for wheel in wheels:
        files[f"wheels/{wheel.name}"] = wheel.read_bytes()
    output.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(output, "w") as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, MOMENT)
            entry.external_attr = 0o644 << 16
            # A wheel is compressed already.
            entry.compress_type = zipfile.ZIP_STORED if name.endswith(".whl") else zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)


if __name__ == "__main__":
    build(sys.argv[1], [Path(name) for name in sys.argv[2:-1]], Path(sys.argv[-1]))
