"""Puts the unknown object on the table, where the seed says."""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context

from vh_drake.geometry.stable_poses import draw_pose
from vh_drake.objects.model import ObjectModel
from vh_drake.scenes.scenario import Scenario
from vh_drake.scenes.station import Station

GAP_M = 0.0005  # over the table at the start


def draw_object_pose(scenario: Scenario, model: ObjectModel) -> RigidTransform:
    """X_WO of a stable pose, turned about the vertical, near the middle of the placement."""
    rng = np.random.default_rng([scenario.seed, 1])
    X_TO = draw_pose(model.mesh, seed=int(rng.integers(2**31)))
    radius = scenario.placement.radius_m * np.sqrt(rng.random())
    angle = rng.uniform(0, 2 * np.pi)
    x, y = scenario.placement.center
    p_WT = [
        x + radius * np.cos(angle),
        y + radius * np.sin(angle),
        scenario.table.height_m + GAP_M,
    ]
    return RigidTransform(p_WT) @ RigidTransform(X_TO)


def place_object(station: Station, root_context: Context, X_WO: RigidTransform) -> None:
    """Set the object's pose in the root context of a diagram that holds the station."""
    plant = station.world.plant
    plant.SetFreeBodyPose(
        plant.GetMyMutableContextFromRoot(root_context), station.world.object, X_WO
    )
