"""Coverage of the 95 % intervals of `repro identify` by kind of unmodelled effect, for two generators of arms.

Usage: ``python benchmarks/interval_coverage.py [--arms 40] [--out FOLDER] [--kind KIND ...]``; half an hour.
Generator `board` is the simulated board behind its controller, with arms near `board_arms.ARM`. Generator `planar`
(`planar_arms.py`) shares no code with the package. Every kind uses the same arms and motions. A coverage is the mean
over arms of the share of an arm's asserted intervals that contain the truth; its Wilson interval counts arms. The plain
bootstrap resamples the same regression in blocks of the same length, and adds nothing to the spread of the estimates.
"""

import argparse
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path

from repro import contract

contract.hold(os.environ)

import numpy as np
import pandas as pd
import planar_arms

from repro.board.plant import Unmodelled
from repro.fitting.evaluate import evaluate, fit
from repro.fitting.prepare import LoadedLog, Options
from repro.fitting.problem import make_problem
from repro.identification.armfile import Arm
from repro.identification.least_squares import METHODS
from repro.identification.log import Log
from repro.identification.uncertainty import REPLICATES, block_length, resample
from repro.logs.diagnostics import Description
from repro.model.parameters import NAMES

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/examples"))
from board_arms import multisine, random_arms, recorded

SEED = 417
#: Normal quantile of the Wilson intervals and of the plain bootstrap.
Z = 1.96
#: Encoder step and noise of the kind `coarse` over those of the others.
COARSE = 8.0


def planar_logs(kind: str, count: int) -> Iterator[tuple[np.ndarray, Log]]:
    """True parameters and log of each arm of the second generator."""
    for k in range(count):
        rng = np.random.default_rng((SEED, k))
        arm, m = planar_arms.draw_arm(rng), planar_arms.draw_motion(rng)
        q, tau = planar_arms.record(*planar_arms.disturbed(kind, arm, m, rng), rng, COARSE if kind == "coarse" else 1.0)
        yield arm.beta, Log(name=f"planar {k}", t=m.t, q=q, tau=tau)


