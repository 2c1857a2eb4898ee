"""The command line with a board that plays back frames: run as a script, or import `stub`."""

import sys
import types

from fake_board import PlayedBoard, frames_of, metadata

from repro.signals.programs import ReferenceTrajectory

DESIRED, FRAMES = frames_of(200)


def load_config(path):
    """Stands for `repro.config.check.load_config`."""
    return types.SimpleNamespace(experiment=types.SimpleNamespace(port="/nowhere", baud=115200, seed=1))


def stub():
    """Stands for `repro.experiments.arm`: one motion, whatever its name."""
    module = types.ModuleType("repro.experiments.arm")
    module.board_from_config = lambda config, make: PlayedBoard(FRAMES)
    module.program_from_config = lambda config, name: ReferenceTrajectory(name, DESIRED, 10, 190, 0.0025)
    module.check_program = lambda config, program: None
    module.metadata_for = lambda sent, config: metadata(sent.q, motion=sent.name, n1=sent.n1, n2=sent.n2, board=None)
    return module


if __name__ == "__main__":
    sys.modules["repro.experiments.arm"] = stub()
    import repro.config.check
    from repro.cli import main

    repro.config.check.load_config = load_config

    sys.exit(main(sys.argv[1:]))
