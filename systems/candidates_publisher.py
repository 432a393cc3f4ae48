"""Grasp candidates and the chosen one in Meshcat."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.geometry import Meshcat
from pydrake.systems.framework import Context

from vh_drake.geometry.colors import score_colors
from vh_drake.geometry.glyphs import ColorMesh, arrows, balls, joined, tube
from vh_drake.grasping.phases import hand_is_open
from vh_drake.grasping.story import GraspRecord, Story
from vh_drake.hand.model import HandModel
from vh_drake.systems.meshcat_publisher import PERIOD_S, MeshcatPublisher, Picture
from vh_drake.types import Array, Candidates, GraspScores, IntArray

MOST = 60  # candidates, spread over the scores, that a picture bears
ARROW_M, SHAFT_M, BALL_M = 0.06, 0.0016, 0.004
WITH_BALL = ("skeleton",)  # planners whose arrows start in a ball
CHOSEN_COLOR, BONE_M = (0.1, 0.3, 1.0), 0.004


class CandidatesPublisher(MeshcatPublisher):
    """Shows candidates as arrows, red to green by score, and the chosen hand in blue.

    Each planner has a path of its own, `/candidates/0/surface`, `/candidates/0/skeleton`, so that
    Meshcat's controls can show one alone. Arrows of the skeleton planner start in a ball.

    .. pydrake_system::

        name: CandidatesPublisher
        input_ports:
        - candidates
        - scores
        - story
        - phase

    | port       | direction | type        | unit | meaning              |
    |------------|-----------|-------------|------|----------------------|
    | candidates | in        | Candidates  | m    | grasps               |
    | scores     | in        | GraspScores | -    | their ratings        |
    | story      | in        | Story       | -    | names the chosen one |
    | phase      | in        | str         | -    | of the behaviour     |

    An arrow ends in the hand's power TCP and points where the hand approaches. All disappear
    when the hand closes.

    Args:
        hand: whose candidates they are.
        meshcat: where it draws.
        path: under which it draws.
        period_s: between two looks.
    """

    def __init__(
        self,
        hand: HandModel,
        meshcat: Meshcat,
        path: str = "/candidates",
        *,
        period_s: float = PERIOD_S,
    ) -> None:
        super().__init__(meshcat, path, period_s)
        self._hand = hand
        self._inputs = {
            name: self.DeclareAbstractInputPort(name, AbstractValue.Make(value))
            for name, value in (
                ("candidates", Candidates()),
                ("scores", GraspScores()),
                ("story", Story()),
                ("phase", ""),
            )
        }

    def picture(self, context: Context) -> Picture:
        """Rated candidates and what was chosen of them."""
        candidates, scores, story, phase = (port.Eval(context) for port in self._inputs.values())
        rated = len(candidates) == len(scores.score) > 0
        if not (rated and hand_is_open(phase)):
            return ()
        chosen = story.grasps[-1] if story.grasps and phase.startswith("grasp") else None
        return candidates, scores, chosen

    def draw(self, path: str, *picture: object) -> None:
        """Puts each planner's arrows and the chosen hand under a path."""
        candidates, scores, chosen = picture
        assert isinstance(candidates, Candidates)
        assert isinstance(scores, GraspScores)
        shown = self._shown_ones(scores.score)
        planners = np.array(candidates.planner)[shown]
        for name in sorted(set(planners)):
            own = shown[planners == name]
            mesh = self._arrows(candidates.X_WH[own], scores.score[own], name in WITH_BALL)
            self.draw_mesh(f"{path}/{name}", mesh)
        if isinstance(chosen, GraspRecord):
            self.draw_mesh(f"{path}/chosen", self._skeleton(chosen.X_WH))

    @staticmethod
    def _shown_ones(score: Array) -> IntArray:
        """Indices of as many as a picture bears, spread over the scores."""
        ranked = np.argsort(-score, kind="stable")
        return ranked[np.unique(np.linspace(0, len(ranked) - 1, MOST).round().astype(int))]

    def _arrows(self, X_WH: Array, score: Array, with_ball: bool) -> ColorMesh:
        description = self._hand.description
        approach = np.asarray(description.approach, float)
        direction = X_WH[:, :3, :3] @ (approach / np.linalg.norm(approach))
        tcp = X_WH[:, :3, :3] @ np.asarray(description.tcps["power"]) + X_WH[:, :3, 3]
        colors, start = score_colors(score), tcp - ARROW_M * direction
        shafts = arrows(start, direction, colors, length=ARROW_M, radius=SHAFT_M)
        return joined([shafts, balls(start, colors, radius=BALL_M)]) if with_ball else shafts

    def _skeleton(self, X_WH: Array) -> ColorMesh:
        """Bones of the open hand, from the wrist to the tips of the fingers."""
        hand = self._hand
        joints = hand.link_poses(hand.lower)[:, :3, 3]
        tips = hand.tips(hand.lower)
        bones = []
        for finger, tip in enumerate(tips):
            own = joints[hand.finger_of_link == finger]
            p_H = np.vstack([joints[:1], own, tip])
            p_W = p_H @ X_WH[:3, :3].T + X_WH[:3, 3]
            bones.append(tube(p_W, np.array(CHOSEN_COLOR), radius=BONE_M))
        return joined(bones)
