"""A made face whose truth has folds: a stiff skin on a soft layer, which buckles where it is compressed.

The smooth motion is that of a take's markers. The height w of the folds over the smooth surface has the least energy

    E = ∫ B/2 (Δw)² + K/2 w² + 1/2 ∇w·ε∇w + c/4 w⁴ − f w

where ε is the strain of the smooth surface. B is the skin's stiffness and K that of the layer below. Under a compression
of more than 2 √(BK) the skin buckles with the wavelength 2π (B/K)^¼. f is a small imperfection from a seed: it decides
which side a fold goes to, and makes w a function of the frame alone.
"""

import csv

import numpy as np

from face import Face, Pose, unlike_first

# Vertices along a side.
SIDE = 97
# In cm, and the compression at which the skin buckles.
WAVELENGTH, BUCKLES_AT = 0.8, 0.15
# How high folds are, in cm, at a quarter of compression.
HEIGHT = 0.1
EXAMPLES, UNSEEN = 24, 60
STEPS, STEP = 400, 0.4


def read_take(path):
    """The markers of a take, frames × H × 3."""
    with open(path) as rows:
        next(csv.reader(rows))
        return np.array([[float(x) for x in row[1:]] for row in csv.reader(rows)]).reshape(-1, 89, 3)


def thin_plate(points, targets):
    """The rows that interpolate values at `points` to `targets`, both N×2, by thin-plate splines."""
    distance = lambda a, b: np.linalg.norm(a[:, None] - b[None], axis=2)
    kernel = lambda r: np.where(r > 0, r * r * np.log(np.maximum(r, 1e-12)), 0.0)
    plane = lambda x: np.c_[np.ones(len(x)), x]
    n = len(points)
    system = np.zeros((n + 3, n + 3))
    system[:n, :n] = kernel(distance(points, points)) + 1e-3 * np.eye(n)
    system[:n, n:] = plane(points)
    system[n:, :n] = plane(points).T
    rows = np.c_[kernel(distance(targets, points)), plane(targets)]
    return rows @ np.linalg.inv(system)[:, :n]


class Sheet:
    """A grid of SIDE × SIDE points, and the folds on it."""

    def __init__(self, width, height):
        self.spacing = np.array([width, height]) / (SIDE - 1)
        # Rows that give the derivative along a side.
        self.along = [np.gradient(np.eye(SIDE), spacing, axis=0) for spacing in self.spacing]
        k = np.arange(SIDE)
        cosines = np.cos(np.pi * np.outer(k, k + 0.5) / SIDE) * np.sqrt(2 / SIDE)
        cosines[0] /= np.sqrt(2)
        self.cosines = cosines
        waves = [np.pi * k / (SIDE * spacing) for spacing in self.spacing]
        laplacian = waves[0][None, :] ** 2 + waves[1][:, None] ** 2
        wave = 2 * np.pi / WAVELENGTH
        layer = 0.5 * BUCKLES_AT * wave**2
        stiffness = layer / wave**4
        self.fourth = 4 / 3 * (0.25 - BUCKLES_AT) * wave**2 / HEIGHT**2
        # Added on both sides, so that steps are stable: over half of the greatest tension and of the fourth power's slope.
        self.added = 0.4 * laplacian + 1.5 * self.fourth * (1.5 * HEIGHT) ** 2
        self.implicit = 1 + STEP * (stiffness * laplacian**2 + layer + self.added)
        numbers = np.random.default_rng(3)
        imperfection = numbers.standard_normal((SIDE, SIDE)) * (laplacian < (2 * wave) ** 2)
        self.imperfection = 0.3 * self.from_waves(imperfection)

    def to_waves(self, w):
        return self.cosines @ w @ self.cosines.T

    def from_waves(self, w):
        return self.cosines.T @ w @ self.cosines

    def slopes(self, w):
        """The derivatives along both sides of the grid."""
        return [w @ self.along[0].T, self.along[1] @ w]

    def edges(self, x):
        """The same of SIDE × SIDE × 3 places."""
        return [np.gradient(x, spacing, axis=axis) for spacing, axis in zip(self.spacing, (1, 0))]

    def folds(self, rest, moved):
        """The height of the folds where the smooth surface `rest` is at `moved`, both SIDE × SIDE × 3."""
        before, after = self.edges(rest), self.edges(moved)
        dot = lambda a, b: np.sum(a * b, axis=2)
        strain = [
            [0.5 * (dot(after[i], after[j]) - dot(before[i], before[j])) for j in range(2)] for i in range(2)
        ]
        strain = [[np.clip(s, -0.25, 0.3) for s in row] for row in strain]
        w = np.zeros((SIDE, SIDE))
        for _ in range(STEPS):
            slopes = self.slopes(w)
            flow = [sum(strain[i][j] * slopes[j] for j in range(2)) for i in range(2)]
            force = self.slopes(flow[0])[0] + self.slopes(flow[1])[1] - self.fourth * w**3 + self.imperfection
            known = self.to_waves(w + STEP * force) + STEP * self.added * self.to_waves(w)
            w = self.from_waves(known / self.implicit)
        return w


def folds(shared):
    """The face, its examples and unseen frames, from the clean take."""
    frames = read_take(shared / "data/takes/rom_3_clean.csv")
    markers = frames[0]
    low, high = markers[:, :2].min(0) - 0.5, markers[:, :2].max(0) + 0.5
    sides = [np.linspace(low[i], high[i], SIDE) for i in range(2)]
    grid = np.stack(np.meshgrid(*sides), axis=2)
    rows = thin_plate(markers[:, :2], grid.reshape(-1, 2))
    rest = np.concatenate([grid, (rows @ markers[:, 2]).reshape(SIDE, SIDE, 1)], axis=2)
    sheet = Sheet(*(high - low))

    def pose(frame):
        moved = rest + (rows @ (frames[frame] - markers)).reshape(SIDE, SIDE, 3)
        along = sheet.edges(moved)
        normal = np.cross(along[0], along[1])
        normal /= np.linalg.norm(normal, axis=2, keepdims=True)
        bent = moved + (sheet.folds(rest, moved) - at_rest)[:, :, None] * normal
        return Pose(f"frame {frame}", bent.reshape(-1, 3))

    # The imperfection bends the skin at rest, too. That is part of the neutral.
    at_rest = sheet.folds(rest, rest)
    index = lambda row, column: row * SIDE + column + 1
    joined = [
        f"f {index(r, c)} {index(r, c + 1)} {index(r + 1, c + 1)} {index(r + 1, c)}"
        for r in range(SIDE - 1)
        for c in range(SIDE - 1)
    ]
    flat = rest.reshape(-1, 3)
    nearest = [int(np.argmin(np.linalg.norm(flat - marker, axis=1))) for marker in markers]
    labels = {f"m{i}": v for i, v in enumerate(dict.fromkeys(nearest))}
    scanned = [pose(frame) for frame in np.linspace(100, len(frames) - 1, 2 * EXAMPLES).astype(int)]
    examples = unlike_first(flat, list(labels.values()), scanned)[:EXAMPLES]
    unseen = [pose(frame) for frame in np.linspace(60, len(frames) - 20, UNSEEN).astype(int)]
    return Face("folds", 0.01, flat, joined, labels, examples, unseen, "frames of a take, with folds")
