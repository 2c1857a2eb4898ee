"""Rigid-body dynamics of the two-joint arm: Eq. 1, its regressor, and when a parameter set is physical."""
