"""Every table and figure: what there is, the numbers, the drawings."""
