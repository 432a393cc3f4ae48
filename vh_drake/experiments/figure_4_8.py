"""`reproduce figure-4.8`: what each metric selects on one object, right and wrong ones."""

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from vh_drake.atomic_files import write_bytes
from vh_drake.catalog import Options
from vh_drake.errors import BadInput
from vh_drake.experiments.metric_scenes import evaluation_objects, evaluation_settings
from vh_drake.geometry.meshes import Mask
from vh_drake.gpis.surface import estimate_surface
from vh_drake.learning.evaluating import Judged, judge_scene, judged
from vh_drake.learning.generating import hand_model, labelled_scene
from vh_drake.learning.labels import SUCCESS_RATE
from vh_drake.learning.pictures import png
from vh_drake.learning.shards import LabelledScene
from vh_drake.learning.training_objects import object_mesh
from vh_drake.reports import Report, Row

CANDIDATES = 200
PERTURBATIONS = 100
TOUCHES = 1
_ARROW_M = 0.06


def run(options: Options) -> Report:
    """One scene of the object that force closure rates worst; writes figure-4.8.png.

    The object is chosen by the baseline's mistakes alone, among all of the split.

    Raises:
        BadInput: an option is unusable.
    """
    names = evaluation_objects(options)
    settings = evaluation_settings(CANDIDATES, PERTURBATIONS)
    settings.touch_counts = [TOUCHES]
    scenes = [
        labelled_scene(object_mesh(name, options.objects), name, i, options.seed, settings)
        for i, name in enumerate(names)
    ]
    usable = [scene for scene in scenes if len(scene.candidates)]
    if not usable:
        raise BadInput("no object of this split could be grasped at all; choose other objects")
    rows = [judged(judge_scene(scene, options.weights), [TOUCHES]) for scene in usable]
    worst = int(np.argmax([_false(row, "nominal") for row in rows]))
    write_bytes(options.out / "figure-4.8.png", draw(usable[worst], rows[worst]))
    summary = {"object": rows[worst].object, **_counts(rows[worst])}
    content = {
        "split": options.split or ("test" if options.objects else "validation kinds"),
        "candidates": CANDIDATES,
        "perturbations": PERTURBATIONS,
        "touches": TOUCHES,
        "seed": options.seed,
    }
    table = [{"object": row.object, **_counts(row)} for row in rows]
    return Report("figure-4.8", content, summary, {}, table)


def draw(scene: LabelledScene, row: Judged) -> bytes:
    """Selected candidates as arrows along the palm: green succeed, red fail."""
    figure = Figure(figsize=(13.0, 6.5), layout="constrained")
    titles = {"nominal": "force closure on the estimate", "learned": "learned metric"}
    for i, (name, title) in enumerate(titles.items()):
        axes: Axes3D = figure.add_subplot(1, 2, i + 1, projection="3d", computed_zorder=False)
        chosen = row.selected(name)
        draw_selection(axes, scene, chosen)
        right = int((scene.label_rate[chosen] > SUCCESS_RATE).sum())
        axes.set_title(f"{title}: {right} right, {int(chosen.sum()) - right} wrong")
    figure.suptitle(f"{scene.object}: selected grasps; green succeed on the true object")
    return png(figure)


def draw_selection(axes: Axes3D, scene: LabelledScene, chosen: Mask) -> None:
    """The estimate, and an arrow from each selected hand towards where its palm faces."""
    surface = estimate_surface(scene.view, scene.contacts)
    triangles = surface.vertices[surface.faces]
    axes.add_collection3d(
        Poly3DCollection(triangles, facecolors=[(0.7, 0.75, 0.85)], shade=True, zorder=0)
    )
    hand = hand_model("")
    palm = np.asarray(hand.description.palm) / np.linalg.norm(hand.description.palm)
    X_WH = scene.candidates.X_WH[chosen]
    succeed = scene.label_rate[chosen] > SUCCESS_RATE
    p, way = X_WH[:, :3, 3], X_WH[:, :3, :3] @ palm
    for own, color in ((succeed, "green"), (~succeed, "red")):
        start = p[own] - _ARROW_M * way[own]
        axes.quiver(*start.T, *(_ARROW_M * way[own]).T, color=color, lw=1.0, zorder=1)
    # Limits are those of all candidates, so that both pictures show the same.
    tips = scene.candidates.X_WH[:, :3, 3]
    tails = tips - _ARROW_M * (scene.candidates.X_WH[:, :3, :3] @ palm)
    shown = np.vstack([surface.vertices, tips, tails])
    low, high = shown.min(axis=0), shown.max(axis=0)
    axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=0.95)
    axes.locator_params(nbins=4)


def _false(row: Judged, name: str) -> int:
    return int((row.selected(name) & ~row.success).sum())


def _counts(row: Judged) -> Row:
    """True and false positives of both metrics."""
    counts: Row = {"candidates": len(row.success), "succeeding": int(row.success.sum())}
    for name in ("nominal", "learned"):
        counts[f"{name}_true"] = int((row.selected(name) & row.success).sum())
        counts[f"{name}_false"] = _false(row, name)
    return counts
