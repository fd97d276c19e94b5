# Every target sets up what it needs; the second time that takes no time.
PYTHON_IN_VENV := .venv/bin/python
SOURCES := src thesis test examples bench scripts
OLDEST := test/softhand_model test/pneumaticbox_driver/observer test/model_lab/experiments

.PHONY: setup demo play lab-demo lab-story thesis equilibrium test test-oldest lint bench bench-design bench-dexterity bench-grasps bench-lab bench-mutants bench-pneumatics bench-robust \
	pneumatics-experiments pneumatics-figures docs figures lab-figure live-figure play-figure strategies-figure clean

setup:
	@scripts/setup.sh

# GUI=1 opens PyBullet's window; SEED=3 moves the object and changes its mass; another hand comes with
# a strategy of its own: STRATEGY=examples/three_finger_gripper/grasp.yaml OBJECT=ball; FRICTION=pairs.yaml
# has pairs of materials of your own.
demo: setup
	@$(PYTHON_IN_VENV) -m softhand_bringup.ros.demo $(if $(filter-out 0,$(GUI)),--gui) $(if $(SEED),--seed $(SEED)) \
		$(if $(STRATEGY),--strategy $(STRATEGY)) $(if $(OBJECT),--object $(OBJECT)) $(if $(HAND),--hand $(HAND)) \
		$(if $(FRICTION),--friction $(FRICTION))

# A page in the browser to move a hand and to let it grasp, at http://127.0.0.1:8765 (HAND=rbo_hand_1,
# OBJECT=ball, ARGS="--port 9000"; ARGS=--ros: the nodes that run).
play: setup
	@$(PYTHON_IN_VENV) -m softhand_play.command $(if $(HAND),--hand $(HAND)) $(if $(OBJECT),--object $(OBJECT)) $(ARGS)

# SEED=3 hides another effect in another set.
lab-demo: setup
	@$(PYTHON_IN_VENV) -m model_lab.cli.demo $(if $(SEED),--seed $(SEED))

# The same over ROS: a finger whose simulator hides an effect (HIDE=gent_stiffening, HIDE=nothing ...)
# is measured into bags, diagnosed, and watched by the monitor before and after; out/lab-story.
lab-story: setup
	@$(PYTHON_IN_VENV) -m softhand_bringup.ros.lab_story $(if $(HIDE),--hide $(HIDE)) $(if $(SEED),--seed $(SEED))

# The thesis's experiments, results in out/thesis (ARGS="list", ARGS="run six_channels", ARGS="all --small").
thesis: setup
	@$(PYTHON_IN_VENV) -m thesis $(or $(ARGS),list)

# A finger pressed on a table under mass, pressure and volume control, over ROS.
equilibrium: setup
	@$(PYTHON_IN_VENV) -m thesis run equilibrium_point --force $(if $(SEED),--seed $(SEED))

# In three processes, of which one runs all tests that start nodes, and mostly waits (ARGS="test/docs"; ARGS="-n 0": in one).
test: setup
	@$(PYTHON_IN_VENV) -m pytest -q -n 3 $(ARGS)

# The same with the versions of requirements/oldest.txt (ARGS="test": all; else what calculates with them).
test-oldest: setup .oldest/stamp
	@PYTHONPATH=$(CURDIR)/.oldest NUMBA_CACHE_DIR=$(CURDIR)/.oldest/numba $(PYTHON_IN_VENV) -m pytest -q -n 2 $(or $(ARGS),$(OLDEST))

.oldest/stamp: requirements/oldest.txt
	@$(PYTHON_IN_VENV) -m pip install -q --no-deps --upgrade --target .oldest -r $< && touch $@

lint: setup
	@$(PYTHON_IN_VENV) -m ruff check $(wildcard $(SOURCES))
	@$(PYTHON_IN_VENV) -m mypy
	@.venv/bin/lint-imports

bench: setup
	@$(PYTHON_IN_VENV) -m bench $(ARGS)

