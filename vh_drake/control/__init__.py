"""Cartesian and null-space control."""
