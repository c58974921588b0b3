"""Public collections of meshes, each from the package that brings them."""

import shutil
import subprocess
import sys
import tarfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

ENDINGS = {".obj", ".ply", ".glb", ".gltf", ".vrm", ".usd", ".usda", ".usdc", ".usdz"}


@dataclass
class Package:
    """A package, where it comes from, and the words in paths of files that are too many of a kind."""

    source: str
    name: str
    version: str
    without: tuple = ()

    def label(self):
        return f"{self.name} {self.version} ({self.source})"


PACKAGES = [
    Package("Debian", "assimp-testmodels", "5.2.5~ds0-1"),
    Package("npm", "@webxr-input-profiles/assets", "1.0.20"),
    # A thousand blocks that one program made.
    Package("PyPI", "pybullet", "3.2.7", without=("random_urdfs",)),
    Package("PyPI", "genesis-world", "1.4.5"),
    Package("PyPI", "mani_skill", "3.0.1"),
    # Most of its USD files are joints and boxes without a mesh.
    Package("PyPI", "newton", "1.8.0", without=("kamino",)),
    Package("PyPI", "pyvista", "0.49.1"),
    Package("PyPI sources", "compas", "2.15.1"),
    Package("PyPI sources", "meshio", "5.3.5"),
    Package("crates.io", "ply-rs", "0.1.3"),
    Package("crates.io", "obj-rs", "0.7.4"),
    Package("crates.io", "easy-gltf", "1.1.5"),
    Package("crates.io", "wavefront_obj", "11.0.0"),
]


def fetch(package, folder):
    """The folder with the unpacked package, which is fetched once."""
    unpacked = folder / package.name.replace("/", "_").lstrip("@")
    if unpacked.is_dir():
        return unpacked
    part = unpacked.with_name(unpacked.name + ".part")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    {
        "Debian": from_debian,
        "npm": from_npm,
        "PyPI": from_pypi,
        "PyPI sources": from_pypi,
        "crates.io": from_crates,
    }[package.source](package, part)
    part.rename(unpacked)
    return unpacked


def from_debian(package, folder):
    run("apt-get", "download", f"{package.name}={package.version}", at=folder)
    for archive in folder.glob("*.deb"):
        run("dpkg-deb", "-x", archive.name, ".", at=folder)
        archive.unlink()


def from_npm(package, folder):
    run("npm", "pack", "--silent", f"{package.name}@{package.version}", at=folder)
    unpack(folder)


def from_pypi(package, folder):
    kind = "--no-binary" if package.source == "PyPI sources" else "--only-binary"
    which = [kind, package.name, "--no-deps", f"{package.name}=={package.version}"]
    run(sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", *which, at=folder)
    unpack(folder)


def from_crates(package, folder):
    manifest = '[package]\nname = "collection"\nversion = "0.0.0"\n[workspace]\n[dependencies]\n'
    (folder / "Cargo.toml").write_text(f'{manifest}{package.name} = "={package.version}"\n')
    (folder / "src").mkdir()
    (folder / "src/lib.rs").touch()
    run("cargo", "vendor", "--quiet", "--versioned-dirs", at=folder)
    for other in (folder / "vendor").iterdir():
        if other.name != f"{package.name}-{package.version}":
            shutil.rmtree(other)


def unpack(folder):
    """Unpacks what was fetched into a folder, and removes the archives."""
    for archive in list(folder.iterdir()):
        if archive.suffix == ".whl":
            with zipfile.ZipFile(archive) as whole:
                whole.extractall(folder)
        else:
            with tarfile.open(archive) as whole:
                whole.extractall(folder, filter="data")
        archive.unlink()


def run(*command, at):
    print("$", *command, file=sys.stderr)
    subprocess.run(command, cwd=at, check=True, stdout=sys.stderr)


def meshes_below(folder, without=()):
    """The meshes of a folder in the order of their paths."""
    files = [path for path in Path(folder).rglob("*") if path.suffix.lower() in ENDINGS and path.is_file()]
    return sorted(path for path in files if not any(word in str(path) for word in without))
