import numpy as np
import pytest

from vh_drake.sensing.wrist_noise import WristNoiseSettings, wrist_noise


def test_white_noise_has_the_stated_deviations_per_axis():
    quiet = WristNoiseSettings(force_drift_n=0.0, torque_drift_nm=0.0)
    samples = np.array([wrist_noise(0.002 * i, 3, quiet) for i in range(3000)])
    expected = [0.0005] * 3 + [0.02] * 3
    np.testing.assert_allclose(samples.std(axis=0), expected, rtol=0.06)
    correlation = np.corrcoef(samples[1:, 3], samples[:-1, 3])[0, 1]
    assert abs(correlation) < 0.06


def test_drift_is_bounded_and_slow():
    drift = WristNoiseSettings(force_std_n=0.0, torque_std_nm=0.0)
    samples = np.array([wrist_noise(0.1 * i, 5, drift) for i in range(1000)])
    assert np.abs(samples[:, 3:]).max() <= 0.01
    assert np.abs(np.diff(samples[:, 3:], axis=0)).max() < 0.0003


def test_noise_is_a_function_of_time_and_seed():
    assert np.array_equal(wrist_noise(1.0, 2), wrist_noise(1.0, 2))
    assert not np.array_equal(wrist_noise(1.0, 2), wrist_noise(1.002, 2))
    assert not np.array_equal(wrist_noise(1.0, 2), wrist_noise(1.0, 3))
    assert wrist_noise(0.0, 0) == pytest.approx(wrist_noise(0.0, 0))
