"""Synthetic views: what an ideal camera sees of a shape on a table at z = 0.9 m."""

import numpy as np

from vh_drake.types import ObjectView, Plane

P_CAMERA = np.array([0.21, 0.0, 1.82])
TABLE = Plane(np.array([0.0, 0.0, 1.0]), 0.9)


def visible(p, n, p_camera=P_CAMERA):
    """Points of a convex shape that face the camera."""
    return np.einsum("ij,ij->i", n, p_camera - p) > 0.0


def ball(radius=0.04, centre=(0.7, -0.3), count=2000):
    """Evenly spread points and normals of a sphere that lies on the table."""
    i = np.arange(count) + 0.5
    polar, azimuth = np.arccos(1 - 2 * i / count), np.pi * (1 + 5**0.5) * i
    n = np.column_stack(
        [np.cos(azimuth) * np.sin(polar), np.sin(azimuth) * np.sin(polar), np.cos(polar)]
    )
    return radius * n + np.array([*centre, 0.9 + radius]), n


def box(sides=(0.1, 0.06, 0.12), centre=(0.7, -0.3), step=0.004):
    """Points and normals of a box that stands on the table, its bottom left out."""
    half, points, normals = np.array(sides) / 2, [], []
    for axis in range(3):
        for sign in (-1, 1):
            if (axis, sign) == (2, -1):
                continue
            lines = [np.arange(-h + step / 2, h, step) for h in half]
            lines[axis] = np.array([sign * half[axis]])
            face = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
            points.append(face)
            normals.append(np.tile(sign * np.eye(3)[axis], (len(face), 1)))
    p = np.vstack(points) + np.array([*centre, 0.9 + half[2]])
    return p, np.vstack(normals)


def view_of(shape, p_camera=P_CAMERA):
    """The object view of a convex shape's points and normals."""
    p, n = shape
    seen = visible(p, n, p_camera)
    return ObjectView(p[seen], n[seen], TABLE, np.asarray(p_camera, float))
