r"""The other hand: a hand model in SDF, reflected at the x-z plane of its own frame.

With the reflection M = diag(1, -1, 1), every frame F of the model becomes M F M, which is a
right-handed frame again. In such frames a point p turns into M p, an inertia I into M I M, the
direction of a slide into M a, and the axis of a turn, a pseudo-vector, into -M a, so that equal
joint positions are mirror images. Shapes that are symmetric themselves stay as they are.
"""

from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from vh_drake.errors import BadInput

_LOPSIDED = ("mesh", "polyline", "heightmap", "plane", "include")
_AXIS_SIGNS = {"revolute": (-1, 1, -1), "continuous": (-1, 1, -1), "prismatic": (1, -1, 1)}
# x, y, z, then roll, pitch, yaw, or a quaternion x, y, z, w
_POSE_SIGNS = ((1, -1, 1, -1, 1, -1), (1, -1, 1, -1, 1, -1, 1))


def mirrored_sdf(text: str) -> str:
    """The SDF of the other hand; all names are kept.

    Args:
        text: an SDF file whose shapes are boxes, spheres, ellipsoids, cylinders and capsules.

    Raises:
        BadInput: the text is no SDF, or holds what can't be mirrored; the message names it.
    """
    try:
        sdf = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise BadInput(f"a hand can't be mirrored, its model is no XML: {error}") from error
    if sdf.tag != "sdf":
        raise BadInput(f"only hands in SDF can be mirrored; this model is <{sdf.tag}>")
    for tag in _LOPSIDED:
        if sdf.find(f".//{tag}") is not None:
            raise BadInput(f"a hand with <{tag}> can't be mirrored; use boxes, capsules, ...")
    for pose in sdf.iter("pose"):
        if pose.text and pose.text.strip():
            _scale(pose, *_POSE_SIGNS)
    for joint in sdf.iter("joint"):
        _mirror_axis(joint)
    for tag in ("ixy", "iyz"):
        for product in sdf.iter(tag):
            _scale(product, (-1,))
    return _with_prefixes(sdf)


def _mirror_axis(joint: Element) -> None:
    axis = joint.find("axis/xyz")
    if axis is None:
        return
    kind = joint.get("type", "")
    if kind not in _AXIS_SIGNS:
        raise BadInput(f"joint {joint.get('name')!r}: no mirror image of a {kind} joint is known")
    _scale(axis, _AXIS_SIGNS[kind])


def _scale(element: Element, *signs: tuple[int, ...]) -> None:
    """Multiply the numbers of an element's text by the signs that are as many."""
    try:
        values = [float(number) for number in (element.text or "").split()]
        (fitting,) = (choice for choice in signs if len(choice) == len(values))
    except ValueError as error:
        counts = " or ".join(str(len(choice)) for choice in signs)
        raise BadInput(f"<{element.tag}> holds {element.text!r}, not {counts} numbers") from error
    element.text = " ".join(repr(s * v) for s, v in zip(fitting, values, strict=True))


def _with_prefixes(sdf: Element) -> str:
    """As text, with Drake's own elements as `drake:...`, which is how its parser knows them."""
    for element in sdf.iter():
        namespace, _, name = element.tag.rpartition("}")
        if namespace:
            element.tag = f"drake:{name}"
    sdf.set("xmlns:drake", "drake.mit.edu")
    return ElementTree.tostring(sdf, "unicode")
