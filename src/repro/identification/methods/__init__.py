"""Least squares of a regression: one method a file."""