def board_logs(kind: str, count: int) -> Iterator[tuple[np.ndarray, Log]]:
    """True parameters and log of each arm of the first generator; drift and noise are added to the clean logs."""
    rng = np.random.default_rng(SEED)
    arms, desired = random_arms(count, rng), np.stack([multisine(rng) for _ in range(count)])
    effects, phase = [Unmodelled()] * count, rng.uniform(0.0, 2.0 * np.pi, (count, 2))
    if kind in planar_arms.WAVES:
        low, high, largest = planar_arms.WAVES[kind]
        sizes = rng.uniform(0.02, largest, count) * arms[:, 3]
        effects = [Unmodelled(ripple=(size, 0.5 * size), ripple_cycles=(low + high) // 2) for size in sizes]
    elif kind == "friction":
        effects = [Unmodelled(stribeck=(share, share)) for share in rng.uniform(0.2, 0.5, count)]
    for beta, log in zip(arms, recorded(arms, desired, effects, phase), strict=True):
        q, tau = log.q, log.tau
        if kind == "temperature":
            speed = np.gradient(q, log.t, axis=-1)
            friction = beta[5:7, None] * speed + beta[7:9, None] * np.tanh(20.0 * speed)
            tau = tau + planar_arms.warm_up(log.t, rng) * friction
        if kind == "coarse":
            q, tau = planar_arms.record(q, tau, rng, COARSE)
        yield beta, Log(name=log.name, t=log.t, q=q, tau=tau)


#: Generators of arms, and the kinds of effect that each of them can simulate.
GENERATORS = {
    "board": (board_logs, ("clean", "coarse", "position", "cogging", "friction", "temperature")),
    "planar": (planar_logs, tuple(planar_arms.KINDS)),
}


def rows_of(generator: str, kind: str, count: int, name: str) -> Iterator[dict[str, object]]:
    """One row for each arm and parameter."""
    method, options, logs = METHODS[name], Options((name,), Path("unused")), GENERATORS[generator][0]
    for k, (beta, log) in enumerate(logs(kind, count)):
        problem = make_problem((LoadedLog(log, Description(log.name, ())),), (), Arm(), options)
        fitted, r = fit(method, problem, 1, False, lambda *_: None), problem.without_standstill
        length, rng = block_length(r.tau - r.y @ fitted.estimate.beta, r.h), np.random.default_rng((SEED, k))
        drawn = (r.take(resample(r.t.size, length, rng)) for _ in range(REPLICATES))
        plain = Z * np.std([method.repeat(replicate, fitted.estimate) for replicate in drawn], axis=0, ddof=1)
        for p, true, half in zip(evaluate(fitted, problem, (None,)).parameters, beta, plain, strict=True):
            known = re.match(r"known to ([\d.]+) %", p.verdict)
            yield {
                "generator": generator,
                "kind": kind,
                "arm": k,
                "corrected": bool(problem.logs[0].calibration_errors),
                "parameter": p.name,
                "true": true,
                "estimate": p.estimate,
                "low": np.nan if p.low is None else p.low,
                "high": np.nan if p.high is None else p.high,
                "known": float(known.group(1)) / 100.0 if known else np.nan,
                "plain low": p.estimate - half,
                "plain high": p.estimate + half,
            }


def coverage(rows: pd.DataFrame, kind: str = "") -> dict[str, float]:
    """Mean over arms of the share of intervals that contain the truth, its Wilson interval, and median half width."""
    rows = rows[rows[f"{kind}low"].notna()]
    low, high = rows[f"{kind}low"], rows[f"{kind}high"]
    arms = ((low <= rows.true) & (rows.true <= high)).groupby(rows.arm).mean()
    n, share = max(len(arms), 1), float(arms.mean())
    middle = (share + Z**2 / (2 * n)) / (1 + Z**2 / n)
    wilson = Z / (1 + Z**2 / n) * np.sqrt(share * (1 - share) / n + Z**2 / (4 * n**2))
    width = float((0.5 * (high - low) / rows.true.abs()).median())
    low_end, high_end = max(middle - wilson, 0.0), min(middle + wilson, 1.0)
    values = {"coverage": share, "coverage low": low_end, "coverage high": high_end, "half width": width}
    return {f"{kind}{name}": 100.0 * value for name, value in values.items()}


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """One line for each generator and kind: inertia and gravity in percent, claims of all nine."""
    lines = []
    for (generator, kind), part in rows.groupby(["generator", "kind"], sort=False):
        five, known = part[part.parameter.isin(NAMES[:5])], part[part.known.notna()]
        wrong = (known.estimate - known.true).abs() > known.known * known.estimate.abs()
        refused = five.low.isna().groupby(five.arm).all()
        line = {"generator": generator, "kind": kind, "arms": len(refused), "refused": 100.0 * refused.mean()}
        claims = {"claims": len(known), "wrong claims": int(wrong.sum())}
        claims["corrected"] = int(part.groupby("arm").corrected.first().sum())
        lines.append(line | coverage(five) | claims | coverage(five, "plain "))
    return pd.DataFrame(lines)


def main() -> None:
    """Write the table of coverage, and every interval, as CSV."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, default=40)
    parser.add_argument("--out", type=Path, default=ROOT / "benchmarks" / "results")
    parser.add_argument("--kind", nargs="+", choices=planar_arms.KINDS, default=tuple(planar_arms.KINDS))
    parser.add_argument("--generator", nargs="+", choices=GENERATORS, default=tuple(GENERATORS))
    parser.add_argument("--method", choices=METHODS, default="weighted-consistent")
    args = parser.parse_args()
    cells = [(g, kind) for g in args.generator for kind in args.kind if kind in GENERATORS[g][1]]
    rows = []
    for generator, kind in cells:
        print(f"{generator}, {planar_arms.KINDS[kind]}: {args.arms} arms", file=sys.stderr)
        rows += rows_of(generator, kind, args.arms, args.method)
    rows = pd.DataFrame(rows)
    args.out.mkdir(parents=True, exist_ok=True)
    table = summary(rows)
    rows.to_csv(args.out / "intervals.csv", index=False, float_format="%.6g")
    table.to_csv(args.out / "interval_coverage.csv", index=False, float_format="%.3g")
    print(table.to_string(index=False, float_format="%.3g"))


if __name__ == "__main__":
    main()
