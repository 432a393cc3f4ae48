"""Exploration of a mesh by a fingertip without dynamics (Algorithm 2), and its judge."""

import dataclasses as dc
from collections.abc import Iterator

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.exploration.choosing import Choice, choose_touch
from vh_drake.exploration.coverage import Coverage, unexplored
from vh_drake.exploration.explorer import (
    Arrival,
    ExplorerSettings,
    Known,
    after_first,
    after_touch,
)
from vh_drake.exploration.kinematic_tip import TipMotion, move_along
from vh_drake.exploration.trajectory import recovery_curve
from vh_drake.geometry.closest_points import TriangleTree, triangle_tree
from vh_drake.geometry.meshes import TriMesh
from vh_drake.types import Array, Immutable

_START_M = 0.05  # from the object's circumscribed sphere
_MOST_STARTS = 1000


@dc.dataclass(frozen=True)
class EndSettings:
    """When a judge ends an exploration (section 3.6.1)."""

    goal: float = 0.8  # explored share of the surface
    most_without_gain: int = 10  # touches in a row
    most_touches: int = 600


@dc.dataclass(frozen=True, eq=False)
class Body(Immutable):
    """An object as the fingertip and the judge know it."""

    tree: TriangleTree
    coverage: Coverage  # of nothing yet
    center: Array  # (3,) first target: the centre of mass [m]
    radius_m: float  # of the sphere about it that holds the object


@dc.dataclass(frozen=True, eq=False)
class Touch(Immutable):
    """A touch as it went."""

    p_WT: Array  # (3,) predicted contact [m]
    p_WC: Array  # (3,) contact [m]
    n_WC: Array  # (3,) outward unit normal there
    curves: Array  # (k, 4, 3) control points of what was followed, the last in part [m]
    tau: float  # where the last curve ended
    length_m: float
    turn_rad: float  # of the fingertip
    missed: bool  # passed its target and came back from below


@dc.dataclass(frozen=True, eq=False)
class Step(Immutable):
    """One turn of the loop."""

    choice: Choice
    touch: Touch
    known: Known  # afterwards
    coverage: Coverage  # afterwards


@dc.dataclass(frozen=True, eq=False)
class Exploration(Immutable):
    """A whole exploration."""

    start: Known  # after the first contact
    coverage: Coverage  # after it
    steps: tuple[Step, ...]
    end: str  # "goal", "stuck", "touches" or "lost"

    @property
    def known(self) -> Known:
        """What is known in the end."""
        return self.steps[-1].known if self.steps else self.start

    @property
    def shares(self) -> Array:
        """(k + 1,) explored share after the first contact and each touch."""
        return np.array([self.coverage.share, *(step.coverage.share for step in self.steps)])

    @property
    def lengths_m(self) -> Array:
        """(k + 1,) way covered since the first contact [m]."""
        return np.concatenate([[0.0], np.cumsum([step.touch.length_m for step in self.steps])])


def make_body(mesh: TriMesh, center: Array, *, explored_radius_m: float = 0.02) -> Body:
    """Prepare a mesh.

    Args:
        mesh: watertight [m].
        center: (3,) its centre of mass.
        explored_radius_m: r_E of the judge.
    """
    radius = float(np.linalg.norm(mesh.vertices - center, axis=1).max())
    return Body(triangle_tree(mesh), unexplored(mesh, radius_m=explored_radius_m), center, radius)


def explore(
    body: Body,
    settings: ExplorerSettings | None = None,
    end: EndSettings | None = None,
    *,
    seed: int = 0,
) -> Exploration:
    """Explore a body until enough of it is explored, or nothing is gained any more.

    Args:
        body: the object.
        settings: of the explorer.
        end: when it ends.
        seed: of the first approach and of choices by chance.

    Raises:
        UnknownName: a setting that is no choice.
        BadInput: no straight way to the centre meets the object.
    """
    settings, end = settings or ExplorerSettings(), end or EndSettings()
    start, coverage = begin(body, settings, seed=seed)
    return judged(start, coverage, touches(body, start, coverage, settings, seed=seed), end)


def judged(
    start: Known, coverage: Coverage, going: Iterator[Step], end: EndSettings
) -> Exploration:
    """An exploration from its first contact on, until a judge ends it.

    Args:
        start: what is known after the first contact.
        coverage: after it.
        going: the steps that would be made.
        end: when it ends.
    """
    steps: list[Step] = []
    share, without_gain, reason = coverage.share, 0, ""
    while not (reason := _reason(share, without_gain, len(steps), end)):
        step = next(going, None)
        if step is None:
            reason = "lost"
            break
        steps.append(step)
        gained = step.coverage.share > share
        share, without_gain = step.coverage.share, 0 if gained else without_gain + 1
    return Exploration(start, coverage, tuple(steps), reason)


