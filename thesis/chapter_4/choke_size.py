"""Size of the chokes against speed and smallest step of mass (section 4.3).

The thesis: chokes set the flow over two orders of magnitude; without them a hand fills in 0.25 s.
"""

from dataclasses import dataclass, replace

import numpy as np

from pneumaticbox_driver.backends.embedded import EmbeddedRig
from softhand_model.chain.volumes import FreeActuators
from softhand_model.hand.hand import load_hand
from softhand_model.pneumatics import Pneumatics
from thesis.chapter_4 import FULL, MG, NOTE, OTHER, SEED, THESIS_LINE
from thesis.chapter_4.boxes import PERIOD, box_of, inlet_flows, smallest_steps
from thesis.frame import Figure, Job, Report, Results, number, option

SMALLEST_PULSE = 0.045  # of the box [s]
FULL_HAND = 0.9  # of the pressure limit on every channel
LONGEST = 60.0  # to fill a hand [s]
UNCHOKED = 5e-3  # wider than the valve itself [m]
SMALL = {"diameters": (0.2e-3, 0.4e-3), "channels": 1}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    seed: int = option(0, SEED)
    diameters: tuple[float, ...] = option(
        (0.1e-3, 0.2e-3, 0.3e-3, 0.45e-3, 0.7e-3, 1e-3), "inlet chokes, ascending [m]"
    )
    channels: int = option(4, "outlets of the box, those of RBO Hand 2 [-]")

    def __post_init__(self) -> None:
        if len(self.diameters) < 2 or not all(d > 0 for d in self.diameters):
            raise ValueError(f"diameters must be 2 or more above 0 m, got {self.diameters}")


def run(given: Parameters, job: Job) -> Results:
    """Flow, smallest inflation and time to fill a hand for each choke, and for none at all."""
    box, n = box_of(given.seed), given.channels
    rows = []
    sizes = [*given.diameters, UNCHOKED]
    for k, diameter in enumerate(sizes):
        choked = with_choke(box, diameter)
        steps = smallest_steps(choked, n, SMALLEST_PULSE, given.seed)
        flow = inlet_flows(choked, n, given.seed)
        rows.append([diameter, flow.mean(), steps[0].mean(), steps[1].mean(), fill_time(choked)])
        job.progress("chokes", (k + 1) / len(sizes))
    names = ("diameter", "flow", "inflation", "deflation", "fill_time")
    return dict(zip(names, np.array(rows).T, strict=True))


def with_choke(box: Pneumatics, diameter: float) -> Pneumatics:
    """The box with this inlet choke, and an outlet choke in the preset's ratio to it."""
    ratio = box.choke.outlet_diameter / box.choke.inlet_diameter
    choke = replace(box.choke, inlet_diameter=diameter, outlet_diameter=ratio * diameter)
    return replace(box, choke=choke)


def fill_time(box: Pneumatics) -> float:
    """Time to bring every channel of RBO Hand 2 to 90 % of its pressure limit [s].

    All inlets open at once; each closes when its channel has reached its pressure.
    """
    hand = load_hand("rbo_hand_2")
    rig = EmbeddedRig(hand.channels, FreeActuators(hand), box)
    goal = FULL_HAND * hand.max_pressures() + box.ambient_pressure
    reached = np.zeros(len(goal), dtype=bool)
    while not reached.all() and rig.time < LONGEST:
        reached |= rig.plant.pressures >= goal
        rig.command(np.where(reached, 0, 1))
        rig.advance(PERIOD)
    return rig.time if reached.all() else float("nan")


def report(results: Results, given: Parameters) -> Report:
    """Span of the flows, product of step and speed, time to fill an unchoked hand."""
    flow, step = results["flow"], results["inflation"]
    product = 1e3 * step / flow
    findings = [
        number("flow, unchoked / smallest choke", float(flow[-1] / flow[0]), "", "about 100"),
        number("flow, unchoked", slpm(float(flow[-1])), "slpm", "50 to 200"),
        number("time to fill RBO Hand 2, unchoked", float(results["fill_time"][-1]), "s", "0.25"),
    ]
    for k, diameter in enumerate(given.diameters):
        name = f"inlet {1e3 * diameter:g} mm"
        findings += [
            number(f"{name}: flow", float(flow[k]) / MG, "mg/s"),
            number(f"{name}: smallest inflation", float(step[k]) / MG, "mg", _thesis(diameter)),
            number(f"{name}: smallest inflation / flow", float(product[k]), "ms"),
            number(f"{name}: time to fill RBO Hand 2", float(results["fill_time"][k]), "s"),
        ]
    conclusion = (
        f"From {1e3 * given.diameters[0]:g} mm to no choke the flow grows "
        f"{flow[-1] / flow[0]:.0f}-fold (thesis: two orders of magnitude) while step over flow "
        f"stays within {product.min():.0f} to {product.max():.0f} ms (thesis: the product is "
        f"limited by the pulse); an unchoked hand fills in {results['fill_time'][-1]:.2f} s "
        "(thesis: 0.25 s)."
    )
    return Report(findings, conclusion)


def _thesis(diameter: float) -> str:
    return "2.5" if abs(diameter - 0.2e-3) < 1e-9 else "-"


def slpm(flow: float) -> float:
    """A mass flow [kg/s] in standard liters per minute, at 0 C and 1 atm (1.2929 g/l).

    >>> round(slpm(1.2929e-3 / 60), 6)
    1.0
    """
    return flow / 1.2929e-3 * 60


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Smallest step over flow, and the time to fill a hand over the choke's diameter."""
    left, right = figure.subplots(1, 2)
    flow = results["flow"] / MG
    for name, colour in (("inflation", FULL), ("deflation", OTHER)):
        left.loglog(flow, results[name] / MG, "o-", color=colour, label=f"smallest {name}")
    left.axhline(2.5, color=THESIS_LINE, ls="--", lw=1.0)
    left.annotate("thesis: 2.5 mg", (flow[-1], 2.5), (0, -11), ha="right", **NOTE)
    for x, y, size in zip(flow, results["inflation"] / MG, results["diameter"], strict=True):
        label = "no choke" if size >= UNCHOKED else f"{1e3 * size:g} mm"
        left.annotate(label, (x, y), (6, -10), textcoords="offset points", fontsize=7.5)
    left.set(xlabel="flow of an open inlet [mg/s]", ylabel="smallest pulse [mg]")
    left.legend(loc="upper left")
    size = 1e3 * results["diameter"][:-1]
    right.loglog(size, results["fill_time"][:-1], "o-", color=FULL, label="with chokes")
    right.axhline(results["fill_time"][-1], color=OTHER, lw=1.2, label="no choke")
    right.axhline(0.25, color=THESIS_LINE, ls="--", lw=1.0)
    right.annotate("thesis: 0.25 s without chokes", (size[0], 0.25), (0, 4), **NOTE)
    right.set(xlabel="diameter of the inlet choke [mm]", ylabel="time to fill RBO Hand 2 [s]")
    right.legend()
