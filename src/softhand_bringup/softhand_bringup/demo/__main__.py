"""`python -m softhand_bringup.demo`, which `make demo` runs: grasp, lift and hold an object.

Exit status: 0 gripped; 1 not gripped or failed; 2 nothing could be started; 130 interrupted.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from threading import Event

from grasp_strategies.strategy import load_strategy
from grasp_strategies.trials import draw_placement
from pneuflex_sim.scene.scenes import load_scene
from softhand_bringup.processes.run_folder import Say, run_command
from softhand_bringup.processes.suite import SuiteOptions
from softhand_bringup.ros.demo import Demo


def main(arguments: list[str] | None = None) -> int:
    """Run the demo; see the module for the exit status."""
    parsed = _parse(arguments)
    try:
        options = _options(parsed)
    except ValueError as error:
        print(f"demo: {error}", flush=True)
        return 2

    def play(folder: Path, say: Say, stopped: Event) -> bool:
        say(f"{options.hand} grasps the {options.object}, seed {options.seed}")
        say(f"recording to {folder}/bag")
        return _run(Demo(options, folder, say, stopped))

    return run_command("demo", parsed.out, play)


def _run(demo: Demo) -> bool:
    verdict = demo.run()
    demo.say("drawing the pictures")
    try:
        demo.draw()
    finally:  # the verdict stands, whatever becomes of the pictures
        demo.say(verdict.line(demo.folder))
    return verdict.gripped


def _options(parsed: argparse.Namespace) -> SuiteOptions:
    offset, mass_scale = draw_placement(parsed.seed)
    strategy = load_strategy(parsed.strategy)
    if parsed.wall_inclination is not None:
        load_scene(parsed.scene).inclined(parsed.wall_inclination)  # says what is wrong with it
    return SuiteOptions(
        hand=parsed.hand or strategy.hand,
        strategy=parsed.strategy,
        object=parsed.object,
        scene=parsed.scene,
        model=parsed.model,
        friction=parsed.friction,
        wall_inclination=parsed.wall_inclination,
        object_offset=offset,
        object_mass_scale=mass_scale,
        seed=parsed.seed,
        # somebody who looks wants to see it happen as on a bench; else as fast as it goes
        real_time_factor=1.0 if parsed.gui else 0.0,
        gui=parsed.gui,
    )


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="demo", description="Grasp, lift and hold an object with three ROS 2 nodes."
    )
    parser.add_argument("--seed", type=int, default=0, help="moves the object and changes its mass")
    parser.add_argument("--gui", action="store_true", help="open PyBullet's window")
    parser.add_argument("--hand", help="name, or path of a YAML file (that of the strategy)")
    parser.add_argument(
        "--strategy", default="surface_constrained", help="name, or path of a YAML file"
    )
    parser.add_argument("--object", default="cylinder")
    parser.add_argument("--scene", default="table")
    parser.add_argument("--model", default="", help="model file of the physics")
    parser.add_argument("--friction", default="", help="file with pairs of materials of your own")
    parser.add_argument("--wall-inclination", type=float, help="of the scene's wall [deg]")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder of all runs")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
