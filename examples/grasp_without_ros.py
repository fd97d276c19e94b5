"""One grasp in this process, without ROS: what the demo does, for sweeps over many placements.

`python examples/grasp_without_ros.py` prints the outcome of a few seeds.
"""

from softhand_trials.trials import run_trial


def outcome(seed):
    """(outcome, lift height [m], slip [m]) of the trial with this seed."""
    result = run_trial(seed).result
    return result.outcome, result.lift_height, result.slip


def test_the_grasp_of_seed_0_succeeds():
    word, lift_height, slip = outcome(0)
    assert word == "gripped"
    assert lift_height >= 0.100
    assert slip < 1e-3


if __name__ == "__main__":
    for seed in range(3):
        word, lift_height, slip = outcome(seed)
        print(f"seed {seed}: {word}, lifted {1e3 * lift_height:.0f} mm, slip {1e3 * slip:.2f} mm")