# Hidden effects, on seeds that nobody has seen: hours on two cores, taken up where it was stopped
# (ARGS="--misses", ARGS="--small", ARGS="--seed 4711": that run again).
bench-lab: setup
	@$(PYTHON_IN_VENV) -m bench.lab $(ARGS)

# The pneumatic box on five boxes with calibrations of their own (ARGS="--seeds 1 --rows sine").
bench-pneumatics: setup
	@$(PYTHON_IN_VENV) -m bench.pneumatics $(ARGS)

# Every experiment of chapter 4 (ARGS="--seed 3").
pneumatics-experiments: setup
	@$(PYTHON_IN_VENV) -m thesis all chapter_4 --force $(ARGS)

# The pictures and tables of docs/thesis/pneumatics-experiments.md, from the latest results.
pneumatics-figures: setup
	@$(PYTHON_IN_VENV) scripts/fill_pages.py docs/thesis/pneumatics-experiments.md

# The simulator: speed beside the prototype and the thesis, random trials, borders of success; ten
# minutes on an idle machine (ARGS="--small", ARGS="--rows trials").
bench-sim: setup
	@$(PYTHON_IN_VENV) -m bench.sim $(ARGS)

# Small bugs put in on purpose, one at a time: which does no test see? Half an hour, one process
# (ARGS="--seed 3", ARGS="--only judge verdict").
bench-mutants: setup
	@$(PYTHON_IN_VENV) -m bench.mutants $(ARGS)

# Hostile messages, wrong calls, signals, faults, damaged files, long work; half an hour on an idle
# machine (ARGS="--rows messages calls", ARGS="--minutes 60 --seed 3").
bench-robust: setup
	@$(PYTHON_IN_VENV) -m bench.robust $(ARGS)

# Criteria of the maps of chapters 8 and 9 as they lie in out/thesis, grasps from the table, steps,
# rates; two hours on an idle machine (ARGS="--rows table_grasps rate"; ARGS=--help).
bench-grasps: setup
	@$(PYTHON_IN_VENV) -m bench.grasps $(ARGS)

# Designed actuators: against their wishes, in the simulator, by the lab, as moulds; an hour
# (ARGS="--count 5 --rows sizing").
bench-design: setup
	@$(PYTHON_IN_VENV) -m bench.design $(ARGS)

# Criteria of the Kapandji test; half an hour if it has not been made yet.
bench-dexterity: setup
	@$(PYTHON_IN_VENV) -m bench.dexterity $(ARGS)

# Pages that are made from docstrings and from the nodes' parameters.
docs: setup
	@$(PYTHON_IN_VENV) scripts/list_errata.py
	@$(PYTHON_IN_VENV) scripts/list_effects.py
	@$(PYTHON_IN_VENV) scripts/fill_pages.py docs/reference/topics-and-services.md
	@$(PYTHON_IN_VENV) scripts/draw_architecture.py

# The pictures of the README, from the latest run of the demo.
figures: setup
	@$(PYTHON_IN_VENV) -m softhand_bringup.figures out/demo/bag docs/figures

# The picture of the strategies that use the environment.
strategies-figure: setup
	@$(PYTHON_IN_VENV) scripts/draw_strategies.py

# The picture of the lab, from the latest run of its demo.
lab-figure: setup
	@$(PYTHON_IN_VENV) -m model_lab.report.picture out/lab-demo/set base docs/figures/lab.png

# The film of the page: chromium draws it by software, which takes minutes.
play-figure: setup
	@$(PYTHON_IN_VENV) scripts/draw_play.py

# The picture of the monitor, from the latest story over ROS.
live-figure: setup
	@$(PYTHON_IN_VENV) -m softhand_bringup.lab_story.picture out/lab-story docs/figures/live.png

clean:
	rm -rf .venv .oldest .setup out ros_ws/build ros_ws/install ros_ws/log .pytest_cache .mypy_cache .ruff_cache .import_linter_cache
	find src thesis test examples bench scripts -name __pycache__ -prune -exec rm -rf {} +
	rm -rf src/*/*.egg-info src/*/build
