"""The published numbers and their audit: read by checks and comparisons, never by code that makes our results."""
