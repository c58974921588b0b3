"""The kinds of files that `rhytid animate` writes for the clients."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Kind:
    # As in the table: the ending and the options.
    name: str
    file: str
    options: tuple = ()
    # By how much the file itself may be off, in millimetres.
    error: float = 0.001
    # By how much it may turn a normal.
    degrees: float = 0.1
    # Of the face's two materials, those that have their look in the file.
    looks: int = 2

    @property
    def format(self):
        ending = self.file.rsplit(".", 1)[1]
        return "usd" if ending.startswith("usd") else "gltf" if ending in ("glb", "gltf") else ending


KINDS = [
    Kind(".usd", "face.usd"),
    Kind(".usda", "text.usda"),
    Kind(".usdz", "package.usdz"),
    Kind(".usd --shapes 4", "shapes.usd", ("--shapes", "4"), 0.5, 1.0),
    Kind(".glb", "exact.glb"),
    Kind(".gltf", "text.gltf"),
    Kind(".glb --materials one", "one.glb", ("--materials", "one"), looks=0),
    Kind(".glb --compressed", "compressed.glb", ("--compressed",), 0.1, 1.0),
    Kind(".glb --quantize", "quantized.glb", ("--quantize",), 0.01, 1.0),
    Kind(".glb --compressed --quantize --meshopt", "small.glb", ("--compressed", "--quantize", "--meshopt"), 0.1, 1.0),
    Kind(".glb --shapes 4", "shapes.glb", ("--shapes", "4"), 0.5, 1.0),
    Kind(".pc2", "cache.pc2", ("--head", "bake")),
]
