"""The real robot's look: visual meshes of the PyPI package `armar`, repaired into a cache.

The package (CC BY-NC 4.0) is optional and nothing of it is copied into ours. Its meshes
come out of the cache as plain .obj files of a few colours. What is mended on the way:
materials that are transparent by mistake, meshes so heavy that recordings would grow beyond
use, and textures that hold one flat colour a triangle.
"""

import logging
import os
import tempfile
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import trimesh
from scipy.spatial import KDTree

from vh_drake.geometry.decomposition import cache_folder
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.remesh import simplify
from vh_drake.types import Array, IntArray

# All of them weigh about 5 MB in a recording; the arm is seen from near by.
TRIANGLES = {"platform": 4500, "upper_neck": 4000, "torso": 3500, "left_hand_fixed": 3000}
OTHER_TRIANGLES = 2000
COLOURS = 6
REPAIR_VERSION = 3  # part of the cache's folder name; raise it when the repair changes
HIDDEN_LINKS = ("hand_fixed_r1",)  # the articulated hand is there


def armar_visuals(cache: Path | None = None) -> dict[str, Element]:
    """URDF visual elements with the real meshes, by link name.

    Empty where the package is not installed, and without the meshes that can't be read
    or written, so that a robot can always be shown by its own shapes.

    Args:
        cache: folder of the repaired meshes, by default a new one for each `REPAIR_VERSION`.
    """
    package = find_spec("armar")
    if package is None or package.origin is None:
        return {}
    description = Path(package.origin).parent / "description"
    cache = cache or cache_folder() / f"armar6-{REPAIR_VERSION}"
    visuals = {}
    try:
        for name, visual in _published_visuals(description).items():
            visuals[name] = _repaired_visual(visual, description, cache)
    except (OSError, ValueError, ElementTree.ParseError) as error:
        logging.getLogger(__name__).warning("meshes of the package armar are left out: %s", error)
    return visuals


def repair_mesh_file(source: Path, target: Path, colour: Array, triangles: int) -> None:
    """Write `source` (.obj, textured or not) as a light .obj of flat colours with its .mtl.

    Both files appear whole or not at all.

    Args:
        source: published mesh.
        target: the .obj to write; its .mtl gets the same stem.
        colour: rgb (3,) in 0..1 where the mesh has no texture.
        triangles: about how many remain.
    """
    published = trimesh.load(source, force="mesh", process=False)
    palette, face_colours = _palette(published, colour)
    merged = trimesh.Trimesh(published.vertices, published.faces, process=True)
    merged.merge_vertices(digits_vertex=6)
    light = simplify(TriMesh(np.array(merged.vertices), np.array(merged.faces)), triangles)
    _, nearest = KDTree(published.triangles_center).query(light.vertices[light.faces].mean(axis=1))
    target.parent.mkdir(parents=True, exist_ok=True)
    material = target.with_suffix(".mtl")
    _write_whole(material, _material_text(palette))
    _write_whole(target, _object_text(light, face_colours[nearest], material.name))


def _published_visuals(description: Path) -> dict[str, Element]:
    """Visual elements of the package's robot, without those that ours never shows."""
    text = (description / "urdf" / "armar6.urdf").read_text()
    links = ElementTree.fromstring(text).iterfind("link")
    found = {link.get("name", ""): link.find("visual") for link in links}
    return {
        name: visual
        for name, visual in found.items()
        if visual is not None and name not in HIDDEN_LINKS
    }


def _repaired_visual(visual: Element, description: Path, cache: Path) -> Element:
    """The visual element with its mesh out of the cache, which is filled where needed."""
    mesh, colour = visual.find("geometry/mesh"), visual.find("material/color")
    if mesh is None or colour is None:
        raise ValueError("a visual of the package's URDF lacks its mesh or its colour")
    source = description / mesh.get("filename", "").removeprefix("package://armar/description/")
    rgb = np.array([float(number) for number in colour.get("rgba", "").split()[:3]])
    target = cache / f"{source.stem}_{'_'.join(f'{value:.3f}' for value in rgb)}.obj"
    if not target.is_file():
        triangles = TRIANGLES.get(source.stem, OTHER_TRIANGLES)
        repair_mesh_file(source, target, rgb, triangles)
    repaired = Element("visual", name="armar_mesh")
    SubElement(repaired, "origin", xyz="0 0 0", rpy="0 0 0")
    geometry = SubElement(repaired, "geometry")
    scale = mesh.get("scale", "1 1 1")
    SubElement(geometry, "mesh", filename=target.resolve().as_uri(), scale=scale)
    return repaired


def _palette(mesh: trimesh.Trimesh, colour: Array) -> tuple[Array, IntArray]:
    """A few rgb colours (k, 3) in 0..1, and which of them each triangle has (n,)."""
    uv = getattr(mesh.visual, "uv", None)
    if uv is None:
        return colour[None], np.zeros(len(mesh.faces), np.int64)
    middle = uv[mesh.faces].mean(axis=1)
    sampled = mesh.visual.material.to_color(middle)[:, :3] / 255.0
    bins, members = np.unique(np.round(sampled * 7.0), axis=0, return_inverse=True)
    area = np.bincount(members.ravel(), weights=mesh.area_faces, minlength=len(bins))
    common = np.argsort(-area, kind="stable")[:COLOURS]
    palette = np.array([np.median(sampled[members.ravel() == i], axis=0) for i in common])
    _, face_colours = KDTree(palette).query(sampled)
    return palette, face_colours


def _material_text(palette: Array) -> str:
    """Opaque: the published files say Tr 1, which means wholly transparent."""
    materials = [
        f"newmtl colour_{i}\nKd {r:.4f} {g:.4f} {b:.4f}\nKs 0.1 0.1 0.1\nd 1.0\n"
        for i, (r, g, b) in enumerate(palette)
    ]
    return "\n".join(materials)


def _object_text(mesh: TriMesh, colours: IntArray, material_name: str) -> str:
    """Wavefront text with normals that follow creases of more than 30 degrees."""
    lines = [f"mtllib {material_name}"]
    offset = 1
    for colour in np.unique(colours):
        part = trimesh.Trimesh(mesh.vertices, mesh.faces[colours == colour], process=False)
        smooth = trimesh.graph.smooth_shade(part, angle=np.radians(30.0))
        lines += [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in smooth.vertices]
        lines += [f"vn {x:.2f} {y:.2f} {z:.2f}" for x, y, z in smooth.vertex_normals]
        lines.append(f"usemtl colour_{colour}")
        corners = smooth.faces + offset
        lines += [f"f {a}//{a} {b}//{b} {c}//{c}" for a, b, c in corners]
        offset += len(smooth.vertices)
    return "\n".join(lines) + "\n"


def _write_whole(path: Path, text: str) -> None:
    """Write beside the target, then rename, so that a reader never sees half a file."""
    with tempfile.NamedTemporaryFile("w", dir=path.parent, suffix=".tmp", delete=False) as file:
        file.write(text)
    os.replace(file.name, path)
