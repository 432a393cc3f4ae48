"""What a teacher does with a hand: jogs it, sets and deletes key points, plays them.

The tool of section 4.5.4 by itself: a value that each action replaces. Whoever shows it, and
moves a hand accordingly, calls `advanced` with the time that has passed.
"""

import dataclasses as dc

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.hand.key_points import (
    FARTHEST_M,
    MOST_KEY_POINTS,
    KeyPoint,
    KeyPointTrajectory,
    check_key_points,
    key_point_at,
)
from vh_drake.types import Immutable

# What can be jogged, in the order of `KeyPoint.values`, with the least and largest value.
JOGS = {
    "fingers": (0.0, 1.0),
    "thumb": (0.0, 1.0),
    "x": (-FARTHEST_M, FARTHEST_M),
    "y": (-FARTHEST_M, FARTHEST_M),
    "z": (-FARTHEST_M, FARTHEST_M),
    "roll": (-180.0, 180.0),
    "pitch": (-85.0, 85.0),
    "yaw": (-180.0, 180.0),
}
LOWERING_M_S = 0.02


@dc.dataclass(frozen=True)
class Teaching(Immutable):
    """A trajectory in the making.

    Times of key points count from the first one, which is at 0 s.

    Attributes:
        points: set so far.
        selected: index of the key point that was set or gone to last; -1 for none.
        target: where the hand shall be now; its time means nothing.
        playing_s: time on the trajectory while it plays, below 0 on the way to its start.
        lowering: whether the hand sinks until it touches something.
    """

    points: tuple[KeyPoint, ...] = ()
    selected: int = -1
    target: KeyPoint = dc.field(default_factory=KeyPoint)
    playing_s: float | None = None
    lowering: bool = False

    def jogged(self, name: str, step: float) -> "Teaching":
        """Moves one of `JOGS` by a step [m, degrees or share]; ends what else moves the hand."""
        return self._with(name, step, add=True)

    def moved(self, name: str, value: float) -> "Teaching":
        """Moves one of `JOGS` to a value; ends what else moves the hand."""
        return self._with(name, value, add=False)

    def _with(self, name: str, amount: float, *, add: bool) -> "Teaching":
        index, (low, high) = list(JOGS).index(name), JOGS[name]
        values = self.target.values()
        values[index] = np.clip(add * values[index] + amount, low, high)
        return dc.replace(self._stopped(), target=KeyPoint.from_values(0.0, values))

    def key_point_set(self, spacing_s: float) -> "Teaching":
        """The target becomes a key point behind the selected one; later ones make room.

        Raises:
            BadInput: there are as many key points as there may be.
        """
        if len(self.points) >= MOST_KEY_POINTS:
            raise BadInput(f"a trajectory has at most {MOST_KEY_POINTS} key points; delete some")
        before, after = self.points[: self.selected + 1], self.points[self.selected + 1 :]
        gap = spacing_s if self.points else 0.0
        time_s = before[-1].time_s + gap if before else 0.0
        new = KeyPoint.from_values(time_s, self.target.values())
        points = (*before, new, *_later(after, gap))
        return dc.replace(self._stopped(), points=points, selected=self.selected + 1)

    def key_point_deleted(self) -> "Teaching":
        """Without the selected key point, in whose time the later ones move up."""
        if self.selected < 0:
            return self
        before, after = self.points[: self.selected], self.points[self.selected + 1 :]
        start_s = self.points[self.selected].time_s
        after = _later(after, start_s - after[0].time_s) if after else ()
        points = (*before, *after)
        selected = max(self.selected - 1, 0) if points else -1
        return dc.replace(self._stopped(), points=points, selected=selected)

    def gone(self, by: int) -> "Teaching":
        """To the key point that many places on from the selected one, at most to an end."""
        if not self.points:
            return self
        selected = min(max(self.selected + by, 0), len(self.points) - 1)
        return dc.replace(self._stopped(), selected=selected, target=self.points[selected])

    def rooted(self) -> "Teaching":
        """With the target's pose as the start from which poses count; fingers stay."""
        fingers, thumb = self.target.fingers, self.target.thumb
        return dc.replace(self._stopped(), target=KeyPoint(fingers=fingers, thumb=thumb))

    def played(self, lead_s: float) -> "Teaching":
        """Goes to the first key point in `lead_s`, then through all of them."""
        if not self.points:
            return self
        return dc.replace(self._stopped(), playing_s=-lead_s, target=self.points[0])

    def lowered(self) -> "Teaching":
        """Sinks from now on, until `touched` or the next action."""
        return dc.replace(self._stopped(), lowering=True)

    def touched(self) -> "Teaching":
        """Ends a lowering."""
        return dc.replace(self, lowering=False)

    def loaded(self, trajectory: KeyPointTrajectory) -> "Teaching":
        """Another trajectory; the hand stays where it is."""
        return dc.replace(self._stopped(), points=tuple(trajectory.key_points), selected=0)

    def trajectory(self, name: str) -> KeyPointTrajectory:
        """What can be saved and executed.

        Raises:
            BadInput: there are no key points.
        """
        trajectory = KeyPointTrajectory(name, list(self.points))
        check_key_points(trajectory)
        return trajectory

    def advanced(self, step_s: float) -> "Teaching":
        """After some time."""
        if self.lowering:
            sunk = self.jogged("z", -LOWERING_M_S * step_s)
            return dc.replace(sunk, lowering=True)
        if self.playing_s is None:
            return self
        playing_s = self.playing_s + step_s
        last = self.points[-1]
        if playing_s >= last.time_s:
            selected = len(self.points) - 1
            return dc.replace(self, playing_s=None, target=last, selected=selected)
        target = key_point_at(self.points, playing_s)
        return dc.replace(self, playing_s=playing_s, target=target)

    def _stopped(self) -> "Teaching":
        return dc.replace(self, playing_s=None, lowering=False)


def _later(points: tuple[KeyPoint, ...], by_s: float) -> tuple[KeyPoint, ...]:
    return tuple(KeyPoint.from_values(point.time_s + by_s, point.values()) for point in points)
