"""The board in logic: its size on the paper's FPGA."""

import pandas as pd

from repro.exhibits.declare import METHOD, Inputs, table
from repro.exhibits.markup import Column, Table, grid, plain, words
from repro.files import read_csv
from repro.paper.published import load_published
from repro.pipeline.job import Config

COLUMNS = ("block", "quantity", "least", "most")
#: Published numbers by their place in the table.
_PUBLISHED = {
    ("published", "elements"): "section3/logic-used",
    ("published (%)", "elements"): "section3/logic-share",
    ("published (%)", "memory_bits"): "section3/memory-share",
}
_HEADS = {
    "lut": "LUT4",
    "flip_flops": "Flip-flops",
    "elements": "Logic elements",
    "multipliers": "9-bit multipliers",
    "memory_blocks": "M9K",
    "memory_bits": "Memory bits",
}
_WHOLE, _UNITS = ("board", "board (%)", "published", "published (%)", "device"), "symfpu"


def size_layout(frame: pd.DataFrame) -> Table:
    """Size of each block, of the board next to the published one, and of units that share nothing."""
    bounds = zip(frame["least"].round(2), frame["most"].round(2), strict=True)
    texts = frame.assign(text=[" to ".join(dict.fromkeys(f"{each:,.8g}" for each in pair)) for pair in bounds])
    wide = texts.pivot(index="block", columns="quantity", values="text").fillna("\N{EN DASH}")
    wide = wide.loc[frame["block"].unique()].reset_index()
    whole, units = wide["block"].isin(_WHOLE), wide["block"].str.startswith(_UNITS)
    columns: list[Column] = [("Block", "l", words("block"))]
    columns += [(head, "r", words(quantity)) for quantity, head in _HEADS.items()]
    groups = (("Blocks", ~whole & ~units), ("Board", whole), ("Units of Yosys that share nothing", units))
    return grid(board_size.caption, columns, [(plain(name), wide[chosen]) for name, chosen in groups])


@table("board_size", "Size of the board in logic", size_layout, category=METHOD, inputs=("board",), target="board_size")
def board_size(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Size of the board in logic, as Yosys maps it to the paper's FPGA without placing it. A logic element has a
    look-up table of four inputs (LUT4) and a flip-flop, so that the number of elements is between the larger number and
    the sum. The board has two of Decoder, PWM gen and H bridge; (%) is the share of the device. The last rows are IEEE
    units that come with Yosys (symfpu), the product once of look-up tables and once with multipliers of the device.
    What the published board shares is not known, so that a similar number of elements is no evidence.
    """
    frame, printed = read_csv(inputs["synthesis"][0], COLUMNS), load_published()
    sizes = frame.set_index(["block", "quantity"])
    share = (100.0 * sizes.loc["board"] / sizes.loc["device"]).dropna().reset_index().assign(block="board (%)")
    rows = [(*place, printed[name].value, printed[name].value) for place, name in _PUBLISHED.items()]
    return pd.concat([frame, share[list(COLUMNS)], pd.DataFrame(rows, columns=list(COLUMNS))], ignore_index=True)
