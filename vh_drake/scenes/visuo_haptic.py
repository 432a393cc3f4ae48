"""The whole diagram: a station, and the part that decides, joined by the robot's own ports."""

from pydrake.systems.framework import Diagram, DiagramBuilder

from vh_drake.objects.model import ObjectModel
from vh_drake.scenes.decision import INPUTS, Decision, make_decision
from vh_drake.scenes.scenario import Scenario
from vh_drake.scenes.station import Station, make_station

COMMANDS = ("spatial_velocity", "motor_command")


def join(builder: DiagramBuilder, station: Station, decision: Decision) -> None:
    """Connect sensors to the decision and its commands to the robot; both are in `builder`."""
    for port in dict.fromkeys(name for name, _, _ in INPUTS):
        builder.Connect(station.GetOutputPort(port), decision.GetInputPort(port))
    for port in COMMANDS:
        builder.Connect(decision.GetOutputPort(port), station.GetInputPort(port))


def make_visuo_haptic_diagram(scenario: Scenario, model: ObjectModel) -> Diagram:
    """Station and decision as subdiagrams "station" and "decision", closed into one diagram."""
    builder = DiagramBuilder()
    station = builder.AddSystem(make_station(scenario, model))
    decision = builder.AddSystem(make_decision(scenario))
    join(builder, station, decision)
    return builder.Build()
