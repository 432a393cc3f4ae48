"""Look, touch, fuse, plan, rate, grasp, lift: who does what next."""

import dataclasses as dc
from collections import Counter

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, EventStatus, InputPort, State

from vh_drake.control.arm_collisions import ArmCollisions
from vh_drake.control.kinematics import ArmKinematics
from vh_drake.exploration.felt_shift import felt_shift
from vh_drake.exploration.planar_registration import registered
from vh_drake.exploration.touch_motion import TouchMotion, TouchMotionSettings, find_touch
from vh_drake.grasping.approach import GraspMotionSettings, find_grasp, release_legs
from vh_drake.grasping.experience import discounts
from vh_drake.grasping.story import GraspRecord, Story, TouchRecord
from vh_drake.hand.clearance import obstacles
from vh_drake.hand.model import HandModel
from vh_drake.hand.program import Leg, MotionProgram, Progress
from vh_drake.sensing.camera_correction import moved
from vh_drake.systems.collectable import CollectableSystem
from vh_drake.systems.grasp_scorer import ranking
from vh_drake.types import (
    Array,
    Candidates,
    ContactSet,
    GraspScores,
    Immutable,
    ObjectView,
    Surface,
)

PERIOD_S = 0.02


@dc.dataclass(frozen=True)
class BehaviourSettings:
    """How much is tried."""

    touches: int = 1
    missed_touches: int = 3  # that are borne before the plan goes on without
    feel_s: float = 0.12  # for which the finger rests where it touched
    attempts: int = 1  # grasps
    look_after_s: float = 0.1  # the arm has come to rest
    least_weight_n: float = 0.12  # that the wrist feels while something is held
    least_gap: float = 0.1  # share of travel by which what is held stops motors early
    lost_after: int = 10  # updates in a row without either
    same_place_m: float = 0.005  # largest misfit of a new look that keeps what was felt
    touch: TouchMotionSettings = dc.field(default_factory=TouchMotionSettings)
    grasp: GraspMotionSettings = dc.field(default_factory=GraspMotionSettings)


@dc.dataclass(frozen=True, eq=False)
class _Mind(Immutable):
    """All that the behaviour remembers; replaced, never mutated."""

    story: Story = dc.field(default_factory=Story)
    view: ObjectView = dc.field(default_factory=ObjectView)
    contacts: ContactSet = dc.field(default_factory=ContactSet)
    program: MotionProgram = dc.field(default_factory=MotionProgram)
    touch: TouchMotion | None = None
    touched_s: float | None = None  # when the finger came to rest
    touches_before: int = 0  # of the story, before the last look
    shift: Array = dc.field(default_factory=lambda: np.zeros(3))  # of views, as touches tell [m]
    failed: tuple[tuple[Array, str], ...] = ()  # hand poses and motions that did not hold it
    unloaded: int = 0  # updates in a row in which the lifting hand felt nothing
    surface_request: int = 0
    touch_request: int = 0
    grasp_request: int = 0

    def entering(self, phase: str) -> "_Mind":
        """The same mind in another phase."""
        return dc.replace(self, story=dc.replace(self.story, phase=phase))

    def giving_up(self, why: str) -> "_Mind":
        """The end, with a reason."""
        story = dc.replace(self.story, phase="failed", finished=True, failure=why)
        return dc.replace(self, story=story)

    def moving(self, legs: tuple[Leg, ...]) -> "_Mind":
        """With a new program for the executor."""
        return dc.replace(self, program=MotionProgram(self.program.id + 1, legs))


