"""Warning when pressure would bend joints beyond their stops, to which the simulator limits
them."""

from __future__ import annotations

import warnings

import numpy as np

from pneuflex_sim.hand.layout import HandLayout
from softhand_common.numerics.arrays import Array
from softhand_model.chain.chain import ChainModel, discretise
from softhand_model.dynamics.joint_springs import STOP_ANGLE

# times the largest pressure limit, where the tables of the rest shape end
SEARCHED_PRESSURE_SHARE = 3.0
FULL_TURN = 2.0 * np.pi  # [rad] of a whole finger, beyond which it would pass through itself
PRESSURE_TOLERANCE = 1.0  # [Pa] of the pressure that is sought


class JointStops:
    """The stops of a hand's joints: no pressure turns the rest of a joint beyond STOP_ANGLE.

    Effects of the model file that are not in the rest tables are left out here.

    Attributes:
        lowest: gauge pressure [Pa] in all channels at which the first joint reaches its stop;
            infinite where none does.
        warning: the warning once it was given, else empty.
    """

    def __init__(self, layout: HandLayout) -> None:
        self._layout, hand = layout, layout.description
        self._channels = {
            chain.name: [hand.channel_of(name) for name in chain.actuators] for chain in hand.chains
        }
        self.lowest, self.warning = self._lowest_pressure(), ""

    def _lowest_pressure(self) -> float:
        hand = self._layout.description
        low, high = 0.0, SEARCHED_PRESSURE_SHARE * float(hand.max_pressures().max())
        if self._farthest(np.full(len(hand.channels), high))[0] <= STOP_ANGLE:
            return float("inf")
        while high - low > PRESSURE_TOLERANCE:
            middle = (low + high) / 2.0
            beyond = self._farthest(np.full(len(hand.channels), middle))[0] > STOP_ANGLE
            low, high = (low, middle) if beyond else (middle, high)
        return low

    def _farthest(self, pressures: Array) -> tuple[float, str, int]:
        """Largest bend [rad] that pressures (channels,) [Pa] ask for, with its chain and joint."""
        found = []
        for name, fed in self._channels.items():
            asked = np.abs(self._layout.models[name].rest_rotation(pressures[fed])).max(axis=1)
            found.append((float(asked.max()), name, int(asked.argmax())))
        return max(found)

    def _curled(self, pressures: Array) -> str:
        """A clause on fingers that pressures (channels,) [Pa] would bend by more than a turn; empty
        without any.
        """
        bends = {
            name: np.abs(self._layout.models[name].rest_rotation(pressures[fed]).sum(axis=0)).max()
            for name, fed in self._channels.items()
        }
        name = max(bends, key=lambda one: float(bends[one]))
        if bends[name] <= FULL_TURN:
            return ""
        return (
            f"; {name} would bend by {np.degrees(bends[name]):.0f} deg from base to tip, through "
            "itself, which is not simulated: do not believe its shape, its swings and what it "
            "touches; take less pressure or a shorter finger"
        )

    def look(self, pressures: Array) -> None:
        """Warn once (RuntimeWarning) when gauge pressures (channels,) [Pa] would bend a joint
        beyond its stop.
        """
        highest = max(pressures.tolist())  # a list is quicker, and this is asked in every step
        if self.warning or highest <= self.lowest:
            return
        asked, chain, joint = self._farthest(pressures)
        if asked > STOP_ANGLE:
            words = self._words(asked, chain, joint, pressures)
            self.warning = words + self._curled(pressures)
            warnings.warn(self.warning, RuntimeWarning, stacklevel=4)

    def _words(self, asked: float, chain: str, joint: int, pressures: Array) -> str:
        layout, hand, fed = self._layout, self._layout.description, self._channels[chain]
        limits = hand.max_pressures()
        filled = " and ".join(
            f"{pressures[k] / 1e3:.0f} kPa in channel {hand.channels[k]}" for k in sorted(set(fed))
        )
        enough = self.segments_within(chain, np.maximum(pressures, limits))
        return (
            f"joint {layout.names[layout.chain_joints[chain].start + joint]}: {filled} would bend "
            f"it by {np.degrees(asked):.0f} deg, but joints stop at {np.degrees(STOP_ANGLE):.0f} "
            f"deg: beyond, the hand bends and presses too little; with {enough} segments "
            f"instead of {layout.segments} no joint would stop up to {limits[fed].max() / 1e3:.0f} "
            "kPa"
        )

    def segments_within(self, chain: str, pressures: Array) -> int:
        """Least number of segments per actuator with which no joint of a chain reaches its stop at
        pressures (channels,) [Pa].
        """
        description = self._layout.description.chain(chain)
        segments, fed = self._layout.segments, pressures[self._channels[chain]]
        model: ChainModel = self._layout.models[chain]
        while (asked := np.abs(model.rest_rotation(fed)).max()) > STOP_ANGLE:
            segments = max(segments + 1, int(segments * asked / STOP_ANGLE))
            model = discretise(description, segments, model.model)
        return segments
