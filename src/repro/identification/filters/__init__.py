"""Zero-phase filters that differentiate: one a file."""
