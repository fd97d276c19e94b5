"""Curvature over pressure: approximation 5.3, rule and exact solution (Fig. 5.5).

And the other rules of chapter 3 against what they stand for.
"""

import numpy as np

from softhand_model.hand import section
from thesis.frame import Array, Figure, Finding, Job, NoParameters, Report, Results

HEIGHT, WALL, MODULUS = 0.02, 0.002, 67e3  # [m, m, Pa]
LARGEST = 5.0  # u = p*h/(8*G*d)
STATED = {0.3: 8.4, 1.5: -1.2, 5.0: 12.0}  # error of 5.3 [%] at u, from the table of errata
THIN = (1.0, 1.0, 0.1, 0.1)  # height, width, wall and side wall over the height


def run(given: NoParameters, job: Job) -> Results:
    """kappa*h over u by the rule 3.32, by 5.3 and exactly (ratio = 1), and single checks."""
    u = np.linspace(0.0, LARGEST, 251)[1:]
    exact = section.free_stretch(2.0 * u) - 1.0
    size = (HEIGHT, HEIGHT, WALL, WALL)
    straight, bent = (
        section.rule_stiffness(HEIGHT, WALL, MODULUS)
        / section.bending_stiffness(curvature, HEIGHT, HEIGHT, WALL, 0.0, MODULUS)
        * 2.0  # without side walls ratio is 2
        / section.side_wall_ratio(HEIGHT, HEIGHT, WALL, 0.0)
        for curvature in (0.0, 1e6)
    )
    return {
        "u": u.tolist(),
        "rule": u.tolist(),
        "printed": (u * section.printed_nonlinearity(u)).tolist(),
        "exact": exact.tolist(),
        "limit": float(section.printed_nonlinearity(1e9)),
        "rule_over_stiffness": [float(straight), float(bent)],
        "ratio": float(section.side_wall_ratio(*THIN)),
        "ratio_integrated": float(section.small_strain_side_wall_ratio(*THIN)),
        "share": float(section.printed_side_wall_share(1.0, 0.1, 0.1)),
        "share_integrated": float(section.side_wall_share(*THIN)),
        "angle": _angle(section.free_curvature, size),
        "angle_printed": _angle(section.free_curvature_printed, size),
    }


def _angle(curvature, size: tuple[float, ...]) -> float:
    """Tip angle [rad] of the 90 mm finger of section 5.2.4 at 31 kPa, G = 73.7 kPa."""
    return 0.09 * float(curvature(31e3, *size, 1.1 * MODULUS))


def _error(results: Results) -> Array:
    return 100.0 * (np.array(results["printed"]) / results["exact"] - 1.0)


def report(results: Results, given: NoParameters) -> Report:
    """Errors of 5.3 at the stated points, and the other checks."""
    error, u, findings = _error(results), np.array(results["u"]), []
    for place, stated in STATED.items():
        value = float(np.interp(place, u, error))
        what, ours = f"error of 5.3 at u = {place:g}", f"{value:+.1f} % (errata: {stated:+g})"
        findings.append(Finding(what, "matches well", ours, abs(value - stated) < 0.5))
    straight, bent = results["rule_over_stiffness"]
    exact, printed = np.degrees([results["angle"], results["angle_printed"]])
    told = {
        key: f"{results[key]:.3f}; integrated {results[f'{key}_integrated']:.3f}"
        for key in ("ratio", "share")
    }
    rule, seen = "rule 3.25 over 3.24, straight and far bent", "over-, then underestimates by 2"
    angle, angles = "tip angle at 31 kPa, constant section", f"exact {exact:.1f}, by 5.2"
    findings += [
        Finding("limit of 5.3 for high pressure", "2", f"{results['limit']:.2f}"),
        Finding(angle, "90 deg (another finger)", f"{angles} {printed:.1f} deg"),
        Finding(rule, f"{seen} (erratum: reversed)", f"{straight:.2f}, {bent:.2f}"),
        Finding("ratio of the side walls at d = 0.1 h", "3.36", told["ratio"]),
        Finding("their share of the stiffness at d = 0.1 h", "3.29", told["share"]),
    ]
    used = error[u <= 1.6]  # the top stretched to 3.3 at most
    conclusion = (
        f"To u = 1.6, the pressure limit of the P10 fingers, eq. 5.3 errs by {used.min():+.0f} to "
        f"{used.max():+.0f} %, most at low pressure; the simulator uses the exact solution."
    )
    return Report(findings, conclusion)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Curves as in Fig. 5.5, and the error of 5.3."""
    left, right = figure.subplots(1, 2)
    u = np.array(results["u"])
    left.plot(u, results["exact"], "k", label="exact")
    left.plot(u, results["printed"], "r", lw=1, label="approximation 5.3")
    left.plot(u, results["rule"], "0.6", lw=1, label="rule 3.32")
    left.set(xlabel="u = p h/(8 G d) [-]", ylabel="kappa h [-]", xlim=(0, None), ylim=(0, None))
    left.legend(fontsize=8)
    right.plot(u, _error(results), "r")
    right.plot(list(STATED), list(STATED.values()), "ko", ms=4, label="errata")
    right.axhline(0.0, color="0.6", lw=1)
    right.set(xlabel="u [-]", ylabel="error of 5.3 [%]", xlim=(0, None))
    right.legend(fontsize=8)
