"""Follow two recipes of CONTRIBUTING.md on a copy of the checkout: a setting, and a figure.

No test may need an edit: kept lists alone are written again. The installed packages are shadowed by those of the copy.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
#: A setting: the rate of the moving average of Muon. One field, one use.
FIELD = """    momentum: Annotated[Share, Key("decay of Muon's moving average of gradients")] = 0.95
"""
#: What it stands before.
MARK = "    #: Of layers 1 to 4 and of Muon's wide products.\n"
#: A figure, at the end of a module of exhibits: what draws it, and what computes its numbers.
FIGURE = '''

def draw_tracking_error(frame: pd.DataFrame) -> Figure:
    """Error of each joint over the time of each motion."""
    drawn, axes = style.new_panels(style.COLUMN, 3.2, 1, 1)
    for curve, rows in frame.groupby(["panel", "series"], sort=False):
        axes.plot(rows["x"], 1e3 * rows["y"], label=" ".join(curve))
    axes.set(xlabel=TIME, ylabel="Tracking error (mrad)")
    return style.legend_above(drawn, axes, 2, style.SIMULATED)


@_figure("Tracking error", draw_tracking_error, inputs=("validation",))
def tracking_error(inputs: Inputs, config: Configuration) -> pd.DataFrame:
    """Desired less measured position on the validation motions of the simulated arm, every tenth sample."""
    recordings, h = read_recordings(inputs["captures"], config), config.signals.sampling_period_s
    parts = []
    for recording in recordings:
        error = (recording.program.q - recording.q)[:, ::10]
        x = 10 * h * np.arange(error.shape[1], dtype=np.float64)
        parts += [(recording.program.name, f"joint{joint}", x, error[joint - 1]) for joint in (1, 2)]
    return long_table(parts)
'''


def edit(file: Path, *changes: tuple[str, str]) -> None:
    """Replace texts that occur once."""
    text = file.read_text(encoding="utf-8")
    for old, new in changes:
        if text.count(old) != 1:
            sys.exit(f"{file}: {old!r} occurs {text.count(old)} times")
        text = text.replace(old, new)
    file.write_text(text, encoding="utf-8")


def copy_to(folder: Path) -> None:
    """Copy the tracked files, and the environment as a link."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, listed.split("\0")):
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, target, follow_symlinks=False)
    (folder / ".venv").symlink_to(Path(sys.prefix))


def main() -> None:
    """Add a setting and a figure, and test the copy."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "checkout"
        copy_to(folder)
        environment = {**os.environ, "PYTHONPATH": str(folder / "src")}

        def run(*command: str, may_fail: bool = False) -> None:
            print("$", *command, flush=True)
            done = subprocess.run(command, cwd=folder, env=environment, check=False)
            if done.returncode and not may_fail:
                sys.exit(f"{command}: exit code {done.returncode}")

        def test(*arguments: str, may_fail: bool = False) -> None:
            run(sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments, may_fail=may_fail)

        edit(
            folder / "src/repro/cnn/architecture.py",
            (MARK, FIELD + MARK),
            ("Seed, Whole", "Seed, Share, Whole"),
        )
        edit(
            folder / "src/repro/cnn/train.py",
            (
                "lr: float, dtype: torch.dtype) -> None",
                "lr: float, dtype: torch.dtype, momentum: float = 0.95) -> None",
            ),
            ('"momentum": 0.95', '"momentum": momentum'),
            ("Muon(weights, s.learning_rate, net.dtype)", "Muon(weights, s.learning_rate, net.dtype, s.momentum)"),
        )
        run(sys.executable, "config/reference.py")
        run(sys.executable, "-m", "repro", "check", "config/quick.yaml")  # no stored network is refused
        test("tests/test_config.py", "tests/experiments/test_networks.py", "tests/cnn/test_train.py")

        module = folder / "src/repro/exhibits/arm_experiment.py"
        module.write_text(module.read_text(encoding="utf-8") + FIGURE, encoding="utf-8")
        golden = ("--configfile", "config/golden.yaml")
        run(str(Path(sys.executable).with_name("snakemake")), "tracking_error", "--cores", "2", *golden)
        made = folder / "results/golden/figures/tracking_error.csv"
        rows = made.read_text(encoding="utf-8").splitlines()
        kept = [rows[0], *rows[1 :: max(1, len(rows) // 60)]]  # as `.ci/golden.py --write` keeps it
        (folder / "tests/golden/figures/tracking_error.csv").write_text("\n".join(kept) + "\n", encoding="utf-8")
        lists = ("tests/exhibits/test_drawings.py", "tests/project/test_workflow.py")
        chosen = ("-k", "tracking_error or rules_are_those_kept")
        test(*lists, *chosen, "--force-regen", may_fail=True)  # which writes the kept lists again
        test(*lists, *chosen)
        changed = subprocess.run(
            ["git", "diff", "--no-index", "--name-only", str(ROOT / "tests"), str(folder / "tests")],
            capture_output=True, text=True, check=False,
        ).stdout  # fmt: skip
        edited = [line for line in changed.splitlines() if line.endswith(".py") and "__pycache__" not in line]
        if edited:
            sys.exit(f"tests that had to be edited: {edited}")
        print("a setting and a figure: no test was edited")


if __name__ == "__main__":
    main()
