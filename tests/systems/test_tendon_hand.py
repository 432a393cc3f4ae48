import numpy as np
import pytest
from leaf import Leaf

from vh_drake.errors import UnknownName
from vh_drake.geometry.model_files import models_folder
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.systems.tendon_hand import PERIOD_S, STROKE_S, TendonHand

HAND = read_hand_model(load_hand(models_folder() / "armar6_hand" / "armar6_hand.yaml"))
STROKE = np.array([motor.closed_m for motor in HAND.description.motors])


def drive(command=(0.0, 0.0), travel=(0.0, 0.0), force=(0.0, 0.0), caching=True):
    return Leaf(
        TendonHand(HAND),
        caching=caching,
        motor_command=command,
        motor_state=np.concatenate([travel, [0.0, 0.0]]),
        motor_force=force,
    )


def set_points(leaf, steps):
    """Positions and velocities of the set points after each of some periods."""
    rows = []
    leaf.advance(PERIOD_S / 2)  # Off the updates.
    for _ in range(steps):
        leaf.advance(PERIOD_S)
        rows.append(leaf.get("motor_set_point"))
    return np.array(rows)


@pytest.mark.parametrize("caching", [True, False])
def test_set_points_reach_the_command_at_a_bounded_rate(caching):
    leaf = drive(command=(1.0, 0.4), caching=caching)
    rows = set_points(leaf, round(STROKE_S / PERIOD_S) + 2)
    rates = np.diff(rows[:, :2], axis=0) / PERIOD_S
    assert (rates <= STROKE / STROKE_S + 1e-9).all()
    assert (rates >= -1e-9).all()
    np.testing.assert_allclose(rows[1:, 2:], rates, atol=1e-9)
    np.testing.assert_allclose(rows[-1, :2], [1.0, 0.4] * STROKE, atol=1e-12)
    np.testing.assert_allclose(rows[-1, 2:], 0.0, atol=1e-12)


def test_commands_outside_the_stroke_stop_at_its_ends():
    rows = set_points(drive(command=(3.0, -2.0)), 200)
    np.testing.assert_allclose(rows[-1, :2], [STROKE[0], 0.0], atol=1e-12)
    assert rows[:, :2].min() >= 0.0


def test_the_finger_motor_takes_the_stroke_s_shortest_time():
    rows = set_points(drive(command=(1.0, 0.0)), 200)
    arrival = PERIOD_S * np.argmax(rows[:, 0] > STROKE[0] - 1e-9)
    assert arrival == pytest.approx(STROKE_S, abs=3 * PERIOD_S)


@pytest.mark.parametrize("caching", [True, False])
def test_joints_are_those_that_the_springs_share_out(caching):
    for fraction in ([0.0, 0.0], [0.3, 0.8], [1.0, 1.0]):
        leaf = drive(travel=fraction * STROKE, caching=caching)
        np.testing.assert_allclose(leaf.get("motor_fraction"), fraction, atol=1e-12)
        np.testing.assert_allclose(
            leaf.get("finger_joints"), HAND.joint_angles(np.array(fraction)), atol=1e-9
        )


def test_travel_beyond_the_stops_counts_as_open_or_closed():
    leaf = drive(travel=(-0.001, 0.04))
    np.testing.assert_array_equal(leaf.get("motor_fraction"), [0.0, 1.0])


def test_fingers_of_one_motor_share_its_pull_and_slack_tendons_carry_none():
    force = drive(force=(80.0, 30.0)).get("tendon_force")
    np.testing.assert_allclose(force, [20.0, 20.0, 20.0, 20.0, 30.0])
    for motor, pull in enumerate((80.0, 30.0)):
        assert force[HAND.motor_of_finger == motor].sum() == pytest.approx(pull)
    np.testing.assert_array_equal(drive(force=(-5.0, 2.0)).get("tendon_force")[:4], 0.0)


def test_two_contexts_do_not_touch_each_other():
    first = drive(command=(1.0, 1.0))
    still = Leaf(first.system, motor_command=(0.0, 0.0))
    first.advance(0.1)
    still.advance(0.1)
    assert first.get("motor_set_point")[0] > 0.0
    np.testing.assert_array_equal(still.get("motor_set_point"), 0.0)


def force_drive(command, pull, travel):
    return Leaf(
        TendonHand(HAND, "force"),
        motor_command=command,
        motor_state=np.concatenate([travel, [0.0, 0.0]]),
        motor_force=pull,
    )


def test_force_commands_move_the_set_points_until_the_pulls_agree():
    travel = np.array([0.02, 0.01])
    leaf = force_drive((30.0, 5.0), (20.0, 5.0), travel)
    rows = set_points(leaf, 80)
    assert (np.diff(rows[:, 0]) >= 0).all()
    assert (np.diff(rows, axis=0)[:, :2] <= STROKE * PERIOD_S / STROKE_S + 1e-12).all()
    settled = force_drive((30.0, 5.0), (30.0, 5.0), travel)
    rows = set_points(settled, 80)
    np.testing.assert_allclose(rows[-1, :2] - rows[-2, :2], 0.0, atol=1e-12)


def test_a_pull_that_can_not_be_reached_does_not_wind_up_the_set_points():
    travel = np.array([0.02, 0.01])
    rows = set_points(force_drive((120.0, 120.0), (0.0, 0.0), travel), 400)
    np.testing.assert_allclose(rows[-1, :2], travel + 0.002, atol=1e-12)


def test_an_unknown_kind_of_command_lists_the_choices():
    with pytest.raises(UnknownName, match="force, position"):
        TendonHand(HAND, "speed")
