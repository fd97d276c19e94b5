"""Fibres and rubbers: Tables 3.1 and 3.2, and what the text concludes from them (3.3).

Nothing is simulated: tables and claims are computed again from the material data.
"""

from collections.abc import Sequence

import numpy as np

from softhand_design.fibre import load_fibres, radial_modulus, radial_stretch, thinner
from softhand_design.rubber_choice import highest, wall_for_stiffness
from softhand_model.hand.rubber import load_rubbers
from thesis.frame import Figure, Finding, Job, NoParameters, Report, Results

SIZE = (6.5, 4.0)
SOFT_SILICONE, AXIAL_STRETCH = 0.15e6, 3.0  # [Pa], [-], of Table 3.1
PRINTED_FIBRES = {  # E_radial [MPa], radial stretch [-]
    "no fibres": (0.15, 3.0),
    "stiff silicone": (0.177, 2.70),
    "PET": (50.0, 1.006),
    "HD-PE": (2300.0, 1.000),
}
PRINTED_INDICES = {
    "Dragon Skin 10": 26.6,
    "Dragon Skin 20": 20.2,
    "Dragon Skin 30": 13.5,
    "Ecoflex 00-30": 19.7,
    "Ecoflex 00-50": 22.5,
    "Elastosil M4125": 23.5,
    "TangoBlack+ FLX980 stiff": 8.0,
    "TangoBlack+ FLX980 soft": 8.6,
}
LAST_DIGITS = {0.15: 0.005, 0.177: 0.0005, 50.0: 1.0, 2300.0: 50.0, 3.0: 0.05}
LAST_DIGITS |= {1.006: 0.0005, 1.000: 0.0005}
ERRATA = {"stiff silicone": " (erratum: 2.69)"}  # whose last digit is not that of eq. 3.3
CURVATURE, STIFFNESS = 100.0, 4e-3  # [1/m], [N m2]: their size cancels in the claims
SKIN, TIN_CURE = "Dragon Skin 10", "Elastosil M4125"
LARGEST_WALL_SHARE = 0.5  # d/h (eq. 3.6)
PLACES = {  # of names in the figure, beside their points [pt]
    "Ecoflex 00-30": (5, -12),
    "Ecoflex 00-50": (-25, 8),
    "TangoBlack+ FLX980 stiff": (-25, -14),
}


def run(given: NoParameters, job: Job) -> Results:
    """Both tables, and both rubbers at the height at which they are stretched to their limit."""
    fibres, rubbers = load_fibres(), load_rubbers()
    moduli = {"no fibres": SOFT_SILICONE, **fibres.moduli}
    radial = {
        name: radial_modulus(SOFT_SILICONE, modulus, fibres.share)
        for name, modulus in moduli.items()
    }
    stretch = {
        name: radial_stretch(AXIAL_STRETCH, SOFT_SILICONE, modulus)
        for name, modulus in radial.items()
    }
    widths = [thread.width for thread in fibres.threads.values()]
    heights = {name: highest(CURVATURE, rubbers[name].max_stretch) for name in (SKIN, TIN_CURE)}
    walls = {
        name: wall_for_stiffness(STIFFNESS, height, rubbers[name].shear_modulus)
        for name, height in heights.items()
    }
    return {
        "fibres": {name: [radial[name] / 1e6, stretch[name]] for name in moduli},
        "indices": {name: rubber.suitability for name, rubber in rubbers.items()},
        "diameter": thinner(fibres.moduli["HD-PE"], fibres.moduli["PET"]),
        "stress": float(np.sqrt(max(widths) / min(widths))),
        "height": heights[TIN_CURE] / heights[SKIN],
        "wall": walls[TIN_CURE] / walls[SKIN],
    }


def report(results: Results, given: NoParameters) -> Report:
    """A row a line of the tables, then the claims."""
    fibres = [
        Finding(
            f"{name}: E radial, radial stretch",
            f"{printed[0]:g} MPa, {printed[1]:.3f}",
            "{:.4g} MPa, {:.3f}".format(*results["fibres"][name]) + ERRATA.get(name, ""),
            None if name in ERRATA else _in_print(results["fibres"][name], printed),
        )
        for name, printed in PRINTED_FIBRES.items()
    ]
    indices = [
        Finding(
            f"index of {name}",
            f"{printed:.1f}",
            f"{results['indices'][name]:.1f} kPa^0.25",
            bool(round(results["indices"][name], 1) == printed),
        )
        for name, printed in PRINTED_INDICES.items()
    ]
    return Report([*fibres, *indices, *_claims(results)], _conclusion(results))


def _in_print(found: Sequence[float], printed: Sequence[float]) -> bool:
    """Whether values agree with the printed ones in all printed digits."""
    return all(abs(a - b) <= LAST_DIGITS[b] for a, b in zip(found, printed, strict=True))


def _claims(results: Results) -> list[Finding]:
    """Conclusions of the text, and whether each follows from its own equations."""
    indices, height, wall = results["indices"], results["height"], results["wall"]
    worse = indices[SKIN] / indices["TangoBlack+ FLX980 soft"]
    ratio = 1.0 / results["diameter"]
    return [
        Finding(
            "HD-PE in place of PET at equal stiffness",
            "40 times thinner",
            f"diameter {ratio:.1f} times, cross section {ratio**2:.0f} times smaller (erratum)",
        ),
        Finding(
            "stress that the mesh allows over that of the thread",
            "as thin as possible",
            f"{results['stress']:.2f} times",
        ),
        Finding(
            "printed rubber against Dragon Skin 10",
            "3 times less curvature or 81 times less stiffness",
            f"{worse:.1f} times less or {worse**4:.0f} times",
            bool(2.5 < worse < 3.5),
        ),
        Finding(
            "Elastosil M4125: height",
            "45 % less",
            f"{100 * (1 - height):.0f} % less (with the stretch 6.5)",
            bool(abs(height - 0.55) < 0.005),
        ),
        Finding(
            "Elastosil M4125: rubber",
            "3.5 times less",
            f"{1 / (height * wall):.1f} times less, as the wall is {wall:.2f} of it (erratum)",
        ),
        Finding(
            "Elastosil M4125: wall over height",
            "-",
            f"{wall / height:.2f} times that of Dragon Skin 10, which must be below "
            f"{LARGEST_WALL_SHARE * height / wall:.2f}",
        ),
    ]


def _conclusion(results: Results) -> str:
    return (
        "Both tables come out but for the last digit of stiff silicone's stretch (2.69 for 2.70). "
        f"Rubber falls {1 / (results['height'] * results['wall']):.1f} times with Elastosil M4125, "
        "not 3.5 times."
    )


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Largest stretch over shear modulus, with lines of equal index."""
    axes = figure.subplots()
    modulus = np.geomspace(20.0, 1200.0, 100)
    for index in (8, 15, 20, 26.6):
        stretch = 1.0 + index / modulus**0.25
        axes.plot(modulus, stretch, color="0.75", lw=1)
        axes.annotate(f"S = {index:g}", (1.05 * modulus[-1], stretch[-1]), fontsize=8, color="0.4")
    for name, rubber in load_rubbers().items():
        place = rubber.shear_modulus / 1e3, rubber.max_stretch
        axes.plot(*place, "o", color="C0")
        offset = PLACES.get(name, (5, 5))
        axes.annotate(name, place, xytext=offset, textcoords="offset points", fontsize=8)
    axes.set(xscale="log", xlabel="shear modulus [kPa]", ylabel="largest stretch [-]")
    axes.set(xlim=(20, 2500), ylim=(1, 13))
