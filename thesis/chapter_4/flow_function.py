"""Flow function of a choke against its approximation, scaled to fit (section 4.4.1).

The thesis: RMS error 1.4 %; factor 7.0 printed for 3.5.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.numerics.arrays import Array
from softhand_model.gas import CHOKED_PSI, CRITICAL_RATIO, psi
from thesis.chapter_4 import FULL, NOTE, OTHER, THESIS_LINE, rms
from thesis.frame import Figure, Job, Report, Results, number, option


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    ratios: int = option(10001, "pressure ratios from 0 to 1, evenly spaced [-]")

    def __post_init__(self) -> None:
        if self.ratios < 2:
            raise ValueError(f"ratios must be at least 2, got {self.ratios}")


def psi_approx(ratio: ArrayLike) -> Array:
    """Approximated flow function `sqrt(r (1 - r))`, 0.5 when choked (section 4.4.1).

    ERRATUM: the square root holds for `p_out/p_in > 1/1.894`; the text prints `<`.

    Args:
        ratio: outlet over inlet pressure, absolute [-]; above 1 counts as 1 (no flow).

    Returns:
        Psi [-], from 0 to 0.5.

    >>> [round(float(psi_approx(r)), 4) for r in (0.2, 0.8, 1.0)]
    [0.5, 0.4, 0.0]
    """
    r = np.asarray(ratio, dtype=float)
    below_sonic = np.minimum(r, 1.0)
    root = np.sqrt(np.maximum(below_sonic * (1.0 - below_sonic), 0.0))
    return np.asarray(np.where(r > CRITICAL_RATIO, root, 0.5))


def run(given: Parameters, job: Job) -> Results:
    """Both functions over the pressure ratio, and Psi with the factor as it is printed."""
    ratio = np.linspace(0.0, 1.0, given.ratios)
    exact = psi(ratio)
    return {
        "ratio": ratio,
        "exact": exact,
        "approximation": psi_approx(ratio),
        "printed": np.sqrt(2.0) * exact,
    }


def report(results: Results, given: Parameters) -> Report:
    """Scale of the approximation by least squares, and what then remains."""
    exact, rough = results["exact"], results["approximation"]
    scale = float(exact @ rough / (rough @ rough))
    scaled = 100 * float(rms(exact - scale * rough) / rms(exact))
    unscaled = 100 * float(rms(exact - rough) / rms(exact))
    sonic = float(results["printed"].max())
    findings = (
        number("scale of the approximation", scale, ""),
        number("RMS error, scaled to fit", scaled, "%", "1.4 % (0.9 % recomputed)"),
        number("RMS error, as printed", unscaled, "%"),
        number("Psi at sonic flow, factor 3.5", float(exact.max()), "", f"{CHOKED_PSI}"),
        number("Psi at sonic flow, factor 7.0 as printed", sonic, "", f"{CHOKED_PSI}"),
    )
    conclusion = (
        f"Scaled to fit, the approximation is off by {scaled:.2f} % RMS (thesis: 1.4 %; recomputed "
        f"0.9 %); the printed factor 7.0 would give {sonic:.3f} at sonic flow, not {CHOKED_PSI}."
    )
    return Report(findings, conclusion)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Both functions, and their difference."""
    left, right = figure.subplots(1, 2)
    ratio, scale = results["ratio"], report["scale of the approximation"]
    rough = scale * results["approximation"]
    left.plot(ratio, results["exact"], color=FULL, label="Psi, factor 3.5")
    left.plot(ratio, rough, color=OTHER, ls="--", label=f"{scale:.3f} sqrt(r (1 - r))")
    left.plot(ratio, results["printed"], color=THESIS_LINE, ls=":", label="as printed, factor 7.0")
    left.axhline(CHOKED_PSI, color=THESIS_LINE, lw=0.8)
    left.annotate("thesis: 0.484", (0.02, CHOKED_PSI), (0, 3), textcoords="offset points")
    left.axvline(CRITICAL_RATIO, color=THESIS_LINE, lw=0.8)
    left.annotate("1/1.894", (CRITICAL_RATIO, 0.02), (3, 0), textcoords="offset points")
    left.set(xlabel="p_out / p_in [-]", ylabel="Psi [-]", ylim=(0, 0.75))
    left.legend(loc="lower left", bbox_to_anchor=(0.0, 0.1))
    size = float(rms(results["exact"]))
    right.plot(ratio, 100 * (rough - results["exact"]) / size, color=FULL)
    for level, words in ((1.4, "thesis: RMS 1.4 %"), (0.9, "recomputed: RMS 0.9 %")):
        right.axhline(level, color=THESIS_LINE, lw=0.8)
        right.axhline(-level, color=THESIS_LINE, lw=0.8)
        right.annotate(words, (0.02, level), (0, 2), **NOTE)
    right.set(xlabel="p_out / p_in [-]", ylabel="error, of the RMS of Psi [%]")
