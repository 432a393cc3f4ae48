"""Pictures of training and of calibration, as functions of axes and saved records."""

import io
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from vh_drake.learning.calibration import Reliability
from vh_drake.learning.training import Round


def png(figure: Figure) -> bytes:
    """A figure as a PNG; the same bytes for the same figure."""
    FigureCanvasAgg(figure)
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=100, metadata={"Software": None})
    return stream.getvalue()


def training_picture(rounds: Sequence[Round], held: Reliability) -> bytes:
    """Learning curves on the left, reliability on held-out objects on the right."""
    figure = Figure(figsize=(11.0, 4.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_curves(left, rounds)
    draw_reliability(right, {"held-out objects": held})
    return png(figure)


def draw_curves(axes: Axes, rounds: Sequence[Round]) -> None:
    """Losses, and the area under the ROC curve, over epochs."""
    epochs = [r.epoch for r in rounds]
    axes.plot(epochs, [r.train_loss for r in rounds], "o-", label="loss, training objects")
    axes.plot(epochs, [r.held_loss for r in rounds], "s-", label="loss, held-out objects")
    best = [r for r in rounds if r.best][-1:]
    axes.plot([r.epoch for r in best], [r.held_loss for r in best], "k*", ms=14, label="kept")
    axes.set(xlabel="epoch", ylabel="cross entropy [nat]", ylim=(0, None), title="Training")
    other = axes.twinx()
    other.plot(epochs, [r.held_auc for r in rounds], "^--", color="tab:green", label="ROC area")
    other.set(ylabel="area under the ROC curve, held-out objects", ylim=(0.5, 1.0))
    lines, names = axes.get_legend_handles_labels()
    more, other_names = other.get_legend_handles_labels()
    axes.legend(lines + more, names + other_names, loc="center right")


def draw_reliability(axes: Axes, diagrams: dict[str, Reliability]) -> None:
    """Observed over predicted success; the diagonal is perfect, areas show the counts."""
    axes.plot([0, 1], [0, 1], color="grey", lw=1, label="perfect")
    for name, diagram in diagrams.items():
        sizes = 20 + 400 * diagram.count / max(diagram.count.max(), 1)
        points = axes.scatter(diagram.predicted, diagram.observed, s=sizes, alpha=0.5)
        label = f"{name}, error {diagram.error:.3f}"
        color = tuple(np.asarray(points.get_facecolor())[0, :3])
        axes.plot(diagram.predicted, diagram.observed, color=color, label=label)
    axes.set(
        xlabel="predicted probability of success",
        ylabel="share that succeeded",
        xlim=(0, 1),
        ylim=(0, 1),
        title="Calibration",
    )
    axes.set_aspect("equal")
    axes.legend(loc="lower right")
