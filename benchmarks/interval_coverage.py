"""Coverage of the 95 % intervals of `repro identify` by kind of unmodelled effect, for two generators of arms.

Usage: ``python benchmarks/interval_coverage.py [--arms 30] [--out FOLDER] [--kind KIND ...]``; 15 minutes on one core.
Generator `board` is the simulated board behind its controller, with arms near the configured one. Generator `planar`
(`planar_arms.py`) shares no code with the package. Every kind uses the same arms and motions. A coverage is the mean
over arms of the share of an arm's asserted intervals that contain the truth; its Wilson interval counts arms.
"""

import argparse
import os
import re
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

from repro import contract

contract.hold(os.environ)

import numpy as np
import pandas as pd
import planar_arms

from repro.fpga.plant import Unmodelled
from repro.identification.least_squares import METHODS
from repro.logs.armfile import Arm
from repro.logs.diagnostics import Description
from repro.logs.log import Log
from repro.model.parameters import NAMES
from repro.ownarm.evaluate import evaluate, fit
from repro.ownarm.prepare import LoadedLog, Options, make_problem

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))
from board_arms import H, multisine, random_arms, recorded

METHOD_NAMES = ("ordinary", "consistent")
#: Normal quantile of the Wilson intervals.
Z = 1.96
#: Torque that depends on the position: amplitude over g1, cycles a turn.
WAVES = {
    "position torque, 2 cycles, 3 % of g1": (0.03, 2.0),
    "position torque, 2 cycles, 8 % of g1": (0.08, 2.0),
    "position torque, 6 cycles, 8 % of g1": (0.08, 6.0),
    "ripple, 17 cycles, 8 % of g1": (0.08, 17.0),
}
KINDS = (
    "clean",
    *WAVES,
    "Stribeck friction, 40 % of k",
    "Coulomb friction falls by 30 %",
    "warm-up: b and k fall by 40 %",
    "coarse encoder and noise",
)


