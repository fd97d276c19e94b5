"""Sets of valve pulses: air that a pulse moves, by eq. 4.1."""

from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from .truth import Truth

AMBIENT = 101.3e3  # [Pa]
GAS = 287.05 * 293.15  # R_s*T [J/kg]
BOTTLE = 0.5e-3  # [m3]
CHOKED = 0.5283


def flow_function(r: np.ndarray) -> np.ndarray:
    """Psi of the pressure ratio p_out/p_in, with the 3.5 of the erratum."""
    r = np.clip(r, CHOKED, 1)
    return np.sqrt(3.5 * (r ** (2 / 1.4) - r ** (2.4 / 1.4)))


def make(rng: np.random.Generator, folder: Path, hidden: bool) -> Truth:
    """Write a set of pulses; hidden is the injector's flow or a delay of the valve."""
    name = str(rng.choice(["injector_flow", "valve_delay"])) if hidden else "nothing"
    c = {"inflate": rng.uniform(0.8e-10, 2e-10), "deflate": rng.uniform(5e-10, 1.2e-9)}
    delay = rng.uniform(0.01, 0.03) if name == "valve_delay" else 0.0
    noise = rng.uniform(0.005, 0.015)
    folder.mkdir(parents=True, exist_ok=True)
    runs = {}
    for protocol, supply in (("low", 2.4e5), ("middle", 3.0e5), ("high", 3.8e5)):
        for repeat in (1, 2):
            run = f"{protocol}_{repeat}"
            _pulses(rng, c, name, delay, supply + AMBIENT, noise).to_csv(
                folder / f"{run}.csv", index=False, float_format="%.8g"
            )
            runs[run] = {"specimen": "channel", "temperature": 293.15, "protocol": protocol}
            runs[run]["file"] = f"{run}.csv"
    units = {"duration": "s", "p_in": "Pa", "p_out": "Pa", "mass": "kg"}
    units |= {"friction_integral": "Pa*s", "injector_integral": "Pa*s"}
    document = {
        "format": "softhand-measurement/1",
        "experiment": "valve_pulse",
        "specimens": {"channel": {}},
        "columns": {column: {"unit": unit} for column, unit in units.items()},
        "runs": runs,
    }
    (folder / "experiment.yaml").write_text(yaml.safe_dump(document, sort_keys=False))
    if not hidden:
        return Truth(name)
    values = {"delay": delay} if delay else {f"c2_{way}": value for way, value in c.items()}
    return Truth(name, (frozenset({name}),), {name: values})


def _pulses(rng, c: dict, name: str, delay: float, supply: float, noise: float) -> pd.DataFrame:
    rows = []
    for _ in range(40):
        way = str(rng.choice(["inflate", "deflate"]))
        duration = float(np.clip(0.05 + rng.exponential(0.15), 0.05, 0.6))
        channel = AMBIENT + rng.uniform(0.15, 0.95) * (supply - AMBIENT) * 0.9
        source = supply * rng.normal(1, 0.01) if way == "inflate" else channel
        target = channel if way == "inflate" else AMBIENT
        rows.append(_pulse(rng, way, c[way], name, delay, duration, source, target, noise))
    return pd.DataFrame(rows)


def _pulse(rng, way, c, name, delay, duration, source, target, noise) -> dict:
    """One pulse in 200 steps; the bottle stands behind the inlet or before the outlet."""
    dt, mass = duration / 200, 0.0
    friction = injector = 0.0
    p_in, p_out = source, target
    for k in range(200):
        psi = float(flow_function(np.array(p_out / p_in)))
        friction += (p_in - p_out) * dt
        injector += p_in * psi * dt
        flow = c * p_in * psi if name == "injector_flow" else c * source
        if k * dt < duration - delay:
            mass += flow * dt
        change = flow * dt * GAS / BOTTLE
        if way == "inflate":
            p_out = min(p_out + change, p_in)
        else:
            p_in = max(p_in - change, p_out)
    size = c * source * 0.2
    return {
        "direction": way,
        "duration": duration,
        "p_in": source,
        "p_out": target,
        "friction_integral": friction,
        "injector_integral": injector,
        "mass": mass + noise * size * rng.standard_normal(),
    }
