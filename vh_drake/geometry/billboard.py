"""Text as a textured rectangle, for viewers that know triangles alone."""

import base64
import io
import json
from typing import Any

import numpy as np

from vh_drake.types import Array

_DPI = 100
_PIXELS_HIGH = 96
_INK, _PAPER = "#14213d", "#ffffff"


def text_billboard(text: str, *, height_m: float) -> str:
    """A glTF 2.0 file that holds everything: a sign in the plane z = 0, readable from both sides.

    glTF's y is up; Drake's readers turn it, so that in Drake's frame the sign stands in the plane
    y = 0, reads from -y, is centred at the origin and `height_m` high.
    """
    picture, aspect = _picture(text)
    corners, faces, texture_at = _two_sides(height_m * aspect / 2, height_m / 2)
    parts = [
        corners.astype("<f4").tobytes(),
        texture_at.astype("<f4").tobytes(),
        faces.astype("<u2").tobytes(),
    ]
    ends = np.cumsum([len(part) for part in parts]).tolist()
    views = [
        {"buffer": 0, "byteOffset": start, "byteLength": end - start}
        for start, end in zip([0, *ends[:-1]], ends, strict=True)
    ]
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [_mesh()],
        "materials": [_material()],
        "textures": [{"source": 0}],
        "images": [{"uri": _data_uri("image/png", picture)}],
        "buffers": [
            {"byteLength": ends[-1], "uri": _data_uri("application/octet-stream", b"".join(parts))}
        ],
        "bufferViews": views,
        "accessors": _accessors(corners, texture_at, faces),
    }
    return json.dumps(document)


def _picture(text: str) -> tuple[bytes, float]:
    """A PNG of the text on its plate, and its width over its height."""
    # Loaded where a sign is drawn: it takes longer than all else that a trial imports.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    inches = _PIXELS_HIGH / _DPI
    figure = Figure(figsize=(10.0, inches), dpi=_DPI, facecolor="none")
    canvas = FigureCanvasAgg(figure)
    label = figure.text(
        0.5, 0.5, text, size=38, weight="bold", color=_INK, ha="center", va="center"
    )
    width = label.get_window_extent(canvas.get_renderer()).width + 0.6 * _PIXELS_HIGH  # type: ignore[no-untyped-call]
    figure.set_size_inches(width / _DPI, inches)
    figure.set_facecolor(_PAPER)
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=_DPI)
    return data.getvalue(), width / _PIXELS_HIGH


def _two_sides(x: float, y: float) -> tuple[Array, Array, Array]:
    """Corners (8, 3), triangles (4, 3) and texture coordinates (8, 2) of front and back."""
    front = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]])
    back = front * [-1, 1, 1]
    texture_at = np.array([[0.0, 1], [1, 1], [1, 0], [0, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    return np.vstack([front, back]), faces, np.tile(texture_at, (2, 1))


def _mesh() -> dict[str, Any]:
    attributes = {"POSITION": 0, "TEXCOORD_0": 1}
    return {"primitives": [{"attributes": attributes, "indices": 2, "material": 0}]}


def _material() -> dict[str, Any]:
    """Shown in its own colours, whatever light falls on it."""
    return {
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0},
            "metallicFactor": 0.0,
            "roughnessFactor": 1.0,
        },
        "extensions": {"KHR_materials_unlit": {}},
    }


def _accessors(corners: Array, texture_at: Array, faces: Array) -> list[dict[str, Any]]:
    float_type, short_type = 5126, 5123
    return [
        {
            "bufferView": 0,
            "componentType": float_type,
            "count": len(corners),
            "type": "VEC3",
            "min": corners.min(axis=0).tolist(),
            "max": corners.max(axis=0).tolist(),
        },
        {
            "bufferView": 1,
            "componentType": float_type,
            "count": len(texture_at),
            "type": "VEC2",
        },
        {"bufferView": 2, "componentType": short_type, "count": faces.size, "type": "SCALAR"},
    ]


def _data_uri(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"
