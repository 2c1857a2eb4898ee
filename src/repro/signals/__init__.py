"""Signals: the DCT-II filter, derivative and subsampling, the similarity metric, and trajectories."""
