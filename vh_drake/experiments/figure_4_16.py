"""`reproduce figure-4.16`: joint angles over the shortening of the tendon."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.figure_files import save_figure
from vh_drake.hand.tendon_finger import LEVERS, Lever, thesis_finger
from vh_drake.reports import Report, Row

JOINTS = ("proximal", "medial", "distal")
COLORS = ("tab:blue", "tab:orange", "tab:green")
POINTS = 91


def run(options: Options) -> Report:
    """The model of table 4.4 with both laws of the lever; writes figure-4.16.png."""
    rows = [row for lever in LEVERS for row in closing_rows(lever)]
    figure = Figure(figsize=(11.0, 4.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_angles(left, rows)
    draw_tension(right, rows)
    figure.suptitle("One finger of ARMAR-6 in free space, springs and lever of table 4.4")
    save_figure(options.out / "figure-4.16.png", figure)
    printed = [row for row in rows if row["lever"] == "growing"]
    return Report("figure-4.16", {"points": POINTS}, _summary(printed), {}, rows)


def closing_rows(lever: Lever) -> list[Row]:
    """Angles, tension and torques from open to closed."""
    finger = thesis_finger(lever)
    shortening = np.linspace(0.0, finger.closed_m, POINTS)
    state = finger.equilibrium(shortening)
    torques = finger.torques(state)
    return [
        {
            "lever": lever,
            "shortening_mm": round(1e3 * shortening[k], 4),
            **_named("deg", np.rad2deg(state.angles[k])),
            "tension_n": round(float(state.tension_n[k]), 6),
            **_named("nmm", 1e3 * torques[k]),
        }
        for k in range(POINTS)
    ]


def draw_angles(axes: Axes, rows: list[Row]) -> None:
    """Joint angles over the shortening."""
    for lever, style in zip(LEVERS, ("-", ":"), strict=True):
        own = [row for row in rows if row["lever"] == lever]
        x = [row["shortening_mm"] for row in own]
        for joint, color in zip(JOINTS, COLORS, strict=True):
            label = f"{joint}, {lever} lever"
            axes.plot(x, [row[f"{joint}_deg"] for row in own], style, color=color, label=label)
    axes.set(xlabel="shortening of the tendon [mm]", ylabel="joint angle [degrees]")
    axes.set(xlim=(0, 45), ylim=(0, 95), title="Joint angles")
    axes.legend(fontsize="small")
    axes.grid(alpha=0.3)


def draw_tension(axes: Axes, rows: list[Row]) -> None:
    """The force in the tendon over the shortening."""
    for lever, style in zip(LEVERS, ("-", ":"), strict=True):
        own = [row for row in rows if row["lever"] == lever and row["tension_n"] > 0]
        x = [row["shortening_mm"] for row in own]
        label = f"{lever} lever"
        axes.plot(x, [row["tension_n"] for row in own], style, color="black", label=label)
    axes.set(xlabel="shortening of the tendon [mm]", ylabel="tension [N]")
    axes.set(xlim=(0, 45), ylim=(0, None), title="Force in the tendon")
    axes.legend()
    axes.grid(alpha=0.3)


def _named(unit: str, values: np.ndarray) -> Row:
    return {f"{j}_{unit}": round(float(v), 6) for j, v in zip(JOINTS, values, strict=True)}


def _summary(rows: list[Row]) -> Row:
    """Angles at half the shortening, and by how much the joints differ at most."""
    half = rows[POINTS // 2]
    spread = max(row["proximal_deg"] - row["distal_deg"] for row in rows)
    return {
        **{f"{joint}_at_half_deg": round(half[f"{joint}_deg"], 2) for joint in JOINTS},
        "largest_difference_deg": round(spread, 2),
        "largest_tension_n": round(max(row["tension_n"] for row in rows), 3),
    }
