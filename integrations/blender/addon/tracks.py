"""Positions of markers over time, from objects and from images. Needs no Blender."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Camera:
    """A camera of the scene as numbers."""

    #: 4 × 4: from the world to the camera, which looks along -z.
    from_world: np.ndarray
    #: 4 × 4: the projection to -1 … 1.
    projection: np.ndarray


def at_depth(camera: Camera, image: np.ndarray, depth_of: np.ndarray) -> np.ndarray:
    """World positions of points of an image: N × 2, from 0 to 1, from the lower left corner.

    Each point is as far in front of the camera as its point in `depth_of`, N × 3 in the world.
    """
    homogeneous = np.c_[depth_of, np.ones(len(depth_of))]
    seen = homogeneous @ camera.from_world.T
    clip = seen @ camera.projection.T
    # The same depth has the same z and w in the image.
    clip[:, :2] = (2 * image - 1) * clip[:, 3:4]
    world = clip @ np.linalg.inv(camera.projection @ camera.from_world).T
    return world[:, :3] / world[:, 3:4]


def filled(positions: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Frames × markers × 3 positions, where a marker that is not seen is on the line between its neighbours in time.

    Before it is first seen and after it is last seen, it stays. A marker that is never seen stays where it is.
    """
    result = positions.copy()
    frames = np.arange(len(positions))
    for marker in range(positions.shape[1]):
        known = np.flatnonzero(seen[:, marker])
        if 0 < len(known) < len(frames):
            for axis in range(3):
                result[:, marker, axis] = np.interp(frames, known, positions[known, marker, axis])
    return result


def at_times(positions: np.ndarray, times: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Frames × markers × 3 positions at other times, on straight lines between the frames."""
    flat = positions.reshape(len(positions), -1)
    columns = [np.interp(wanted, times, flat[:, column]) for column in range(flat.shape[1])]
    return np.stack(columns, axis=1).reshape(len(wanted), *positions.shape[1:])
