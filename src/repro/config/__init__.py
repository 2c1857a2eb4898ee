"""The configuration: its keys, the check of files against them, and the sections that a job reads."""
