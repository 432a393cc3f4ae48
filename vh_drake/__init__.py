"""Visuo-haptic grasping of unknown objects with ARMAR-6, as one Drake diagram."""

from pathlib import Path

from vh_drake.machine_code import forget_stale

forget_stale(Path(__file__).parent)
