"""Algorithm 1, its refinement, and the numeric experiment that tests both."""
