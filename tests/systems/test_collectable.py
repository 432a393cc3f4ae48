import gc
import importlib
import pkgutil
import weakref

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem, ValueProducer

import vh_drake.systems
from vh_drake.experiments.grasp_trial import make_trial
from vh_drake.scenes.scenario import Scenario
from vh_drake.systems.collectable import Collectable, CollectableSystem


class Counter(CollectableSystem):
    """Uses all that Drake may keep of a system: ports, closures, a cache entry, events, state."""

    def __init__(self):
        super().__init__()
        self._step = 2.0
        self._input = self.DeclareVectorInputPort("u", 1)
        self._count = self.DeclareDiscreteState(1)
        self.DeclarePeriodicDiscreteUpdateEvent(0.1, 0.0, self._advance)
        self.DeclareForcedPublishEvent(self._publish)
        self._kept = self.DeclareCacheEntry(
            "count", ValueProducer(lambda: Value[object](None), self.weakly(self._calc_kept))
        ).cache_index()
        self.DeclareVectorOutputPort("count", 1, self._calc_count)
        self.DeclareAbstractOutputPort(
            "text",
            lambda: Value[str](""),
            calc=lambda context, output: output.set_value(
                str(self.get_cache_entry(self._kept).Eval(context))
            ),
        )

    def _advance(self, context, state):
        state.set_value(context.get_discrete_state_vector().value() + self._step)

    def _publish(self, _context):
        return None

    def _calc_kept(self, context, output):
        output.set_value(float(context.get_discrete_state_vector().value()[0]))

    def _calc_count(self, context, output):
        output[0] = context.get_discrete_state_vector().value()[0] + self._input.Eval(context)[0]


class SubCounter(Counter):
    """A further class on the way changes nothing."""


class CountingDiagram(Diagram, metaclass=Collectable):
    """A diagram class with attributes."""

    counter: Counter


def built(kind):
    builder = DiagramBuilder()
    counter = builder.AddSystem(kind())
    builder.ExportInput(counter.GetInputPort("u"))
    diagram = CountingDiagram()
    builder.BuildInto(diagram)
    diagram.counter = counter
    context = diagram.CreateDefaultContext()
    diagram.get_input_port().FixValue(context, [0.5])
    return diagram, context, counter


@pytest.mark.parametrize("kind", [Counter, SubCounter])
def test_ports_events_and_cache_entries_work_as_drakes(kind):
    diagram, context, counter = built(kind)
    gc.collect()
    Simulator(diagram, context).AdvanceTo(0.35)
    own = counter.GetMyContextFromRoot(context)
    assert counter.GetOutputPort("count").Eval(own) == pytest.approx(8.5)
    assert counter.GetOutputPort("text").Eval(own) == "8.0"


@pytest.mark.parametrize("kind", [Counter, SubCounter])
def test_a_diagram_that_nobody_uses_is_freed(kind):
    def simulated():
        diagram, context, counter = built(kind)
        Simulator(diagram, context).AdvanceTo(0.2)
        counter.GetOutputPort("text").Eval(counter.GetMyContextFromRoot(context))
        return weakref.ref(counter), weakref.ref(diagram)

    gone = simulated()
    gc.collect()
    assert [ref() for ref in gone] == [None, None]


def test_a_system_that_is_used_keeps_its_diagram():
    counter = built(Counter)[2]
    gc.collect()
    context = counter.CreateDefaultContext()
    counter.GetInputPort("u").FixValue(context, [3.0])
    np.testing.assert_allclose(counter.GetOutputPort("count").Eval(context), [3.0])


def test_every_system_of_the_package_can_be_freed():
    modules = [
        importlib.import_module(f"vh_drake.systems.{module.name}")
        for module in pkgutil.iter_modules(vh_drake.systems.__path__)
    ]
    ours = {
        value
        for module in modules
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, LeafSystem)
        and value.__module__ == module.__name__
    }
    assert len(ours) > 20
    assert [kind.__name__ for kind in ours if not issubclass(kind, CollectableSystem)] == []


def test_the_whole_robot_is_freed_after_a_trial_with_every_system_that_it_had():
    def simulated():
        trial = make_trial(Scenario(object="fruit_drink", contact="point", time_step_s=0.004))
        Simulator(trial.diagram, trial.context).AdvanceTo(0.05)
        return weakref.ref(trial.diagram)

    gc.collect()
    before = {id(x) for x in gc.get_objects() if issubclass(type(x), LeafSystem)}
    gone = simulated()
    gc.collect()
    assert gone() is None
    after = [x for x in gc.get_objects() if issubclass(type(x), LeafSystem) and id(x) not in before]
    assert [type(x).__name__ for x in after] == []
