"""Results of two runs, or of a run and what was kept of it: which numbers may differ, and by how much."""
