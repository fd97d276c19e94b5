"""What is drawn in each episode."""

import numpy as np
import pytest
from scipy.stats import kstest, truncnorm

from softhand_gym import GraspEnv, Randomisation
from softhand_gym.randomisation import drawn
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model

MODEL = """format: softhand-model/1
base: pneuflex
effects:
  - {name: gravity, parameters: {mass_scale: 1.0}, std: {mass_scale: 0.2}}
"""


def test_parameters_follow_the_normal_distribution_cut_at_their_bounds():
    kind = effect_classes()["gravity"]
    (bounds,) = kind.parameters
    mean = bounds.low + 0.1 * (bounds.high - bounds.low)
    error = 0.2 * (bounds.high - bounds.low)
    model = Model(effects=(kind(mass_scale=mean),), std={"gravity": {"mass_scale": error}})
    generator = np.random.default_rng(0)
    scales = [drawn(model, generator).gravity_scale for _ in range(1000)]
    cut = truncnorm((bounds.low - mean) / error, (bounds.high - mean) / error, mean, error)
    assert kstest(scales, cut.cdf).pvalue > 0.01


def test_places_masses_and_friction_fill_their_ranges():
    ranges = Randomisation(offset=0.02, yaw=0.5, mass_spread=0.1, friction=(0.5, 2.0))
    generator = np.random.default_rng(0)
    drawn_now = [ranges.placement(generator) for _ in range(2000)]
    numbers = np.array(
        [(*p.offset, p.mass_scale, p.yaw, np.log2(p.friction_scale)) for p in drawn_now]
    )
    most = np.array([0.02, 0.02, 0.1, 0.5, 1.0])
    shares = (numbers - [0.0, 0.0, 1.0, 0.0, 0.0]) / most
    assert np.abs(shares).max() <= 1.0 + 1e-12
    assert shares.mean(axis=0) == pytest.approx(np.zeros(5), abs=0.06)
    assert shares.var(axis=0) == pytest.approx(np.full(5, 1 / 3), abs=0.03)


def test_an_episode_has_the_model_that_its_seed_draws(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text(MODEL)
    env = GraspEnv(model=path, step=0.005)
    weights, seen = [], []
    for seed in (1, 2, 1):
        env.reset(seed=seed)
        for _ in range(3):
            last, *_ = env.step(np.zeros(10))
        weights.append(env.scene.simulation._weight_scale)
        seen.append(last["pressure"].tolist() + last["object_position"].tolist())
    env.close()
    assert weights[0] == weights[2] != weights[1] and seen[0] == seen[2] != seen[1]
    still = GraspEnv(model=path, step=0.005, randomisation=Randomisation(model=False))
    still.reset(seed=1)
    assert still.scene.simulation._weight_scale == 1.0
    still.close()


@pytest.mark.parametrize(
    ("ranges", "message"),
    [
        ({"offset": -0.01}, "offset: expected 0 or more"),
        ({"mass_spread": 1.0}, "mass_spread: expected 0 or more and less than 1"),
        ({"friction": (1.5, 0.5)}, "friction: expected two factors above 0"),
    ],
)
def test_refuses_ranges_that_are_none(ranges, message):
    with pytest.raises(ValueError, match=message):
        Randomisation(**ranges)
