"""Runs CoACD for `decomposition`, as a script in a process of its own.

A mesh comes in on standard input, pieces go out on standard output, both as NPZ; options are
JSON in the first argument.
"""

import io
import json
import os
import sys

import numpy as np


def main() -> None:
    """Cut the mesh; whatever CoACD prints goes to standard error."""
    import coacd  # Here, so that others may ask for this file's name at no cost.

    out = os.dup(1)
    os.dup2(2, 1)
    coacd.set_log_level("off")
    with np.load(io.BytesIO(sys.stdin.buffer.read()), allow_pickle=False) as given:
        mesh = coacd.Mesh(given["vertices"], given["faces"])
    parts = coacd.run_coacd(mesh, **json.loads(sys.argv[1]))
    pieces = io.BytesIO()
    np.savez(pieces, *(np.asarray(vertices, np.float64) for vertices, _ in parts))
    with os.fdopen(out, "wb") as file:
        file.write(pieces.getvalue())


if __name__ == "__main__":
    main()
