"""A gripper of one's own, described in YAML alone, grasps a ball (docs/use/new-hand.md).

`python examples/grasp_with_own_gripper.py` prints the outcome of a few seeds.
"""

from pathlib import Path

from softhand_trials.trials import TrialSettings, run_trial

STRATEGY = Path(__file__).parent / "three_finger_gripper" / "grasp.yaml"  # names the hand's file


def outcome(seed):
    """(outcome, lift height [m], slip [m]) of the trial with this seed."""
    result = run_trial(
        seed, TrialSettings(strategy=str(STRATEGY), object="ball", step=0.005)
    ).result
    return result.outcome, result.lift_height, result.slip


def test_the_gripper_lifts_and_holds_the_ball():
    word, lift_height, slip = outcome(0)
    assert word == "gripped"
    assert lift_height >= 0.100
    assert slip < 2e-3


if __name__ == "__main__":
    for seed in range(3):
        word, lift_height, slip = outcome(seed)
        print(f"seed {seed}: {word}, lifted {1e3 * lift_height:.0f} mm, slip {1e3 * slip:.2f} mm")
