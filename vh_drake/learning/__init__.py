"""Learned ratings of grasps."""
