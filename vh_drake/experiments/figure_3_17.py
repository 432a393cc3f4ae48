"""`reproduce figure-3.17`: figures 3.17 to 3.19, what rates a touch.

Figure 3.17 shows Ψ1 and Ψ2 around a contact, with σ1 = μ3 = σ3 = 1 and no units. Figure 3.18
explores a plane by Ψ1 Ψ2 Ψ3 from its centre; the touches go around it and outwards, roughly in a
spiral. Figure 3.19 is
the angular kernel Ψ4 (eq. 3.67 as corrected).
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.figure_files import save_figure
from vh_drake.exploration.ratings import IgefSettings, locality, rotation, travel, uncertainty
from vh_drake.exploration.trajectory import approach_curves, arc_length
from vh_drake.reports import Report, Row
from vh_drake.types import Array

SIDE_M = 0.30
NODES = 101  # a side of the plane
TOUCHES = 30
SHOWN = (8, 18, 30)
SETTINGS = IgefSettings(sigma1_m=0.02, mu3_m=0.03, sigma3_m=0.005)  # of figure 3.18
SIGMAS = (0.5, 1.0, 2.0)  # of Ψ4
S = np.linspace(-4.0, 4.0, 401)
_UP = np.array([0.0, 0.0, 1.0])
_CM = 100.0


def run(options: Options) -> Report:
    """Rate and explore; writes figure-3.17.png to figure-3.19.png."""
    p = explore_plane()
    figure = Figure(figsize=(7.0, 7.0), layout="constrained")
    draw_profiles(*figure.subplots(2, 1, sharex=True))
    figure.suptitle("Figure 3.17: rating of candidates s around a contact at 0")
    save_figure(options.out / "figure-3.17.png", figure)
    figure = Figure(figsize=(14.0, 5.0), layout="constrained")
    draw_spiral(figure, p)
    save_figure(options.out / "figure-3.18.png", figure)
    figure = Figure(figsize=(7.0, 5.0), layout="constrained")
    draw_rotation(figure.subplots())
    save_figure(options.out / "figure-3.19.png", figure)
    rows = [row(p, i) for i in range(len(p))]
    settings = {
        "side_m": SIDE_M,
        "touches": TOUCHES,
        "sigma1_m": SETTINGS.sigma1_m,
        "mu3_m": SETTINGS.mu3_m,
        "sigma3_m": SETTINGS.sigma3_m,
        "sigma_alpha": list(SIGMAS),
    }
    return Report("figure-3.17", settings, summary(p), {}, rows)


def profiles(s: Array) -> tuple[Array, Array]:
    """Ψ1 and Ψ2 (k,) of candidates at distances s (k,) from the only contact."""
    p, contact = np.column_stack([s, 0 * s, 0 * s]), np.zeros((1, 3))
    return uncertainty(p, contact, sigma1_m=1.0), locality(p, contact, mu3_m=1.0, sigma3_m=1.0)


def plane() -> Array:
    """All places (NODES², 3) of the plane [m]."""
    side = np.linspace(-SIDE_M / 2, SIDE_M / 2, NODES)
    x, y = np.meshgrid(side, side, indexing="ij")
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(NODES**2)])


def rate(p_contacts: Array) -> Array:
    """Ψ1 Ψ2 Ψ3 (NODES²,) of the plane's places after contacts (k, 3)."""
    places, settings = plane(), SETTINGS
    normals = np.tile(_UP, (len(places), 1))
    lengths = arc_length(approach_curves(p_contacts[-1], _UP, places, normals))
    near = locality(places, p_contacts, mu3_m=settings.mu3_m, sigma3_m=settings.sigma3_m)
    new = uncertainty(places, p_contacts, sigma1_m=settings.sigma1_m)
    rating: Array = new * near * travel(lengths)
    return rating


def explore_plane() -> Array:
    """Contacts (TOUCHES, 3) from the centre on [m]."""
    p = np.zeros((1, 3))
    while len(p) < TOUCHES:
        p = np.vstack([p, plane()[np.argmax(rate(p))]])
    return p