def drift(kind: str, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Relative change of viscous and Coulomb friction over the log, each with mean zero."""
    if kind.startswith("Coulomb"):
        return np.zeros_like(t), 0.15 - 0.3 * t / t[-1]
    fall = np.exp(-t / (t[-1] / 3.0))
    return (0.4 * (fall - fall.mean()),) * 2


def planar_effect(kind: str, arm: planar_arms.Arm, m: planar_arms.Motion, rng: np.random.Generator) -> np.ndarray:
    """Torque of one kind of effect, shape (2, n)."""
    coulomb = arm.coulomb[:, None] * np.tanh(arm.steepness * m.dq)
    if kind in WAVES:
        share, cycles = WAVES[kind]
        return share * arm.beta[3] * np.sin(cycles * m.q + rng.uniform(0.0, 2.0 * np.pi, (2, 1)))
    if kind.startswith("Stribeck"):
        return 0.4 * coulomb * np.exp(-((m.dq / 0.2) ** 2))
    if kind.startswith(("Coulomb", "warm-up")):
        viscous, dry = drift(kind, m.t)
        return viscous * arm.viscous[:, None] * m.dq + dry * coulomb
    return np.zeros_like(m.q)


def planar_logs(kind: str, count: int) -> Iterator[tuple[np.ndarray, Log]]:
    """True parameters and log of each arm of the second generator."""
    for k in range(count):
        rng = np.random.default_rng((7, k))
        arm, m = planar_arms.draw_arm(rng), planar_arms.draw_motion(rng)
        further = planar_effect(kind, arm, m, rng)
        coarse = 8.0 if kind.startswith("coarse") else 1.0
        q, tau = planar_arms.record(arm, m, further, rng, coarse)
        yield arm.beta, Log(name=f"planar {k}", t=m.t, q=q, tau=tau)


@cache
def board_arms(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Arms of the first generator and their desired motions."""
    rng = np.random.default_rng(5)
    return random_arms(count, rng), np.stack([multisine(rng) for _ in range(count)])


@cache
def board_recordings(kind: str, count: int) -> list[Log]:
    """Logs of the simulated board with effects that move the arm."""
    arms, desired = board_arms(count)
    if kind in WAVES:
        share, cycles = WAVES[kind]
        effects = [Unmodelled(ripple=(share * beta[3],) * 2, ripple_cycles=cycles) for beta in arms]
        phase = np.random.default_rng(6).uniform(0.0, 2.0 * np.pi, (count, 2))
    else:
        effects = [Unmodelled(stribeck=(0.4, 0.4) if kind.startswith("Stribeck") else (0.0, 0.0))] * count
        phase = np.zeros((count, 2))
    return recorded(arms, desired, effects, phase)


def board_logs(kind: str, count: int) -> Iterator[tuple[np.ndarray, Log]]:
    """True parameters and log of each arm of the first generator; drift and noise are added to the clean logs."""
    arms, _ = board_arms(count)
    moved = kind in WAVES or kind.startswith("Stribeck")
    for k, (beta, log) in enumerate(zip(arms, board_recordings(kind if moved else "clean", count), strict=True)):
        q, tau, rng = log.q, log.tau, np.random.default_rng((8, k))
        if kind.startswith(("Coulomb", "warm-up")):
            speed = np.gradient(q, H, axis=-1)
            viscous, dry = drift(kind, log.t)
            tau = tau + viscous * beta[5:7, None] * speed + dry * beta[7:9, None] * np.tanh(20.0 * speed)
        if kind.startswith("coarse"):
            step = 8.0 * planar_arms.ENCODER
            tau = tau + 0.08 * np.sqrt(np.mean(tau**2, axis=-1, keepdims=True)) * rng.normal(size=tau.shape)
            q = step * np.rint(q / step)
        yield beta, Log(name=log.name, t=log.t, q=q, tau=tau)


GENERATORS: dict[str, Callable[[str, int], Iterator[tuple[np.ndarray, Log]]]] = {
    "board": board_logs,
    "planar": planar_logs,
}


def rows_of(generator: str, kind: str, count: int) -> Iterator[dict[str, object]]:
    """One row for each arm, method and parameter."""
    options = Options(METHOD_NAMES, Path("unused"))
    for k, (beta, log) in enumerate(GENERATORS[generator](kind, count)):
        problem = make_problem((LoadedLog(log, Description(log.name, ())),), (), Arm(), options)
        for name in METHOD_NAMES:
            found = evaluate(fit(METHODS[name], problem, 1, False, lambda *_: None), problem, (None,))
            for p, true in zip(found.parameters, beta, strict=True):
                known = re.match(r"known to ([\d.]+) %", p.verdict)
                low, high = (np.nan if end is None else end for end in (p.low, p.high))
                yield {
                    "generator": generator,
                    "kind": kind,
                    "arm": k,
                    "method": name,
                    "parameter": p.name,
                    "true": true,
                    "estimate": p.estimate,
                    "low": low,
                    "high": high,
                    "known": float(known.group(1)) / 100.0 if known else np.nan,
                }


def wilson(share: float, n: int) -> tuple[float, float]:
    """Wilson score interval of a share of n."""
    middle = (share + Z**2 / (2 * n)) / (1 + Z**2 / n)
    half = Z / (1 + Z**2 / n) * np.sqrt(share * (1 - share) / n + Z**2 / (4 * n**2))
    return middle - half, middle + half


def coverage(rows: pd.DataFrame, names: tuple[str, ...]) -> tuple[float, float, float]:
    """Share of an arm's intervals that contain the truth, mean over arms, and its Wilson interval."""
    asserted = rows[rows.parameter.isin(names) & rows.low.notna()]
    inside = (asserted.low <= asserted.true) & (asserted.true <= asserted.high)
    arms = inside.groupby(asserted.arm).mean()
    return float(arms.mean()), *wilson(float(arms.mean()), len(arms))


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """One line for each method, generator and kind, in percent."""
    groups = {"inertia and gravity": NAMES[:5], "friction": NAMES[5:], "all nine": NAMES}
    lines = []
    for (method, generator, kind), part in rows.groupby(["method", "generator", "kind"], sort=False):
        line = {"method": method, "generator": generator, "kind": kind, "arms": part.arm.nunique()}
        half = 0.5 * (part.high - part.low) / part.true.abs()
        for title, names in groups.items():
            share = coverage(part, names)
            shares = dict(zip(("", " low", " high"), share, strict=True))
            line |= {f"{title}{word}": round(100.0 * value, 1) for word, value in shares.items()}
            line[f"{title} half width"] = round(100.0 * float(half[part.parameter.isin(names)].median()), 2)
        known = part[part.known.notna()]
        off = (known.estimate - known.true).abs() > known.known * known.estimate.abs()
        lines.append(line | {"known to x %": len(known), "off by more": int(off.sum())})
    return pd.DataFrame(lines).sort_values(["method", "generator"], kind="stable", ascending=[False, True])


def markdown(table: pd.DataFrame) -> str:
    """The table with coverage and its interval in one cell."""
    heads = [
        *("method", "generator", "unmodelled effect", "inertia and gravity, %", "all nine, %"),
        *("known to x %", "off by more", "half width of inertia and gravity, %", "of friction, %"),
    ]
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for row in table.to_dict("records"):
        cells = [row["method"], row["generator"], row["kind"]]
        for name in ("inertia and gravity", "all nine"):
            cells.append(f"{row[name]:.0f} ({row[name + ' low']:.0f} to {row[name + ' high']:.0f})")
        cells += [row["known to x %"], row["off by more"]]
        cells += [f"{row[name + ' half width']:.2g}" for name in ("inertia and gravity", "friction")]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write the table of coverage as CSV and Markdown, and every interval as CSV."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, default=30)
    parser.add_argument("--out", type=Path, default=ROOT / "benchmarks" / "results")
    parser.add_argument("--kind", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--generator", nargs="+", choices=tuple(GENERATORS), default=tuple(GENERATORS))
    args = parser.parse_args()
    rows = pd.DataFrame(
        row for generator in args.generator for kind in args.kind for row in rows_of(generator, kind, args.arms)
    )
    args.out.mkdir(parents=True, exist_ok=True)
    table = summary(rows)
    rows.to_csv(args.out / "intervals.csv", index=False, float_format="%.6g")
    table.to_csv(args.out / "interval_coverage.csv", index=False)
    (args.out / "interval_coverage.md").write_text(markdown(table), encoding="utf-8")
    print(markdown(table))


if __name__ == "__main__":
    main()
