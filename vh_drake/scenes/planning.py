"""The deciding systems without a robot: from an object's view and touches to rated grasps."""

from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from vh_drake.hand.model import HandModel
from vh_drake.scenes.rating import make_scorer
from vh_drake.sensing.segmentation import SegmentationSettings
from vh_drake.systems.gpis_estimator import GpisEstimator
from vh_drake.systems.grasp_candidate_planner import GraspCandidatePlanner
from vh_drake.systems.grasp_scorer import GraspScorer
from vh_drake.systems.object_segmenter import ObjectSegmenter

STAGES = ("estimator", "planner", "scorer")  # In the order in which they are served

_WIRES = (
    ("request", "y0", "estimator", "request"),
    ("estimator", "served", "planner", "request"),
    ("planner", "served", "scorer", "request"),
    ("estimator", "surface", "planner", "surface"),
    ("estimator", "surface", "scorer", "surface"),
    ("planner", "candidates", "scorer", "candidates"),
)
_OUTPUTS = (
    ("estimator", "surface"),
    ("planner", "candidates"),
    ("scorer", "scores"),
    ("scorer", "ranking"),
)


def make_planning(
    hand: HandModel,
    seed: int,
    segmentation: SegmentationSettings | None,
    *,
    scorer: str = "learned",
    weights: str = "",
) -> Diagram:
    """A diagram that answers one request, in 0.06 s of its time.

    | port        | direction | type        | unit | meaning                                    |
    |-------------|-----------|-------------|------|--------------------------------------------|
    | cloud       | in        | Cloud       | m    | with `segmentation`: object and table      |
    | object_view | in        | ObjectView  | m    | without it: the object, the table          |
    | contacts    | in        | ContactSet  | m    | touched places                             |
    | object_view | out       | ObjectView  | m    | with `segmentation`: what was cut out      |
    | status      | out       | str         | -    | with `segmentation`: "ok", or why not      |
    | surface     | out       | Surface     | m    | estimate                                   |
    | candidates  | out       | Candidates  | m    | grasps                                     |
    | scores      | out       | GraspScores | -    | their ratings                              |
    | ranking     | out       | tuple       | -    | their indices, best first                  |

    Args:
        hand: that shall grasp.
        seed: of planner and scorer.
        segmentation: how the object is cut out of a cloud; None where its view is known.
        scorer: "learned" or "conventional".
        weights: of the learned scorer, see `make_scorer`.
    """
    builder = DiagramBuilder()
    systems = {
        "request": builder.AddNamedSystem("request", ConstantVectorSource([1.0])),
        "estimator": builder.AddNamedSystem("estimator", GpisEstimator()),
        "planner": builder.AddNamedSystem("planner", GraspCandidatePlanner(hand, seed=seed)),
        "scorer": builder.AddNamedSystem(
            "scorer", GraspScorer(make_scorer(scorer, hand, seed, weights))
        ),
    }
    for source, output, sink, port in _WIRES:
        builder.Connect(systems[source].GetOutputPort(output), systems[sink].GetInputPort(port))
    views = [systems[name].GetInputPort("object_view") for name in STAGES]
    if segmentation is None:
        builder.ExportInput(views[0], "object_view")
        for view in views[1:]:
            builder.ConnectInput("object_view", view)
    else:
        segmenter = builder.AddNamedSystem("segmenter", ObjectSegmenter(segmentation))
        builder.ExportInput(segmenter.GetInputPort("cloud"), "cloud")
        for name in ("object_view", "status"):
            builder.ExportOutput(segmenter.GetOutputPort(name), name)
        for view in views:
            builder.Connect(segmenter.GetOutputPort("object_view"), view)
    builder.ExportInput(systems["estimator"].GetInputPort("contacts"), "contacts")
    builder.ConnectInput("contacts", systems["scorer"].GetInputPort("contacts"))
    for name, port in _OUTPUTS:
        builder.ExportOutput(systems[name].GetOutputPort(port), port)
    planning = builder.Build()
    planning.set_name("planning")
    return planning
