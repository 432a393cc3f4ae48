import numpy as np
import pytest
import trimesh

from vh_drake.exploration.coverage import unexplored
from vh_drake.geometry.meshes import from_trimesh

BALL = from_trimesh(trimesh.creation.icosphere(5, 0.05))


def test_a_contact_explores_the_cap_within_the_radius():
    coverage = unexplored(BALL, radius_m=0.02).with_contact(np.array([0.05, 0, 0]))
    # The cap of a sphere within a chord r has the area pi r².
    assert coverage.share == pytest.approx(0.02**2 / (4 * 0.05**2), abs=0.01)


def test_coverage_never_falls_and_a_contact_counts_once():
    coverage, shares = unexplored(BALL, radius_m=0.02), []
    for u in np.random.default_rng(0).normal(size=(60, 3)):
        coverage = coverage.with_contact(0.05 * u / np.linalg.norm(u))
        shares.append(coverage.share)
    assert shares == sorted(shares)
    again = coverage.with_contact(0.05 * u / np.linalg.norm(u))
    assert again.share == coverage.share


def test_an_untouched_object_is_unexplored():
    assert unexplored(BALL, radius_m=0.02).share == 0.0
