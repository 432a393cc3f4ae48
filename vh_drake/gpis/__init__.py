"""Gaussian process implicit surfaces: kernels, posterior, evidence, meshing."""
