"""The fuzz tests of the loaders together; each lies beside the tests of its loader."""

import mmap
import time

import numpy as np
import pytest
from fuzzing import FILES, damaged, limits


def test_all_loaders_together_take_a_thousand_damaged_files():
    assert sum(FILES.values()) >= 1000
    assert min(FILES.values()) >= 60


def test_the_limits_stop_a_hang():
    with pytest.raises(TimeoutError), limits(seconds=0.1, megabytes=500):
        time.sleep(60.0)


def test_the_limits_stop_memory_without_bound():
    with pytest.raises(OSError, match="allocate"), limits(seconds=10.0, megabytes=100):
        mmap.mmap(-1, 200 * 2**20)


def test_the_limits_leave_no_trace():
    with limits(seconds=0.05, megabytes=50):
        pass
    mmap.mmap(-1, 200 * 2**20).close()


def test_damages_depend_on_the_seed_alone_and_mostly_change_the_data():
    data = bytes(range(256))
    both = [
        [damaged(data, rng, (b"x",)) for _ in range(50)]
        for rng in (np.random.default_rng(1), np.random.default_rng(1))
    ]
    assert both[0] == both[1]
    assert sum(changed != data for changed in both[0]) > 45
