"""`reproduce figure-3.5`: figures 3.5 to 3.10, Gaussian processes and surfaces by example.

Figures 3.5 to 3.8 are of functions of one variable, without units; 3.9 and 3.10 are implicit
surfaces in the plane by the formulation without normals. This package evaluates both along a line
and in a plane in space. The potential is negative inside (errata to eq. 3.5).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.figure_3_13 import observed, on_line
from vh_drake.experiments.figure_files import save_figure
from vh_drake.experiments.plane_potential import draw_plane, in_plane
from vh_drake.gpis.inside_outside import InsideOutside, inside_outside_observations, ring
from vh_drake.gpis.kernels import SquaredExponential, ThinPlate
from vh_drake.gpis.posterior import SCALE_M, Posterior, fit
from vh_drake.reports import Report, Row
from vh_drake.types import Array

KERNEL = SquaredExponential(1.0, 1.0)  # σ = 1 gives table 3.3
WIDTHS = (0.5, 1.0, 2.0)  # of figure 3.5
PLACES, VALUES = np.array([-2.0, -1.0, 0.0, 1.0, 2.0]), np.array([0.0, 1.0, 3.0, 2.0, 1.0])
GAPS = (1.0, 0.5, 0.25, 0.125, 0.0625)  # between the third and the fourth place
NOISES = (0.01, 0.1, 0.3, 1.0)
TABLE_3_3 = (  # weights of the dissertation for each gap
    (0.75, -2.35, 5.1, -1.56, 1.28),
    (2.21, -6.32, 15.38, -10.38, 2.36),
    (5.2, -15.13, 57.84, -48.37, 3.8),
    (11.09, -33.14, 228.07, -208.98, 6.53),
    (22.75, -69.24, 907.38, -868.77, 11.93),
)
X = np.linspace(-4.0, 4.0, 401)
RING = ring(12)
RADIUS_M = 0.04  # of the outline
PLATE = ThinPlate(1.0)


@dataclass(frozen=True, eq=False)
class Example:
    """Contacts in the plane and the outline that they are taken from."""

    title: str
    p: Array  # (n, 2) [m]
    contact_std_m: float


def run(options: Options) -> Report:
    """Compute the weights of table 3.3; writes figure-3.5.png to figure-3.10.png."""
    draw: dict[int, Callable[[Figure], None]] = {
        5: draw_kernels,
        6: draw_posterior,
        7: draw_contradiction,
        8: draw_noise,
        9: lambda figure: draw_surfaces(
            figure, sparse_and_dense(), "Figure 3.9: sparse and dense contacts"
        ),
        10: lambda figure: draw_surfaces(
            figure, uneven_and_contradictory(options.seed), "Figure 3.10: imperfect contacts"
        ),
    }
    for number, function in draw.items():
        figure = Figure(figsize=(10.0, 5.0), layout="constrained")
        function(figure)
        save_figure(options.out / f"figure-3.{number}.png", figure)
    rows = [weights_row(gap) for gap in GAPS]
    ours = np.array([[row[f"w{i}"] for i in range(1, 6)] for row in rows])
    summary = {"table_3_3_largest_difference": float(np.abs(ours - np.array(TABLE_3_3)).max())}
    return Report("figure-3.5", {"seed": options.seed}, summary, {}, rows)


def posterior_of(gap: float, noise_std: float = 0.0) -> Posterior:
    """The process on table 3.2 with the fourth place moved to the given distance of the third."""
    places = PLACES.copy()
    places[3] = places[2] + gap
    return fit(KERNEL, observed(places, VALUES, noise_std))


def weights_row(gap: float) -> Row:
    """The weights ω of eq. 3.14, a row of table 3.3."""
    weights = posterior_of(gap).weights[:, 0] / SCALE_M  # undo the scaling of lengths
    return {"gap": gap, **{f"w{i}": float(w) for i, w in enumerate(weights, start=1)}}


def draw_kernels(figure: Figure) -> None:
    """Figure 3.5."""
    axes = figure.subplots()
    for width in WIDTHS:
        axes.plot(X, np.exp(-0.5 * X**2 / width**2), label=f"σ = {width:g}")
    axes.set(xlabel="distance [-]", ylabel="k [-]", title="Figure 3.5: Gaussian kernels, eq. 3.8")
    axes.legend()


def draw_posterior(figure: Figure) -> None:
    """Figure 3.6."""
    axes = figure.subplots()
    posterior = posterior_of(1.0)
    axes.plot(X, posterior.mean(on_line(X)), label="f*, a sum of kernels")
    for place, weight in zip(PLACES, posterior.weights[:, 0] / SCALE_M, strict=True):
        axes.plot(X, weight * np.exp(-0.5 * (X - place) ** 2), "k:", lw=0.8)
    axes.plot(PLACES, VALUES, "o", color="tab:red", label="observations, table 3.2")
    _label(axes, "Figure 3.6: posterior; dotted: the weighted kernels")


def draw_contradiction(figure: Figure) -> None:
    """Figure 3.7."""
    axes = figure.subplots()
    for gap in GAPS:
        posterior = posterior_of(gap)
        line = axes.plot(X, posterior.mean(on_line(X)), label=f"|x3 - x4| = {gap:g}")[0]
        axes.plot(posterior.observations.p[:, 0], VALUES, "o", ms=4, color=line.get_color())
    _label(axes, "Figure 3.7: the nearer contradictory observations, the wilder the posterior")


def draw_noise(figure: Figure) -> None:
    """Figure 3.8."""
    axes = figure.subplots()
    for noise in NOISES:
        posterior = posterior_of(GAPS[-1], noise)
        axes.plot(X, posterior.mean(on_line(X)), label=f"σn = {noise:g}")
    axes.plot(posterior.observations.p[:, 0], VALUES, "o", color="tab:red", label="observations")
    _label(axes, "Figure 3.8: observation noise lets contradictory observations be (eq. 3.16)")


def _label(axes: Axes, title: str) -> None:
    axes.set(xlabel="x [-]", ylabel="f [-]", title=title)
    axes.legend()


def on_blob(angle: Array) -> Array:
    """Places (n, 2) on a rounded outline [m]."""
    radius = RADIUS_M * (1.0 + 0.2 * np.cos(2.0 * angle) + 0.08 * np.sin(3.0 * angle))
    places: Array = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    return places


def sparse_and_dense() -> list[Example]:
    """Few and many contacts around the outline."""
    few, many = (2.0 * np.pi * (np.arange(n) + 0.3) / n for n in (6, 40))
    return [
        Example("6 contacts", on_blob(few), 0.0005),
        Example("40 contacts", on_blob(many), 0.0005),
    ]


def uneven_and_contradictory(seed: int) -> list[Example]:
    """Contacts crowded on one side, and contacts that scatter about the outline."""
    rng = np.random.default_rng(seed)
    crowded = np.concatenate([rng.uniform(0.0, 1.5, 20), [2.2, 3.0, 3.9, 4.8, 5.6]])
    around = rng.uniform(0.0, 2.0 * np.pi, 60)
    scattered = on_blob(around) * (1.0 + rng.normal(0.0, 0.06, (60, 1)))
    return [
        Example("20 contacts on one side, 5 elsewhere", on_blob(crowded), 0.0005),
        Example("60 contacts that contradict each other", scattered, 0.004),
    ]


def draw_surfaces(figure: Figure, examples: Sequence[Example], title: str) -> None:
    """Figures 3.9 and 3.10."""
    outline = on_blob(np.linspace(0.0, 2.0 * np.pi, 200))
    corner = np.full(2, 0.07)
    for axes, example in zip(figure.subplots(1, 2), examples, strict=True):
        p = in_plane(example.p)
        settings = InsideOutside(contact_std_m=example.contact_std_m)
        posterior = fit(PLATE, inside_outside_observations(p, settings, directions=RING))
        draw_plane(axes, posterior, p, truth=outline, low=-corner, high=corner)
        axes.set_title(example.title)
    figure.axes[0].legend(loc="upper right", fontsize=8)
    figure.suptitle(f"{title}. Blue is inside; the points inside and around are not shown")
