"""Next best touch: ratings, trajectories, and the plan that joins them."""
