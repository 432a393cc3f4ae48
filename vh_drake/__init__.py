"""Visuo-haptic grasping of unknown objects with ARMAR-6, as one Drake diagram."""
