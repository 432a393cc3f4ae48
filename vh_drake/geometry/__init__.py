"""Meshes, their repair, distances and samples."""
