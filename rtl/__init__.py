"""The board of Section III as logic: the blocks of Fig. 2 and 3 in Amaranth HDL, one module each."""
