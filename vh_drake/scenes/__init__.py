"""Scenarios and the functions that build plants and diagrams from them."""