class Behaviour(CollectableSystem):
    """The sequence of section 4.2, S1 to S6, from what the sensors tell.

    .. pydrake_system::

        name: Behaviour
        input_ports:
        - object_view
        - view_status
        - surface
        - surface_served
        - touch_plans
        - touch_served
        - candidates
        - scores
        - ranking
        - grasp_served
        - progress
        - contact_point
        - force
        - joint_state
        - motor_fraction
        output_ports:
        - view
        - contacts
        - surface_request
        - touch_request
        - grasp_request
        - program
        - phase
        - story

    | port            | direction | type          | unit | meaning                               |
    |-----------------|-----------|---------------|------|---------------------------------------|
    | object_view     | in        | ObjectView    | m    | what the camera shows now             |
    | view_status     | in        | str           | -    | "ok", or why nothing is seen          |
    | surface         | in        | Surface       | m    | estimate                              |
    | surface_served  | in        | vector (1)    | -    | id of the request it answers          |
    | touch_plans     | in        | tuple         | m    | TouchPlans, best first                |
    | touch_served    | in        | vector (1)    | -    | id of the request they answer         |
    | candidates      | in        | Candidates    | m    | grasps                                |
    | scores          | in        | GraspScores   | -    | their ratings                         |
    | ranking         | in        | tuple         | -    | their indices, best first             |
    | grasp_served    | in        | vector (1)    | -    | id of the request they answer         |
    | progress        | in        | Progress      | -    | of the executor                       |
    | contact_point   | in        | ContactSet    | m    | felt since the last tare              |
    | force           | in        | vector (3)    | N    | on the hand, in W                     |
    | joint_state     | in        | vector (16)   | rad  | commanded to the arm                  |
    | motor_fraction  | in        | vector (k)    | -    | measured travel of the hand's motors  |
    | view            | out       | ObjectView    | m    | the last look                         |
    | contacts        | out       | ContactSet    | m    | felt so far                           |
    | surface_request | out       | vector (1)    | -    | a new id asks for an estimate         |
    | touch_request   | out       | vector (1)    | -    | a new id asks for touch plans         |
    | grasp_request   | out       | vector (1)    | -    | a new id asks for rated grasps        |
    | program         | out       | MotionProgram | m    | for the executor                      |
    | phase           | out       | str           | -    | for people                            |
    | story           | out       | Story         | -    | what happened so far                  |

    Args:
        hand: the hand.
        kinematics: of the arm.
        settings: how much is tried.
        collisions: of arm and hand with robot and table, which motions must be free of.
    """

    def __init__(
        self,
        hand: HandModel,
        kinematics: ArmKinematics,
        settings: BehaviourSettings | None = None,
        *,
        collisions: ArmCollisions | None = None,
    ) -> None:
        super().__init__()
        self._hand, self._kinematics = hand, kinematics
        self._collisions = collisions
        self._settings = settings or BehaviourSettings()
        self._inputs: dict[str, InputPort] = {}
        for name, model in (
            ("object_view", Value[object](ObjectView())),
            ("view_status", Value[str]("")),
            ("surface", Value[object](Surface())),
            ("touch_plans", Value[object](())),
            ("candidates", Value[object](Candidates())),
            ("scores", Value[object](GraspScores())),
            ("ranking", Value[object](())),
            ("progress", Value[object](Progress())),
            ("contact_point", Value[object](ContactSet())),
        ):
            self._inputs[name] = self.DeclareAbstractInputPort(name, model)
        for name, size in (
            ("surface_served", 1),
            ("touch_served", 1),
            ("grasp_served", 1),
            ("force", 3),
            ("joint_state", 16),
            ("motor_fraction", len(hand.description.motors)),
        ):
            self._inputs[name] = self.DeclareVectorInputPort(name, size)
        self._state = self.DeclareAbstractState(Value[object](_Mind()))
        self.DeclarePeriodicUnrestrictedUpdateEvent(PERIOD_S, 0.0, self._update)
        self._declare_outputs()

    def _declare_outputs(self) -> None:
        state = {self.abstract_state_ticket(self._state)}
        for name, value in (
            ("view", ObjectView()),
            ("contacts", ContactSet()),
            ("program", MotionProgram()),
            ("story", Story()),
        ):
            self.DeclareAbstractOutputPort(
                name,
                lambda value=value: Value[object](value),
                lambda context, output, name=name: output.set_value(
                    getattr(self._mind(context), name)
                ),
                prerequisites_of_calc=state,
            )
        self.DeclareAbstractOutputPort(
            "phase",
            lambda: Value[str](""),
            self._calc_phase,
            prerequisites_of_calc=state | {self._inputs["progress"].ticket()},
        )
        for name in ("surface_request", "touch_request", "grasp_request"):
            self.DeclareVectorOutputPort(
                name,
                1,
                lambda context, output, name=name: self._calc_request(context, output, name),
                prerequisites_of_calc=state,
            )

    def _mind(self, context: Context) -> _Mind:
        mind: _Mind = context.get_abstract_state(0).get_value()
        return mind

    def _eval(self, context: Context, name: str) -> object:
        value: object = self._inputs[name].Eval(context)
        return value

    def _served(self, context: Context, name: str, request: int) -> bool:
        return int(self._inputs[f"{name}_served"].Eval(context)[0]) == request

    def _update(self, context: Context, state: State) -> EventStatus:
        mind = self._mind(context)
        step = {
            "look": self._look,
            "estimate": self._estimate,
            "plan a touch": self._plan_touch,
            "touch": self._touch,
            "retreat": self._retreat,
            "plan grasps": self._plan_grasps,
            "grasp": self._grasp,
            "let go": self._let_go,
        }.get(mind.story.phase)
        if step is None or (after := step(context, mind)) is mind:
            return EventStatus.DidNothing()
        state.get_mutable_abstract_state(0).set_value(after)
        return EventStatus.Succeeded()

    def _look(self, context: Context, mind: _Mind) -> _Mind:
        """S1: a look, kept until the next attempt."""
        if context.get_time() < self._settings.look_after_s:
            return mind
        status = self._inputs["view_status"].Eval(context)
        if status != "ok":
            return mind.giving_up(str(status))
        view = self._inputs["object_view"].Eval(context)
        if mind.shift.any():  # The camera's error stays what it was.
            view = moved(view, mind.shift, mind.view.shift_covariance)
        if mind.story.grasps:
            mind = self._corrected(context, mind, view)
        return self._estimating(dc.replace(mind, view=view))

    def _corrected(self, context: Context, mind: _Mind, view: ObjectView) -> _Mind:
        """What was learnt moves with the object, or is forgotten where that tipped or rolled."""
        scene = obstacles(self._inputs["surface"].Eval(context), view.table)
        motion = registered(scene.distance, view.p_WO, view.table)
        if motion.error_m > self._settings.same_place_m:
            before = len(mind.story.touches)
            return dc.replace(mind, contacts=ContactSet(), failed=(), touches_before=before)
        X = motion.X_NewOld
        contacts = ContactSet(
            mind.contacts.p_WC @ X[:3, :3].T + X[:3, 3], mind.contacts.n_WC @ X[:3, :3].T
        )
        failed = tuple((X @ X_WH, name) for X_WH, name in mind.failed)
        return dc.replace(mind, contacts=contacts, failed=failed)

    def _estimating(self, mind: _Mind) -> _Mind:
        asked = dc.replace(mind, surface_request=mind.surface_request + 1)
        return asked.entering("estimate")

    def _estimate(self, context: Context, mind: _Mind) -> _Mind:
        """S3, then another touch or the grasp."""
        if not self._served(context, "surface", mind.surface_request):
            return mind
        if len(self._inputs["surface"].Eval(context).faces) == 0:
            return mind.giving_up(
                f"no surface could be estimated from {len(mind.view.p_WO)} points of the object"
            )
        touches = mind.story.touches[mind.touches_before :]
        missed = sum(not record.felt for record in touches)
        felt = len(touches) - missed
        if felt < self._settings.touches and missed < self._settings.missed_touches:
            asked = dc.replace(mind, touch_request=mind.touch_request + 1)
            return asked.entering("plan a touch")
        return dc.replace(mind, grasp_request=mind.grasp_request + 1).entering("plan grasps")

    def _plan_touch(self, context: Context, mind: _Mind) -> _Mind:
        """S2: the best touch that the arm can do, away from those that were missed."""
        if not self._served(context, "touch", mind.touch_request):
            return mind
        missed = [record.plan.p_WT for record in mind.story.touches if not record.felt]
        plans = [
            plan
            for plan in self._inputs["touch_plans"].Eval(context)
            if all(np.linalg.norm(plan.p_WT - p) > 0.025 for p in missed)
        ]
        scene = obstacles(self._inputs["surface"].Eval(context), mind.view.table)
        q = self._inputs["joint_state"].Eval(context)[:8]
        touch = find_touch(
            plans,
            scene,
            self._hand,
            self._kinematics,
            q,
            mind.view,
            self._settings.touch,
            collisions=self._collisions,
        )
        if touch is None:  # No hidden place is in reach, so the view must do.
            asked = dc.replace(mind, grasp_request=mind.grasp_request + 1)
            return asked.entering("plan grasps")
        return dc.replace(mind, touch=touch).moving(touch.legs).entering("touch")

    def _touch(self, context: Context, mind: _Mind) -> _Mind:
        """S2: until the program ends, at a contact or without."""
        progress: Progress = self._inputs["progress"].Eval(context)
        if progress.done < mind.program.id:
            return mind
        now = context.get_time()
        if progress.felt and mind.touched_s is None:
            return dc.replace(mind, touched_s=now)
        if mind.touched_s is not None and now < mind.touched_s + self._settings.feel_s:
            return mind
        touch = mind.touch
        assert touch is not None
        felt: ContactSet = self._inputs["contact_point"].Eval(context)
        record = TouchRecord(touch.plan, False, context.get_time())
        if progress.felt and len(felt):
            record = dc.replace(record, felt=True, p_WC=felt.p_WC[0], n_WC=felt.n_WC[0])
            before, mind = mind.shift, self._shifted(context, mind)
            record = dc.replace(record, view_shift=mind.shift - before)
            mind = dc.replace(mind, contacts=mind.contacts.with_contact(record.p_WC, record.n_WC))
        story = dc.replace(mind.story, touches=(*mind.story.touches, record))
        mind = dc.replace(mind, story=story, touched_s=None)
        return mind.moving(touch.retreat).entering("retreat")

    def _shifted(self, context: Context, mind: _Mind) -> _Mind:
        """The view moves by what a touch tells of the camera's error."""
        if not mind.view.shift_covariance.any():
            return mind
        assert mind.touch is not None
        q = self._inputs["joint_state"].Eval(context)[:8]
        way = mind.touch.way(self._kinematics.pose(q))
        centers, radii = self._hand.spheres(self._hand.lower)
        p_WS = np.array([centers @ X[:3, :3].T + X[:3, 3] for X in way])
        distance = obstacles(self._inputs["surface"].Eval(context), mind.view.table).distance
        shift, left = felt_shift(distance, p_WS, radii, mind.view.shift_covariance)
        return dc.replace(mind, view=moved(mind.view, shift, left), shift=mind.shift + shift)

    def _retreat(self, context: Context, mind: _Mind) -> _Mind:
        progress: Progress = self._inputs["progress"].Eval(context)
        return mind if progress.done < mind.program.id else self._estimating(mind)

    def _plan_grasps(self, context: Context, mind: _Mind) -> _Mind:
        """S4 and S5: the best rated grasp that the arm can do."""
        if not self._served(context, "grasp", mind.grasp_request):
            return mind
        candidates: Candidates = self._inputs["candidates"].Eval(context)
        if len(candidates) == 0:
            return mind.giving_up("no grasp was found on the estimated surface")
        scores: GraspScores = self._inputs["scores"].Eval(context)
        order = self._inputs["ranking"].Eval(context)
        if mind.failed:
            worth = scores.score * discounts(candidates, mind.failed)
            order = ranking(dc.replace(scores, score=worth))
        scene = obstacles(self._inputs["surface"].Eval(context), mind.view.table)
        q = self._inputs["joint_state"].Eval(context)[:8]
        found = find_grasp(
            candidates,
            order,
            scene,
            self._hand,
            self._kinematics,
            q,
            self._settings.grasp,
            collisions=self._collisions,
        )
        if found is None:
            return mind.giving_up(
                f"the arm can carry out none of {len(candidates)} planned grasps; "
                "turn the object or put it nearer to (0.7, -0.3) m"
            )
        index, legs = found
        record = GraspRecord(
            X_WH=candidates.X_WH[index],
            motion=candidates.motion[index],
            planner=candidates.planner[index],
            score=float(scores.score[index]),
            rank=list(order).index(index),
            candidates=dict(Counter(candidates.planner)),
        )
        story = dc.replace(mind.story, grasps=(*mind.story.grasps, record))
        return dc.replace(mind, story=story).moving(legs).entering("grasp")

    def _grasp(self, context: Context, mind: _Mind) -> _Mind:
        """S6: until the object was held up, or the hand has lost it."""
        progress: Progress = self._inputs["progress"].Eval(context)
        weight = -float(self._inputs["force"].Eval(context)[2])
        held = weight > self._settings.least_weight_n or self._is_kept_open(context, mind)
        if progress.done >= mind.program.id:
            return self._held(mind, weight) if held else self._lost(context, mind)
        if progress.leg != "hold":
            return mind
        unloaded = 0 if held else mind.unloaded + 1
        if unloaded >= self._settings.lost_after:
            return self._lost(context, mind)
        return mind if unloaded == mind.unloaded else dc.replace(mind, unloaded=unloaded)

    def _is_kept_open(self, context: Context, mind: _Mind) -> bool:
        """Whether every motor stops before it is where it goes to, and where an empty hand stops.

        Something between the fingers stops it.
        """
        empty = np.array([motor.empty for motor in self._hand.description.motors])
        free = np.minimum(empty, mind.program.legs[-1].motors)
        travel = self._inputs["motor_fraction"].Eval(context)
        return bool((travel < free - self._settings.least_gap).all())

    def _held(self, mind: _Mind, weight_n: float) -> _Mind:
        story = mind.story.with_outcome(held=True, weight_n=weight_n)
        return dc.replace(mind, story=dc.replace(story, phase="done", finished=True))

    def _lost(self, context: Context, mind: _Mind) -> _Mind:
        """Neither wrist nor fingers feel anything: let go, look again, and grasp otherwise."""
        story = mind.story.with_outcome(held=False, weight_n=0.0)
        if len(story.grasps) >= self._settings.attempts:
            return dc.replace(mind, story=dc.replace(story, phase="done", finished=True))
        grasp = story.grasps[-1]
        q = self._inputs["joint_state"].Eval(context)[:8]
        table, free_of = mind.view.table, self._collisions
        legs = release_legs(self._hand, self._kinematics, q, table, collisions=free_of)
        failed = (*mind.failed, (grasp.X_WH, grasp.motion))
        mind = dc.replace(mind, story=story, failed=failed, unloaded=0)
        return mind.moving(legs).entering("let go")

    def _let_go(self, context: Context, mind: _Mind) -> _Mind:
        progress: Progress = self._inputs["progress"].Eval(context)
        return mind if progress.done < mind.program.id else mind.entering("look")

    def _calc_phase(self, context: Context, output: Value) -> None:
        mind = self._mind(context)
        progress: Progress = self._inputs["progress"].Eval(context)
        moving = mind.story.phase in ("touch", "retreat", "grasp", "let go") and progress.leg
        output.set_value(f"{mind.story.phase}: {progress.leg}" if moving else mind.story.phase)

    def _calc_request(self, context: Context, output: BasicVector, name: str) -> None:
        output.SetAtIndex(0, float(getattr(self._mind(context), name)))
