"""A program of a user, for the type checkers."""

from pathlib import Path

import numpy as np

import rhytid

face = rhytid.Face.open("face.toml")
rig = face.solve(progress=True)
rig.save(Path("face.safetensors"))
take = rhytid.Take.open("session.c3d", rig, missing="hold")
animation = rig.play(take, device="cpu:0", fps=24, strain=True, frames=range(10, 20))
positions: "np.ndarray[tuple[int, ...], np.dtype[np.float32]]" = animation[0].positions
names: list[str] = [name for frame in animation for name in frame.keys()]
animation.write("face.usd", velocities=True)
found = rhytid.evaluate(face, device="cpu:0")
rhytid.prepare("raw.c3d", rig="face.safetensors", output="clean.csv", map={"chin": "M1"})
picture = rhytid.render(rig, take, count=3)
pixels: int = picture.array.size
for finding in face.doctor():
    print(finding["message"])
