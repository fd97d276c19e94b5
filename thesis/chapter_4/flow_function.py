"""Psi of section 4.4.1 and its approximation, scaled to fit."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softhand_model.gas import CHOKED_PSI, CRITICAL_RATIO, psi, psi_approx
from thesis.chapter_4.report import (
    FULL,
    OTHER,
    THESIS_LINE,
    Metric,
    Progress,
    Report,
    Series,
    option,
    rms,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SENTENCE = "flow function of a choke against its approximation, scaled to fit"
THESIS = "section 4.4.1, RMS error 1.4 %; factor 7.0 printed for 3.5"


@dataclass(frozen=True)
class Settings:
    """Options of the experiment."""

    ratios: int = option(10001, "pressure ratios from 0 to 1, evenly spaced [-]")

    def __post_init__(self) -> None:
        if self.ratios < 2:
            raise ValueError(f"ratios must be at least 2, got {self.ratios}")


def simulate(settings: Settings, seed: int, progress: Progress) -> Series:
    """Both functions over the pressure ratio, and Psi with the factor as it is printed."""
    ratio = np.linspace(0.0, 1.0, settings.ratios)
    exact = psi(ratio)
    return {
        "ratio": ratio,
        "exact": exact,
        "approximation": psi_approx(ratio),
        "printed": np.sqrt(2.0) * exact,
    }


def report(series: Series, settings: Settings) -> Report:
    """Scale of the approximation by least squares, and what then remains."""
    exact, rough = series["exact"], series["approximation"]
    scale = float(exact @ rough / (rough @ rough))
    scaled = 100 * float(rms(exact - scale * rough) / rms(exact))
    unscaled = 100 * float(rms(exact - rough) / rms(exact))
    sonic = float(series["printed"].max())
    metrics = (
        Metric("scale of the approximation", scale, ""),
        Metric("RMS error, scaled to fit", scaled, "%", "1.4 % (0.9 % recomputed)"),
        Metric("RMS error, as printed", unscaled, "%"),
        Metric("Psi at sonic flow, factor 3.5", float(exact.max()), "", f"{CHOKED_PSI}"),
        Metric("Psi at sonic flow, factor 7.0 as printed", sonic, "", f"{CHOKED_PSI}"),
    )
    verdict = (
        f"scaled to fit, the approximation is off by {scaled:.2f} % RMS (thesis: 1.4 %; recomputed "
        f"0.9 %); the printed factor 7.0 would give {sonic:.3f} at sonic flow, not {CHOKED_PSI}"
    )
    return Report(metrics, verdict)


def draw(figure: "Figure", series: Series, result: Report) -> None:
    """Both functions, and what lies between them."""
    left, right = figure.subplots(1, 2)
    ratio, scale = series["ratio"], result["scale of the approximation"]
    rough = scale * series["approximation"]
    left.plot(ratio, series["exact"], color=FULL, label="Psi, factor 3.5")
    left.plot(ratio, rough, color=OTHER, ls="--", label=f"{scale:.3f} sqrt(r (1 - r))")
    left.plot(ratio, series["printed"], color=THESIS_LINE, ls=":", label="as printed, factor 7.0")
    left.axhline(CHOKED_PSI, color=THESIS_LINE, lw=0.8)
    left.annotate("thesis: 0.484", (0.02, CHOKED_PSI), (0, 3), textcoords="offset points")
    left.axvline(CRITICAL_RATIO, color=THESIS_LINE, lw=0.8)
    left.annotate("1/1.894", (CRITICAL_RATIO, 0.02), (3, 0), textcoords="offset points")
    left.set(xlabel="p_out / p_in [-]", ylabel="Psi [-]", ylim=(0, 0.75))
    left.legend(loc="lower left", bbox_to_anchor=(0.0, 0.1))
    size = float(rms(series["exact"]))
    right.plot(ratio, 100 * (rough - series["exact"]) / size, color=FULL)
    for level, words in ((1.4, "thesis: RMS 1.4 %"), (0.9, "recomputed: RMS 0.9 %")):
        right.axhline(level, color=THESIS_LINE, lw=0.8)
        right.axhline(-level, color=THESIS_LINE, lw=0.8)
        right.annotate(words, (0.02, level), (0, 2), textcoords="offset points", color="#555555")
    right.set(xlabel="p_out / p_in [-]", ylabel="error, of the RMS of Psi [%]")
