"""Checks of the paper against itself, one subject a module; `repro.paper.audit` runs them all."""
