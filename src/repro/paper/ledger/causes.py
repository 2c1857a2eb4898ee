"""Why numbers differ: one cause for each comparison that can differ, with the evidence for it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Cause:
    """A cause, and the page or table that shows it."""

    title: str
    why: str
    evidence: str  # page of docs/ with its anchor, or target of the workflow


CAUSES: dict[str, Cause] = {
    "closed-loop motion": Cause(
        "Algorithm 1 as listed on a motion that an arm has tracked",
        "The network is trained on Eq. 10 itself. Line 18 gives it the measured motion, whose acceleration has spikes "
        "where friction reverses, and the torque contains effects that Eq. 1 does not model. Closed-loop training, the "
        "desired motion in line 18, back-EMF and the reader each change the result on T1 to T4.",
        "reproduction-notes.md#the-factorial-of-causes",
    ),
    "image reader": Cause(
        "What closed-loop training and the desired motion leave",
        "A plain network that reads the torque samples instead of the image of Eq. 9 is better by more than what is "
        "left here.",
        "reproduction-notes.md#the-factorial-of-causes",
    ),
    "another arm": Cause(
        "A simulated arm in place of the published one",
        "The arm is calibrated on the least-squares cells of ID. Its friction, ripple and motors are not the published "
        "arm's, which no longer exists, so the other cells are predictions for another arm.",
        "reproduction-notes.md#four-numbers-calibrate-the-simulated-arm",
    ),
    "another network": Cause(
        "One trained network in place of another",
        "The interval is over the seeds of the guesses. Estimates and similarities of a network of another training "
        "seed differ by more, and the paper's weights are not available.",
        "numbers.md#how-networks-scatter",
    ),
    "lag of the gains": Cause(
        "The lag of joint 1 that its gains imply",
        "With the gains as printed joint 1 follows with a lag of K_v h / K_p = 17.6 ms, twice that of joint 2.",
        "reproduction-notes.md#gains-and-arithmetic-of-the-controller",
    ),
    "unlisted memory": Cause(
        "Memory that the paper does not list",
        "The count is of the stored trajectory alone. Gains and buffers come on top.",
        "reference/tables/audit.md",
    ),
}
