"""History matching (Craig and others 1997): experiments that the printed numbers do not rule out.

`unknowns` has what the paper leaves open, with ranges and hypotheses, `evidence` the printed numbers and the rule of
acceptance, `search` the fit from many random starts, `compiled` the closed loop in machine code. No network has a part.
"""
