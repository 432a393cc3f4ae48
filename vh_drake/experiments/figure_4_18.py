"""`reproduce figure-4.18`: how the real finger closes, with friction, glove and weight.

The figure's curves are not in the text, which says: the proximal joint begins to close at once,
and the other two move little up to about 40 % of the tendon. What the proximal joint takes must
then be all of the tendon (eq. 4.16) until it is closed, at a third. That is the reference up to
40 %, and that all joints are closed at the end. In between the text says nothing; there the
reference shares the rest evenly, which the model predicts, and is reported by itself.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.figure_4_16 import COLORS, JOINTS
from vh_drake.experiments.figure_files import save_figure
from vh_drake.hand.finger_effects import FingerEffects, closing
from vh_drake.hand.tendon_finger import SEGMENT_LENGTHS_M, TendonFinger, thesis_finger
from vh_drake.reports import Report, Row
from vh_drake.types import Array

POINTS = 91
LITTLE_UNTIL = 0.4


def gloved_finger() -> FingerEffects:
    """A setting of the effects that closes as the text of figure 4.18 has it.

    Friction is within what is usual for tendons in plastic; the masses are those of the hand's
    segments; the palm faces down. The glove's torques are chosen: about those of the springs at
    their pretension in medial and distal joint, little where the glove is wide.
    """
    return FingerEffects(
        tendon_friction=0.1,
        wrap_rad=0.3,
        joint_friction_nm=np.full(3, 4e-3),
        glove_nm=np.array([4e-3, 36e-3, 26e-3]),
        glove_angle_rad=float(np.deg2rad(8.0)),
        mass_kg=np.array([0.0143, 0.0143, 0.0140]),
        segment_m=SEGMENT_LENGTHS_M,
        down_rad=np.pi / 2,
    )


def run(options: Options) -> Report:
    """The finger with and without the effects; writes figure-4.18.png."""
    finger, effects = thesis_finger(), gloved_finger()
    shares = np.linspace(0.0, 1.0, POINTS)
    real = closing(finger, effects, shares * finger.closed_m)
    ideal = finger.equilibrium(shares * finger.closed_m)
    expected = described(finger, shares)
    rows = [
        {
            "share": round(float(shares[k]), 6),
            "tension_n": round(float(real.tension_n[k]), 4),
            **_angles("", real.angles[k]),
            **_angles("ideal_", ideal.angles[k]),
            **_angles("described_", expected[k]),
        }
        for k in range(POINTS)
    ]
    figure = Figure(figsize=(8.0, 5.2), layout="constrained")
    draw(figure.subplots(), rows)
    save_figure(options.out / "figure-4.18.png", figure)
    settings = {
        "tendon_friction": effects.tendon_friction,
        "glove_nmm": (1e3 * effects.glove_nm).tolist(),
        "joint_friction_nmm": (1e3 * effects.joint_friction_nm).tolist(),
        "palm": "down",
    }
    summary = _summary(shares, np.rad2deg(np.abs(real.angles - expected)), real.angles)
    return Report("figure-4.18", settings, summary, {}, rows)


def described(finger: TendonFinger, shares: Array) -> Array:
    """Angles (k, 3) [rad] as the text has them, at shares (k,) of the tendon."""
    turned = shares * finger.upper.sum()  # All joints have the same length of tendon.
    proximal = np.minimum(turned, finger.upper[0])
    rest = (turned - proximal) / 2
    return np.column_stack([proximal, rest, rest])


def draw(axes: Axes, rows: list[Row]) -> None:
    """Angles over the tendon, beside the model without effects and the text."""
    x = [100 * row["share"] for row in rows]
    for joint, color in zip(JOINTS, COLORS, strict=True):
        for prefix, style, name in (
            ("", "-", "with friction, glove, weight"),
            ("ideal_", ":", "springs alone"),
        ):
            y = [row[f"{prefix}{joint}_deg"] for row in rows]
            axes.plot(x, y, style, color=color, label=f"{joint}, {name}")
    for joint in JOINTS[:2]:
        y = [row[f"described_{joint}_deg"] for row in rows]
        label = "what the text describes" if joint == JOINTS[0] else None
        axes.plot(x, y, "--", color="grey", lw=1, label=label)
    axes.axvspan(0, 100 * LITTLE_UNTIL, color="grey", alpha=0.12, lw=0)
    axes.text(1, 93, "medial and distal joint move little", fontsize="small")
    axes.set(xlabel="shortening of the tendon [% of 45 mm]", ylabel="joint angle [degrees]")
    axes.set(xlim=(0, 100), ylim=(0, 98), title="One finger closes, palm down, in its glove")
    axes.legend(fontsize="small", loc="lower right")
    axes.grid(alpha=0.3)


def _angles(prefix: str, angles: Array) -> Row:
    degrees = np.rad2deg(angles)
    return {f"{prefix}{j}_deg": round(float(v), 4) for j, v in zip(JOINTS, degrees, strict=True)}


def _summary(shares: Array, deviation_deg: Array, angles: Array) -> Row:
    early = shares <= LITTLE_UNTIL
    told = early | (shares == 1.0)
    return {
        "largest_deviation_deg": round(float(deviation_deg[told].max()), 2),
        "largest_deviation_everywhere_deg": round(float(deviation_deg.max()), 2),
        "others_until_40_percent_deg": round(float(np.rad2deg(angles[early, 1:].max())), 2),
    }
