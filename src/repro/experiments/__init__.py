"""The workflow's stages: each function turns settings and earlier results into a table or a file."""
