"""A box on a table as a depth camera sees it, as values and as files."""

import numpy as np
import trimesh
from sensing.synthetic_views import TABLE_Z, on_table, table, view

SIDES = (0.06, 0.10, 0.05)
YAW = 0.4


def box() -> trimesh.Trimesh:
    """The box where it stands."""
    return on_table(trimesh.creation.box(SIDES), yaw=YAW)


def box_cloud():
    """The box on its table, seen with noise."""
    return view([table(), box()])


def write_cloud(path, cloud):
    """A cloud as NPZ, with its camera."""
    np.savez(path, points=cloud.p_WC, camera=cloud.p_WCamera)
    return path


def object_alone(cloud):
    """Its points that lie on the box, not on the table."""
    p = cloud.p_WC
    near = np.hypot(p[:, 0] - 0.7, p[:, 1] + 0.3) < 0.07
    return p[near & (p[:, 2] > TABLE_Z + 0.006)]
