"""How well parameters predict: torque of a motion, and the motion that a torque makes."""
