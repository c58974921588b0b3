"""Writes C3D files with ezc3d, or says as JSON what ezc3d reads from one."""
import json
import sys

import ezc3d
import numpy as np


def position(frame, point):
    return [-700 + 3 * point + frame / 16, 12.5 * point - frame / 4, 1500 - point + (frame * 7 % 64) / 16]


def write(path, points, frames, first, analogs):
    c3d = ezc3d.c3d()
    c3d["header"]["points"]["first_frame"] = first
    c3d["parameters"]["POINT"]["RATE"]["value"] = [120.0]
    c3d["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    c3d["parameters"]["POINT"]["LABELS"]["value"] = [f"a{j}" for j in range(points)]
    data = np.array([[position(i, j) + [1] for i in range(frames)] for j in range(points)]).transpose(2, 0, 1)
    data[:3, 1, 3] = np.nan
    c3d["data"]["points"] = data
    residuals = np.full((1, points, frames), 7.0)
    residuals[0, 1, 3] = -1
    residuals[0, 1, 4] = 0
    c3d["data"]["meta_points"]["residuals"] = residuals
    c3d["data"]["meta_points"]["camera_masks"] = np.zeros((7, points, frames), dtype=bool)
    if analogs:
        c3d["parameters"]["ANALOG"]["RATE"]["value"] = [360.0]
        c3d["parameters"]["ANALOG"]["LABELS"]["value"] = [f"force{j}" for j in range(analogs)]
        c3d["data"]["analogs"] = np.full((1, analogs, 3 * frames), 1234.5)
    c3d.write(path)


def read(path):
    c3d = ezc3d.c3d(path)
    point = c3d["parameters"]["POINT"]
    points = c3d["data"]["points"][:3].transpose(2, 1, 0)
    residuals = c3d["data"]["meta_points"]["residuals"][0].T
    number = lambda x: None if np.isnan(x) else float(x)
    labels = sum((point[name]["value"] for name in ["LABELS", "LABELS2", "LABELS3"] if name in point), [])
    return {
        "labels": labels,
        "rate": float(point["RATE"]["value"][0]),
        "positions": [[number(x) for x in p] for frame in points for p in frame],
        "residuals": [number(x) for frame in residuals for x in frame],
    }


if sys.argv[1] == "write":
    write(sys.argv[2], *map(int, sys.argv[3:]))
else:
    json.dump([read(path) for path in sys.argv[2:]], sys.stdout)
