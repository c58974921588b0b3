"""Section 2's system in SuiteSparse's CHOLMOD, and with --superlu in SciPy's SuperLU.

    python solve.py FOLDER [--superlu]

FOLDER holds the matrix's lower triangle and the right-hand sides, both as compressed columns, and the solution to
compare with. Prints one line of JSON for each way: seconds of ordering (with the symbolic analysis), factorisation
and solves, and how far its solution is from the other, as a part of the largest number in it.
"""

import json
import platform
import sys
import time
from pathlib import Path

import numpy as np
import scipy.sparse
import scipy.sparse.linalg
import sksparse
import sksparse.cholmod


def load(folder, name, shape):
    parts = [np.load(folder / f"{name}_{part}.npy") for part in ("values", "rows", "offsets")]
    values, rows, offsets = parts
    return scipy.sparse.csc_matrix((values, rows.astype(np.int32), offsets.astype(np.int32)), shape)


def timed(work):
    start = time.perf_counter()
    result = work()
    return result, time.perf_counter() - start


def tell(name, times, solution, expected):
    difference = float(np.abs(solution - expected).max() / np.abs(expected).max())
    print(json.dumps({"name": name, "seconds": times, "difference": difference}), flush=True)


def main():
    folder = Path(sys.argv[1])
    expected = np.load(folder / "solution.npy", mmap_mode="r")
    n, k = expected.shape
    lower = load(folder, "matrix", (n, n))
    # LAPACK's order, so that no copy is timed.
    right = np.asfortranarray(load(folder, "right", (n, k)).toarray())
    for ordering in ("amd", "metis", "nesdis"):
        factor, ordered = timed(
            lambda: sksparse.cholmod.analyze(lower, mode="supernodal", ordering_method=ordering)
        )
        _, factorised = timed(lambda: factor.cholesky_inplace(lower))
        # All at once, or in blocks that need less memory: whichever is faster here.
        solution, whole = timed(lambda: factor.solve_A(right))
        blocks = range(0, k, 16)
        _, parts = timed(lambda: [factor.solve_A(right[:, i : i + 16]) for i in blocks])
        solved = min(whole, parts)
        versions = f"scikit-sparse {sksparse.__version__}, Python {platform.python_version()}"
        tell(f"CHOLMOD, {ordering} ({versions})", [ordered, factorised, solved], solution, expected)
        del factor, solution
    if "--superlu" in sys.argv:
        whole = (lower + scipy.sparse.tril(lower, -1).T).tocsc()
        factor, factorised = timed(lambda: scipy.sparse.linalg.splu(whole))
        solution, solved = timed(lambda: factor.solve(right))
        tell(f"SuperLU (SciPy {scipy.__version__})", [0.0, factorised, solved], solution, expected)


main()