def begin(body: Body, settings: ExplorerSettings, *, seed: int) -> tuple[Known, Coverage]:
    """The first contact, on a straight way towards the centre from a random direction.

    Raises:
        BadInput: no way met the object, which is then hollow around its centre on all sides.
    """
    rng = np.random.default_rng(seed)
    for _ in range(_MOST_STARTS):
        u = rng.normal(size=3)
        u /= np.linalg.norm(u)
        ends = body.center + np.array([body.radius_m + _START_M, -body.radius_m])[:, None] * u
        line = ends[0] + np.linspace(0.0, 1.0, 4)[:, None] * (ends[1] - ends[0])
        motion = move_along(body.tree, line, radius_m=settings.tip_radius_m)
        if motion.touched:
            arrival = Arrival(motion.p_WTip, -u, -u, motion.p_WC, motion.n_WC)
            return after_first(arrival, settings), body.coverage.with_contact(motion.p_WC)
    raise BadInput("no straight way to the centre meets the object; is the mesh in metres?")


def touches(
    body: Body, known: Known, coverage: Coverage, settings: ExplorerSettings, *, seed: int
) -> Iterator[Step]:
    """Touch after touch, for as long as there is a place to touch."""
    while (choice := choose_touch(known, settings, seed=seed)) is not None:
        step = step_to(body, choice, known, coverage, settings)
        if step is None:
            return
        known, coverage = step.known, step.coverage
        yield step


def step_to(
    body: Body, choice: Choice, known: Known, coverage: Coverage, settings: ExplorerSettings
) -> Step | None:
    """Make a touch that was chosen; None where the way met nothing at all."""
    target, normal = choice.p[choice.chosen], choice.n[choice.chosen]
    motions, curves = _way(body.tree, choice.curves, known, settings)
    last = motions[-1]
    if not last.touched:
        return None
    approach, turn = _turned(known, normal, motions, len(choice.curves))
    length = sum(motion.length_m for motion in motions)
    missed = len(motions) > len(choice.curves)
    touch = Touch(target, last.p_WC, last.n_WC, curves, last.tau, length, turn, missed)
    arrival = Arrival(last.p_WTip, last.direction_W, approach, last.p_WC, last.n_WC)
    after = after_touch(known, target, arrival, settings)
    return Step(choice, touch, after, coverage.with_contact(last.p_WC))


def _reason(share: float, without_gain: int, count: int, end: EndSettings) -> str:
    """Why an exploration ends; empty while it goes on."""
    if share >= end.goal:
        return "goal"
    if without_gain >= end.most_without_gain:
        return "stuck"
    return "touches" if count >= end.most_touches else ""


def _way(
    tree: TriangleTree, planned: Array, known: Known, settings: ExplorerSettings
) -> tuple[list[TipMotion], Array]:
    """Follow curves until a contact; behind the last one back from below (eq. 3.86)."""
    motions: list[TipMotion] = []
    for i, curve in enumerate(planned):
        beyond = settings.missed_after_m if i == len(planned) - 1 else 0.0
        motions.append(move_along(tree, curve, radius_m=settings.tip_radius_m, beyond_m=beyond))
        if motions[-1].touched:
            return motions, planned[: i + 1]
    last, contacts = motions[-1], known.contacts
    back = recovery_curve(last.p_WTip, last.direction_W, contacts.p_WC[-1], contacts.n_WC[-1])
    motions.append(move_along(tree, back, radius_m=settings.tip_radius_m))
    return motions, np.concatenate([planned, back[None]])


def _turned(
    known: Known, n_WT: Array, motions: list[TipMotion], planned: int
) -> tuple[Array, float]:
    """Approach axis after the motions and how far it turned, by spherical interpolation."""
    followed = min(len(motions), planned)
    share = (followed - 1 + min(motions[followed - 1].tau, 1.0)) / planned
    approach, turn = slerp(known.approach_W, -n_WT, share)
    if len(motions) > planned:  # Back from below: against the old contact's normal turned round.
        approach, more = slerp(approach, known.contacts.n_WC[-1], min(motions[-1].tau, 1.0))
        turn += more
    return approach, turn


def slerp(a: Array, b: Array, share: float) -> tuple[Array, float]:
    """The unit vector a share of the way from a to b (3,) on a great circle, and its angle."""
    side = b - (b @ a) * a
    angle = float(np.arctan2(np.linalg.norm(side), b @ a))
    if np.linalg.norm(side) < 1e-9:  # Half a turn, or none, has no preferred plane.
        side = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
    turned = share * angle
    unit = side / np.linalg.norm(side)
    return np.cos(turned) * a + np.sin(turned) * unit, turned
