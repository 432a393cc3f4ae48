"""Grasp candidates and their quality."""
