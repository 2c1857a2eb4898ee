"""Reproduction of a CNN-based parameter identification of a two-joint robot arm."""

__version__ = "0.1.0"