def turns(p: Array) -> Array:
    """Angle (k - 1,) of contacts about the first one, without jumps [rad]."""
    angles: Array = np.unwrap(np.arctan2(p[1:, 1] - p[0, 1], p[1:, 0] - p[0, 0]))
    return angles


def row(p: Array, i: int) -> Row:
    """A touch of the spiral."""
    return {
        "touch": i,
        "x_mm": 1e3 * float(p[i, 0]),
        "y_mm": 1e3 * float(p[i, 1]),
        "from_centre_mm": 1e3 * float(np.linalg.norm(p[i])),
        "step_mm": 1e3 * float(np.linalg.norm(p[i] - p[i - 1])) if i else 0.0,
    }


def summary(p: Array) -> dict[str, float]:
    """How the touches go outwards, step by step."""
    radius = np.linalg.norm(p, axis=1)
    thirds = [float(1e3 * part.mean()) for part in np.array_split(radius, 3)]
    steps = np.linalg.norm(np.diff(p, axis=0), axis=1)
    return {
        "radius_first_third_mm": thirds[0],
        "radius_second_third_mm": thirds[1],
        "radius_last_third_mm": thirds[2],
        "median_step_mm": 1e3 * float(np.median(steps)),
        "full_turns": float(np.abs(turns(p)[-1] - turns(p)[0]) / (2 * np.pi)),
    }


def draw_profiles(top: Axes, bottom: Axes) -> None:
    """Figure 3.17."""
    psi1, psi2 = profiles(S)
    top.plot(S, psi1, label="Ψ1, new information")
    top.plot(S, psi2, label="Ψ2, locality")
    bottom.plot(S, psi1 * psi2, color="tab:green", label="Ψ1 Ψ2")
    for axes in (top, bottom):
        axes.axvline(0.0, color="0.7", lw=1.0)
        axes.plot(0.0, 0.0, "s", color="tab:blue", label="contact")
        axes.set(ylabel="rating", ylim=(-0.05, 1.1))
        axes.legend(loc="upper right")
    bottom.set_xlabel("candidate s, in units of μ3 = σ1 = σ3")


def draw_spiral(figure: Figure, p: Array) -> None:
    """Figure 3.18."""
    line = figure.subplots(1, len(SHOWN), sharey=True)
    half = _CM * SIDE_M / 2
    for axes, count in zip(line, SHOWN, strict=True):
        rating = rate(p[:count]).reshape(NODES, NODES).T
        image = axes.imshow(
            rating / rating.max(), origin="lower", extent=(-half, half, -half, half), cmap="RdYlGn"
        )
        axes.plot(_CM * p[:count, 0], _CM * p[:count, 1], "s-", color="tab:blue", ms=4, lw=1.0)
        axes.plot(_CM * p[0, 0], _CM * p[0, 1], "ko", ms=6)
        axes.set(xlabel="x [cm]", title=f"{count} touches")
    line[0].set_ylabel("y [cm]")
    figure.colorbar(image, ax=line, label="Ψ1 Ψ2 Ψ3, of its largest value")
    figure.suptitle("Figure 3.18: a plane explored outwards; black: the first touch")


def draw_rotation(axes: Axes) -> None:
    """Figure 3.19."""
    angles = np.linspace(-np.pi, np.pi, 361)
    normals = np.column_stack([np.sin(angles), 0 * angles, np.cos(angles)])
    for sigma in SIGMAS:
        axes.plot(
            np.degrees(angles), rotation(-_UP, normals, sigma_alpha=sigma), label=f"σα = {sigma:g}"
        )
    axes.set(xlabel="angle α that the fingertip must turn [°]", ylabel="Ψ4", ylim=(0, 1.05))
    axes.set_title("Figure 3.19: the angular kernel, 1 where nothing turns")
    axes.set_xticks(np.arange(-180, 181, 60))
    axes.legend()
