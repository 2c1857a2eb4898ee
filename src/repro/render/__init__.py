"""Drawing only: each figure from one CSV, each table from one tidy CSV; nothing here computes a result."""
