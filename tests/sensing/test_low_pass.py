import numpy as np
import pytest
from scipy import signal

from vh_drake.errors import BadInput
from vh_drake.sensing.low_pass import LowPass


def run(low_pass, values, state):
    out = []
    for value in values:
        state, y = low_pass.step(state, value)
        out.append(y)
    return np.array(out)


def test_coefficients_and_output_are_those_of_scipy():
    low_pass = LowPass.butterworth(10.0, 0.002)
    b, a = signal.butter(2, 10.0, fs=500.0)
    np.testing.assert_allclose([*low_pass.b, *low_pass.a], [*b, *a[1:]], rtol=1e-9)
    values = np.random.default_rng(0).standard_normal((200, 3))
    ours = run(low_pass, values, np.zeros((2, 3)))
    np.testing.assert_allclose(ours, signal.lfilter(b, a, values, axis=0), atol=1e-12)


def test_a_settled_filter_stays_at_its_value():
    low_pass = LowPass.butterworth(10.0, 0.002)
    value = np.array([1.0, -2.0])
    np.testing.assert_allclose(run(low_pass, [value] * 50, low_pass.settled(value)), [value] * 50)


def test_noise_gain_is_what_white_noise_shows():
    low_pass = LowPass.butterworth(10.0, 0.002)
    noise = np.random.default_rng(0).standard_normal((200_000, 1))
    b, a = [*low_pass.b], [1.0, *low_pass.a]
    measured = signal.lfilter(b, a, noise, axis=0).std()
    assert low_pass.noise_gain() == pytest.approx(measured, rel=0.03)


@pytest.mark.parametrize(("cutoff", "period"), [(0.0, 0.002), (300.0, 0.002), (10.0, 0.0)])
def test_a_cutoff_beyond_half_the_rate_is_refused(cutoff, period):
    with pytest.raises(BadInput, match="sampling period"):
        LowPass.butterworth(cutoff, period)
