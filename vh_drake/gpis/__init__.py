"""Gaussian process implicit surfaces."""
