"""What the box tells about itself in /diagnostics (REP-107)."""

from dataclasses import dataclass

from pneumaticbox_driver.box import PneumaticBox
from pneumaticbox_driver.report import Level, Report

UNITS = {"mass": "kg", "mass_flow": "kg/s", "pressure": "Pa", "volume": "m3", "time": "-"}
REFUSAL_MEMORY = 10.0  # wall time for which a refused message is worth a warning [s]
STALE_CLOCK = 5.0  # wall time after which a clock that stands still is worth a word [s]


@dataclass
class LinkState:
    """What the node knows beyond the box.

    `refused` is the last message that could not be used, "" when that is over: a good one has come
    since, or enable or reset, or it was long ago; `refusals` counts them. `simulators` publish
    sensor samples. `clock_stands` [s] is for how long the node's time has stood still,
    `clock_warning` what else is to be said of the clock.
    """

    refused: str = ""
    refusals: int = 0
    samples: int = 0
    sensors_seen: bool = False
    paused: bool = False
    clock_stands: float = 0.0
    simulators: int = 1
    clock_warning: str = ""
    _refused_at: float = 0.0

    def refuse(self, reason: str, now: float) -> None:
        """Remember a message that cannot be used, at this monotonic wall time [s]."""
        self.refused, self._refused_at = reason, now
        self.refusals += 1

    def accept(self) -> None:
        """A good message has come, or the user has set things right."""
        self.refused = ""

    def forget_refused(self, now: float) -> None:
        """Forget the refused message if it came long before this monotonic wall time [s]."""
        if now - self._refused_at > REFUSAL_MEMORY:
            self.refused = ""


def box_reports(box: PneumaticBox, link: LinkState) -> list[Report]:
    """Report sensors, safety, commands and every channel."""
    channels = [_channel(box, i, name) for i, name in enumerate(box.settings.channels)]
    return [_sensors(box, link), _safety(box), _commands(box, link), *channels]


def _sensors(box: PneumaticBox, link: LinkState) -> Report:
    report = Report("sensors", values={"samples": str(link.samples)})
    if not link.sensors_seen:
        report.raise_to(Level.WARN, "no sensor sample has come yet")
    elif not box.ready:
        report.raise_to(Level.WARN, "averaging the sensors before the first command")
    if link.clock_stands > STALE_CLOCK and not link.paused:
        report.raise_to(Level.WARN, "use_sim_time is set but /clock stands still")
    if link.clock_warning:
        report.raise_to(Level.WARN, link.clock_warning)
    if link.simulators > 1:
        report.raise_to(
            Level.WARN,
            f"{'two' if link.simulators == 2 else link.simulators} simulators publish "
            "pneumaticbox/sensors: stop one, or give each its ROS_DOMAIN_ID",
        )
    if link.paused:
        report.values["simulation"] = "paused"
    if link.sensors_seen:
        report.values["supply pressure, absolute [Pa]"] = f"{box.supply:.0f}"
    return report


def _safety(box: PneumaticBox) -> Report:
    report = Report("safety", message="in operation")
    if box.latch:
        reasons = "; ".join(box.latch.reasons)
        report.raise_to(Level.ERROR, f"vented until pneumaticbox/reset: {reasons}")
    elif not box.enabled:
        report.raise_to(Level.WARN, "disabled: valves are closed")
    return report


def _commands(box: PneumaticBox, link: LinkState) -> Report:
    report = Report("commands", values={"refused messages": str(link.refusals)})
    report.values["control modes"] = ", ".join(box.settings.control_modes)
    if link.refused:
        report.raise_to(Level.WARN, f"refused {link.refused}")
    return report


def _channel(box: PneumaticBox, index: int, name: str) -> Report:
    report = Report(f"channel {name}")
    if box.guard.relieving[index]:
        report.raise_to(Level.WARN, "above its pressure limit: relieving")
    elif box.guard.blocked[index]:
        report.raise_to(Level.WARN, "target is beyond the pressure limit: held below it")
    mode = box.settings.control_modes[index]
    report.values = {
        "air mass [kg]": f"{box.observer.mass[index]:.3e}",
        f"target [{UNITS[mode]}]": f"{box.setpoints.at(box.time)[index]:.3e}",
        "pressure, gauge [Pa]": f"{box.gauge[index]:.0f}",
        "limit, gauge [Pa]": f"{box.guard.limits[index]:.0f}",
        "sensor offset [Pa]": f"{box.offsets[index]:.0f}",
        "valve": {1: "inflate", 0: "closed", -1: "deflate"}[int(box.valves[index])],
    }
    return report
