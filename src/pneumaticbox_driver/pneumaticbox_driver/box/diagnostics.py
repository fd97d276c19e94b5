"""Diagnostics of the box (REP-107): reports for /diagnostics and the counts behind them."""

import math
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np

from pneumaticbox_driver.arrays import Counts, Flags
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.modes import MODES
from softhand_common.status import Level, Report

NOTE_PERIOD = 5.0  # between two logs of the same note [s]
STORM_RATE = 500.0  # rate of commands above which there is a warning [1/s]
RATE_WINDOW = 0.2  # over which this rate is computed [s]
STORM_MEMORY = 10.0  # duration of this warning [s]
ACTIVITY_WINDOW = 10.0  # of node time, over which openings of valves are counted [s]
COUNT_SPACING = 0.5  # between two stored counts [s]
CHATTER = 5.0  # rate of openings; a 45 ms pulse and a 60 ms pause allow nearly twice that [1/s]
SPEAKER_MEMORY = 5.0  # wall time for which a node counts as a commander after a command [s]
REFUSAL_MEMORY = 10.0  # wall time of the warning about a refused message [s]
STALE_CLOCK = 5.0  # wall time after which a clock without progress causes a warning [s]


class NoteThrottle:
    """Passes each note on at most once in NOTE_PERIOD.

    >>> throttle = NoteThrottle()
    >>> throttle.due(["tared", "tared"], 0.0), throttle.due(["tared"], 4.9)
    (['tared'], [])
    >>> throttle.due(["tared"], 5.0)
    ['tared']
    """

    def __init__(self) -> None:
        self._logged: dict[str, float] = {}

    def due(self, notes: Iterable[str], now: float) -> list[str]:
        """Notes to log at this monotonic time [s], in their order."""
        recent = {note: at for note, at in self._logged.items() if now - at < NOTE_PERIOD}
        due = [note for note in dict.fromkeys(notes) if note not in recent]
        self._logged = recent | dict.fromkeys(due, now)
        return due


@dataclass
class CommandTraffic:
    """Counts command messages; times are of a monotonic clock [s].

    `taken` counts the processed messages, `lost` those that were overwritten in the queue, which
    can be counted only for a single commander. `commanders` is the number of nodes that have sent
    commands in the last SPEAKER_MEMORY.

    ROS does not name the sender of a message, but numbers the messages of each publisher: a number
    that is not larger than the last ones of all known publishers comes from another publisher.

    >>> traffic = CommandTraffic()
    >>> for sequence in (7, 8, 1, 9, 2):
    ...     traffic.note(0.0, "command", sequence, lambda: 2)
    >>> traffic.speakers(4.9), traffic.speakers(5.1)
    (2, 0)
    """

    taken: int = 0
    lost: int = 0
    commanders: int = 0
    _sequences: dict[str, int] = field(default_factory=dict)
    _speakers: list[tuple[str, int, float]] = field(default_factory=list)  # topic, number, time
    _recent: deque[tuple[float, int]] = field(default_factory=deque)
    _peak: float = 0.0
    _peak_at: float = -STORM_MEMORY

    def note(self, now: float, topic: str, sequence: int, commanders: Callable[[], int]) -> None:
        """Count a message.

        Args:
            now: present time [s].
            topic: topic of the message.
            sequence: number of the message among those of its publisher.
            commanders: returns the number of publishers of the topic.
        """
        missing = sequence - self._sequences.get(topic, sequence) - 1
        # the numbers of two publishers alternate and show no losses
        missing = missing if missing > 0 and commanders() == 1 else 0
        self._sequences[topic] = sequence
        self._note_speaker(now, topic, sequence)
        self.taken += 1
        self.lost += missing
        self._recent.append((now, 1 + missing))
        self._watch(now)

    def _note_speaker(self, now: float, topic: str, sequence: int) -> None:
        before = [each for each in self._speakers if each[0] == topic and each[1] < sequence]
        if before:
            self._speakers.remove(max(before))
        recent = [each for each in self._speakers if now - each[2] < SPEAKER_MEMORY]
        self._speakers = [*recent, (topic, sequence, now)]

    def speakers(self, now: float) -> int:
        """Number of nodes that have sent commands recently: the larger number of the two topics."""
        topics = [topic for topic, _, time in self._speakers if now - time < SPEAKER_MEMORY]
        return max(map(topics.count, topics), default=0)

    def _watch(self, now: float) -> None:
        while now - self._recent[0][0] > RATE_WINDOW:
            self._recent.popleft()
        rate = sum(number for _, number in self._recent) / RATE_WINDOW
        if rate > STORM_RATE and rate > self.storm(now):
            self._peak, self._peak_at = rate, now

    def storm(self, now: float) -> float:
        """Highest recent rate of commands above STORM_RATE [1/s]; 0 for none."""
        return self._peak if now - self._peak_at < STORM_MEMORY else 0.0


class ValveActivity:
    """Counts openings of valves within a window of the box's time.

    Args:
        channels: number of channels.

    >>> activity = ValveActivity(2)
    >>> for second in range(30):
    ...     activity.note(float(second), np.array([second, 6 * second]))
    >>> activity.recent, activity.chatters
    (array([10, 60]), array([False,  True]))
    """

    def __init__(self, channels: int) -> None:
        self._none: Counts = np.zeros(channels, dtype=np.int64)
        self._counts: deque[tuple[float, Counts]] = deque()

    def note(self, time: float, openings: Counts) -> None:
        """Add the total openings (n,) at the box's `time` [s]; time set back clears the counts."""
        if math.isnan(time):
            return  # no sample has come yet
        counts = self._counts
        if counts and time < counts[-1][0]:
            counts.clear()
        if counts and time - counts[-1][0] < COUNT_SPACING:
            return
        counts.append((time, openings.copy()))
        while len(counts) > 1 and time - counts[1][0] >= ACTIVITY_WINDOW:
            counts.popleft()

    @property
    def recent(self) -> Counts:
        """Openings within the window (n,)."""
        if not self._counts:
            return self._none
        return np.asarray(self._counts[-1][1] - self._counts[0][1])

    @property
    def chatters(self) -> Flags:
        """Channels whose valve opens more often than any target requires (n,)."""
        return np.asarray(self.recent > CHATTER * ACTIVITY_WINDOW)


