"""Algorithm 1 of the paper, its refinement, and the network that it asks."""
