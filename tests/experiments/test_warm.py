"""After warming, the kernels of a trial are there: a first run compiles nothing of these."""

import pytest

from vh_drake.control import kernels as control
from vh_drake.experiments.warm import main
from vh_drake.geometry import signed_distance, triangle_kernels
from vh_drake.gpis import kernels as gpis
from vh_drake.grasping import closure_rate, placement
from vh_drake.hand import kinematics

KERNELS = (
    control.roll_to_pose,
    control.joint_velocity,
    signed_distance._interpolate,
    triangle_kernels.distances_by_sweeping,
    triangle_kernels.point_distances,
    gpis.covariance_matrix,
    closure_rate._rate_all,
    placement._free_lifts,
    placement._ways,
    kinematics.link_poses,
)


@pytest.mark.slow
def test_warming_compiles_what_estimation_touch_and_planning_need(capsys):
    main()
    assert "ready after" in capsys.readouterr().out
    missing = [kernel.py_func.__qualname__ for kernel in KERNELS if not kernel.signatures]
    assert not missing