@dataclass
class LinkState:
    """State of the node's connections.

    `refused` is the reason for which the last message was refused, "" after a valid one, after
    enable or reset, or after some time; `refusals` counts refused messages. `simulators` is the
    number of nodes that publish sensor samples. `clock_stands` [s] is the time for which the node's
    clock has not advanced, `clock_warning` another warning about the clock, `second` a warning
    about another driver. `storm` [1/s] is the recent rate of commands if too high, `traffic` counts
    commands.
    """

    refused: str = ""
    refusals: int = 0
    samples: int = 0
    sensors_seen: bool = False
    paused: bool = False
    clock_stands: float = 0.0
    simulators: int = 1
    clock_warning: str = ""
    second: str = ""
    storm: float = 0.0
    traffic: CommandTraffic = field(default_factory=CommandTraffic)
    _refused_at: float = 0.0

    def refuse(self, reason: str, now: float) -> None:
        """Note a refused message at this monotonic wall time [s]."""
        self.refused, self._refused_at = reason, now
        self.refusals += 1

    def accept(self) -> None:
        """Clear the warning: a valid message has arrived, or the user has called a service."""
        self.refused = ""

    def forget_refused(self, now: float) -> None:
        """Clear the warning if it is old at this monotonic wall time [s]."""
        if now - self._refused_at > REFUSAL_MEMORY:
            self.refused = ""


def box_reports(box: PneumaticBox, link: LinkState, activity: ValveActivity) -> list[Report]:
    """Reports on sensors, safety, commands and each channel."""
    names = box.settings.channels
    channels = [_channel(box, activity, i, name) for i, name in enumerate(names)]
    return [_sensors(box, link), _safety(box), _commands(box, link), *channels]


def _sensors(box: PneumaticBox, link: LinkState) -> Report:
    report = Report("sensors", values={"samples": str(link.samples)})
    if not link.sensors_seen:
        report.raise_to(Level.WARN, "no sensor sample has come yet")
    elif not box.zeroing.ready:
        report.raise_to(Level.WARN, "averaging the sensors before the first command")
    if link.clock_stands > STALE_CLOCK and not link.paused:
        report.raise_to(Level.WARN, "use_sim_time is set but /clock does not advance")
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
        report.values["supply pressure, absolute [Pa]"] = f"{box.supply_abs:.0f}"
    return report


def _safety(box: PneumaticBox) -> Report:
    report = Report("safety", message="in operation")
    if box.latch:
        reasons = "; ".join(box.latch.reasons)
        report.raise_to(Level.ERROR, f"vented until pneumaticbox/reset: {reasons}")
    elif not box.enabled:
        report.raise_to(Level.WARN, "disabled: valves are closed")
    for sentence in box.faults.stuck_outlets():
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
        "control modes": ", ".join(box.control.modes),
    }
    if link.second:
        report.raise_to(Level.WARN, link.second)
    if link.refused:
        report.raise_to(Level.WARN, f"refused {link.refused}")
    if traffic.commanders > 1:
        count = "two" if traffic.commanders == 2 else traffic.commanders
        report.raise_to(Level.WARN, f"{count} nodes command the box: the latest command wins")
    if link.storm:
        report.raise_to(
            Level.WARN, f"command storm: {link.storm:.0f} messages a second, the newest are taken"
        )
    return report


def _channel(box: PneumaticBox, activity: ValveActivity, index: int, name: str) -> Report:
    report = Report(f"channel {name}")
    if box.guard.relieving[index]:
        report.raise_to(Level.WARN, "above its pressure limit: relieving")
    elif box.guard.blocked[index] or box.control.saturated[index]:
        report.raise_to(Level.WARN, "target is beyond the pressure limit: held below it")
    recent = int(activity.recent[index])
    if activity.chatters[index]:
        report.raise_to(Level.WARN, f"valve chatters: opened {recent} times within 10 s")
    if untrue := box.estimates.sentence(index):
        report.raise_to(Level.WARN, untrue)
    mode = MODES[box.control.modes[index]]
    target = box.commands.setpoints.at(box.time)[index]
    report.values = {
        "mode": mode.name,
        "air mass [kg]": f"{box.observer.mass[index]:.3e}",
        f"target [{mode.unit}]": f"{target:.3e}",
        "pressure, gauge [Pa]": f"{box.pressures[index]:.0f}",
        "drift bound, two sigma [kg]": f"{box.zeroing.drift_bound[index]:.1e}",
        "volume above rest [m3]": f"{box.volume[index]:.2e}",
        "limit, gauge [Pa]": f"{box.guard.limits[index]:.0f}",
        "sensor offset [Pa]": f"{box.zeroing.offsets[index]:.0f}",
        "valve": {1: "inflate", 0: "closed", -1: "deflate"}[int(box.valves[index])],
        "openings": str(int(box.openings[index])),
        "openings within 10 s": str(recent),
    }
    return report
