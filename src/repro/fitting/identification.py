"""What `identify` returns: the estimates of one method, what they predict, and the files that they are written to."""

import html
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from repro.errors import InputError, check_kind
from repro.files import check_folder
from repro.fitting.recommend import unusable
from repro.fitting.result import Curves, MethodResult, Result
from repro.fitting.tables import parameters_table, residuals_table, scores_table
from repro.fitting.text import summary
from repro.identification.armfile import Arm
from repro.identification.extra_terms import values_of
from repro.identification.identified_arm import IdentifiedArm
from repro.model.parameters import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Identification:
    """What `identify` found: the estimates of one method, and how well they predict.

    Attributes
    ----------
    details : repro.fitting.result.Result
        Every number of every method, as ``parameters.json`` contains it.
    method : str
        Method that the properties below refer to: the recommended one, until `of` chooses another.

    Examples
    --------
    >>> import repro
    >>> result = repro.identify("data/captures/T3.bin", method=["ordinary", "bounded"], friction=False)
    >>> result.method
    'bounded'
    >>> bounded = result.of("bounded")
    >>> result.beta.shape, bool((bounded.beta == result.beta).all())
    ((9,), True)
    >>> still = np.zeros((2, 1))
    >>> level = np.array([[np.pi / 2], [0.0]])
    >>> torque = result.predict(level, still, still)
    >>> bool(abs(torque[0, 0] - result.beta[3] - result.beta[4]) < 1e-12)
    True
    >>> t = np.linspace(0.0, 0.1, 11)
    >>> q, dq = result.simulate(t, np.zeros((2, 11)), [0.5, 0.0], [0.0, 0.0])
    >>> q.shape, bool(q[0, -1] < 0.5)
    ((2, 11), True)
    """

    details: Result
    method: str
    _curves: Curves
    _arm: Arm
    _inputs: tuple[Path, ...] = ()
    _load: Array | None = None  # parameters that give the load of friction

    def of(self, method: str) -> "Identification":
        """Give the same result from the viewpoint of another method that was run.

        Parameters
        ----------
        method : str
            Its name, such as ``"bounded"``.

        Raises
        ------
        InputError
            If the method was not run.
        """
        names = [m.method for m in self.details.methods]
        if method not in names:
            raise InputError.at("method", repr(method), f"one of {', '.join(names)}")
        return replace(self, method=method)

    @property
    def _shown(self) -> Result:
        """The details with this method as the recommended one; each log alone was fitted by that one."""
        if self.method == self.details.recommended:
            return self.details
        reason = f"instead of {self.details.best.title}, which is recommended"
        return replace(self.details, recommended=self.method, reason=reason, runs=())

    @property
    def _best(self) -> MethodResult:
        return self._shown.best

    @property
    def beta(self) -> Array:
        """The nine parameters (9,) in the order of Eq. 1, SI units."""
        return np.array([p.estimate for p in self._best.parameters])

    @property
    def parameters(self) -> pd.DataFrame:
        """Estimates with 95 % intervals and verdicts, indexed by the name of the parameter.

        Columns ``unit``, ``estimate``, ``standard_error``, ``low``, ``high`` and ``verdict``. A method that claims no
        intervals has NaN there.
        """
        table = parameters_table(self.details)
        return table[table["method"] == self.method].drop(columns="method").set_index("parameter")

    @property
    def errors(self) -> pd.DataFrame:
        """Errors of the rebuilt torque and of the simulated position.

        Columns ``log``, ``part`` (``"fit"``; ``"half"`` or ``"log"``: predicted from the others; ``"validation"``) and
        ``joint``; ``relative_rms`` of the torque and ``similarity``, fractions of 1;
        ``position_rms``, rad.
        """
        table = scores_table(self.details)
        return table[table["method"] == self.method].drop(columns="method").reset_index(drop=True)

    @property
    def residuals(self) -> pd.DataFrame:
        """Torque that was fitted, rebuilt torque and their difference at each sample of each log and joint, N m.

        The fitted torque is the recorded one, filtered, with calibration errors corrected and less the terms beyond
        Eq. 1 that were subtracted.
        """
        return residuals_table(self._shown, self._curves)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What may be wrong with the logs or with the result."""
        return self.details.all_warnings

    @property
    def unusable(self) -> str:
        """The reason not to use the parameters of this method; empty if they can be used."""
        return unusable(self._best)

    def predict(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike, log: int | None = None) -> Array:
        """Compute the torque (2, N) that a motion needs, N m: of Eq. 1 and of the terms that were subtracted.

        Parameters
        ----------
        q, dq, ddq : array_like of shape (2, N)
            Position (rad), velocity (rad/s) and acceleration (rad/s^2).
        log : int, optional
            Place of a fitted log: the motion is as this log records it, and so is the torque, with the calibration
            errors that were corrected there. By default angles and torques are those of Eq. 1.

        Raises
        ------
        ValueError
            If shapes differ or a value is not finite.
        InputError
            If there is no such log.
        """
        calibration = dict[str, float]()
        if log is not None:
            n = len(self.details.fitted_logs)
            if log not in range(-n, n):
                raise InputError.at("log", repr(log), f"a number from 0 to {n - 1}")
            errors = self.details.calibration_errors
            calibration = values_of(errors[log]) if errors else {}
        return replace(self._identified, calibration=calibration).torque(q, dq, ddq)

    @property
    def _identified(self) -> IdentifiedArm:
        terms, s = [term for term in self.details.terms if term.taken], self.details.preparation
        return IdentifiedArm(self.beta, s.friction_steepness, terms, self._load, stribeck_speed=s.stribeck_speed)

    def simulate(self, t: ArrayLike, tau: ArrayLike, q0: ArrayLike, dq0: ArrayLike) -> tuple[Array, Array]:
        """Integrate Eq. 1, with the terms that were subtracted, under a torque that is linear between samples.

        Parameters
        ----------
        t : array_like of shape (N,)
            Instants, s, that increase.
        tau : array_like of shape (2, N)
            Torque at these instants, N m.
        q0, dq0 : array_like of shape (2,)
            Position (rad) and velocity (rad/s) at the first instant.

        Returns
        -------
        q, dq : arrays of shape (2, N)
            Position and velocity at each instant.

        Raises
        ------
        ValueError
            If the inertia matrix is not positive definite in every pose, a shape is wrong, or a value is not finite.
        """
        return self._identified.simulate(t, tau, q0, dq0)

    def plot(self, log: int = 0) -> "Figure":
        """Draw measured and rebuilt torque of a log, with the residual below.

        Parameters
        ----------
        log : int
            Place of the log: those that were fitted, then those to validate.

        Returns
        -------
        matplotlib.figure.Figure
            To show or to save.

        Raises
        ------
        InputError
            If there is no such log.
        """
        from repro.drawing.style import house_style  # noqa: PLC0415  (a fit alone needs no drawing)
        from repro.fitting.figures import draw_overlay  # noqa: PLC0415

        n = len(self._curves.signals)
        if log not in range(-n, n):
            raise InputError.at("log", repr(log), f"a number from 0 to {n - 1}")
        with house_style():
            return draw_overlay(self._curves.signals[log], {self.method: self._best.title}, self.details.simulated)

    def save(self, folder: str | Path, overwrite: bool = False) -> list[str]:
        """Write parameters, scores, residuals, report and models of the arm, by the recommended method.

        Parameters
        ----------
        folder : path
            New, or empty, or that of an earlier result.
        overwrite : bool
            Whether files with the names of these may be replaced.

        Returns
        -------
        list of str
            Names of the files.

        Raises
        ------
        InputError
            If the folder contains files and `overwrite` is not given, or cannot be written, or `of` chose another
            method than the recommended one.
        """
        from repro.fitting.outputs import write_result  # noqa: PLC0415

        check_kind("folder", folder, (str, Path), "a path")
        check_kind("overwrite", overwrite, bool, "True or False")
        if self.method != self.details.recommended:
            expected = f"the recommended {self.details.recommended!r}, or identify(..., method={self.method!r})"
            raise InputError.at("method", repr(self.method), expected)
        check_folder(Path(folder), overwrite)
        return write_result(Path(folder), self.details, self._curves, self._arm, self._inputs)

    def __str__(self) -> str:
        return summary(self._shown)

    def __repr__(self) -> str:
        numbers = ", ".join(f"{p.name}={p.estimate:.4g}" for p in self._best.parameters)
        return f"Identification({self.details.log.name!r}, method={self.method!r}, {numbers})"

    def _repr_html_(self) -> str:
        """Show the parameters and the warnings in a notebook."""
        simulated = " (simulated)" if self.details.simulated else ""
        title = html.escape(f"{self.details.arm}{simulated}: {self._best.title}")
        lines = "".join(f"<li>{html.escape(line)}</li>" for line in self.warnings)
        table = self.parameters.to_html(float_format=lambda x: f"{x:.4g}", na_rep="")
        return f"<p><b>{title}</b></p>{table}{lines and f'<ul>{lines}</ul>'}"
