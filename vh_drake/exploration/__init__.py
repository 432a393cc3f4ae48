"""Where to touch next, and the curve that leads there."""
