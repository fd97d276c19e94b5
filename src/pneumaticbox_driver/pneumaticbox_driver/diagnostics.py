"""What the box tells about itself in /diagnostics (REP-107)."""

from dataclasses import dataclass, field

from pneumaticbox_driver.box import PneumaticBox
from pneumaticbox_driver.command_traffic import CommandTraffic
from pneumaticbox_driver.report import Level, Report
from pneumaticbox_driver.valve_activity import ValveActivity

UNITS = {"mass": "kg", "mass_flow": "kg/s", "pressure": "Pa", "volume": "m3", "time": "-"}
REFUSAL_MEMORY = 10.0  # wall time for which a refused message is worth a warning [s]
STALE_CLOCK = 5.0  # wall time after which a clock that stands still is worth a word [s]


@dataclass
class LinkState:
    """What the node knows beyond the box.

    `refused` is the last message that could not be used, "" when that is over: a good one has come
    since, or enable or reset, or it was long ago; `refusals` counts them. `simulators` publish
    sensor samples. `clock_stands` [s] is for how long the node's time has stood still,
    `clock_warning` what else is to be said of the clock. `storm` [1/s] is the rate of commands when
    they have come too fast of late, `traffic` counts them.
    """

    refused: str = ""
    refusals: int = 0
    samples: int = 0
    sensors_seen: bool = False
    paused: bool = False
    clock_stands: float = 0.0
    simulators: int = 1
    clock_warning: str = ""
    storm: float = 0.0
    traffic: CommandTraffic = field(default_factory=CommandTraffic)
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


def box_reports(box: PneumaticBox, link: LinkState, activity: ValveActivity) -> list[Report]:
    """Report sensors, safety, commands and every channel."""
    names = box.settings.channels
    channels = [_channel(box, activity, i, name) for i, name in enumerate(names)]
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
    for sentence in box.stuck_outlets():
        report.raise_to(Level.ERROR, sentence)
    return report


def _commands(box: PneumaticBox, link: LinkState) -> Report:
    traffic = link.traffic
    report = Report("commands")
    report.values = {
        "messages": str(traffic.taken),
        "refused messages": str(link.refusals),
        "lost messages": str(traffic.lost),
        "commanders": str(traffic.commanders),
        "control modes": ", ".join(box.modes),
    }
    if link.refused:
        report.raise_to(Level.WARN, f"refused {link.refused}")
    if traffic.commanders > 1:
        count = "two" if traffic.commanders == 2 else traffic.commanders
        report.raise_to(Level.WARN, f"{count} nodes publish commands: the last one to speak wins")
    if link.storm:
        report.raise_to(
            Level.WARN,
            f"command storm: {link.storm:.0f} messages a second, the newest are taken",
        )
    return report


def _channel(box: PneumaticBox, activity: ValveActivity, index: int, name: str) -> Report:
    report = Report(f"channel {name}")
    if box.guard.relieving[index]:
        report.raise_to(Level.WARN, "above its pressure limit: relieving")
    elif box.guard.blocked[index]:
        report.raise_to(Level.WARN, "target is beyond the pressure limit: held below it")
    recent = int(activity.recent[index])
    if activity.chatters[index]:
        report.raise_to(Level.WARN, f"valve chatters: opened {recent} times within 10 s")
    mode = box.modes[index]
    report.values = {
        "mode": mode,
        "air mass [kg]": f"{box.observer.mass[index]:.3e}",
        f"target [{UNITS[mode]}]": f"{box.setpoints.at(box.time)[index]:.3e}",
        "pressure, gauge [Pa]": f"{box.gauge[index]:.0f}",
        "drift bound, two sigma [kg]": f"{box.drift_bound[index]:.1e}",
        "volume above rest [m3]": f"{box.volume[index]:.2e}",
        "limit, gauge [Pa]": f"{box.guard.limits[index]:.0f}",
        "sensor offset [Pa]": f"{box.offsets[index]:.0f}",
        "valve": {1: "inflate", 0: "closed", -1: "deflate"}[int(box.valves[index])],
        "openings": str(int(box.openings[index])),
        "openings within 10 s": str(recent),
    }
    return report
