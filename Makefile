# Every target sets up what it needs; the second time that takes no time. `make help` lists the targets.
PYTHON_IN_VENV := .venv/bin/python
PYTHONS := 3.11 3.12 3.13
LOCK := $(PYTHON_IN_VENV) -m uv pip compile --quiet --generate-hashes --no-annotate --custom-compile-command "make lock"
SOURCES := src thesis test examples bench scripts
OLDEST := test/softhand_common test/softhand_model test/pneumaticbox_driver/observer test/model_lab/experiments

# Each figure with the run that it shows.
FIGURE_demo := -m softhand_bringup.figures out/demo/bag docs/figures
FIGURE_strategies := scripts/draw_strategies.py
FIGURE_lab := -m model_lab.report.picture out/lab-demo/set base docs/figures/lab.png
FIGURE_live := -m softhand_bringup.lab_story.picture out/lab-story docs/figures/live.png
FIGURE_play := scripts/draw_play.py
FIGURES := demo strategies lab live play

.PHONY: help setup demo play lab-demo lab-story hand-story thesis test test-oldest lint lock bench docs site figures clean

help: ## This list
	@awk -F ' *## *' '/^[a-z-]+:.*##/ {sub(/:.*/, "", $$1); printf "make %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

setup: ## The environment in .venv
	@scripts/setup.sh

demo: setup ## A grasp over ROS (SEED=3 GUI=1 STRATEGY=file.yaml OBJECT=ball HAND=rbo_hand_1 FRICTION=pairs.yaml ENGINE=mujoco)
	@$(PYTHON_IN_VENV) -m softhand_bringup.ros.demo $(if $(filter-out 0,$(GUI)),--gui) $(if $(SEED),--seed $(SEED)) \
		$(if $(STRATEGY),--strategy $(STRATEGY)) $(if $(OBJECT),--object $(OBJECT)) $(if $(HAND),--hand $(HAND)) \
		$(if $(FRICTION),--friction $(FRICTION)) $(if $(ENGINE),--engine $(ENGINE))

play: setup ## A page in the browser to move a hand and let it grasp (HAND=rbo_hand_1 OBJECT=ball ARGS=--ros)
	@$(PYTHON_IN_VENV) -m softhand_play.command $(if $(HAND),--hand $(HAND)) $(if $(OBJECT),--object $(OBJECT)) $(ARGS)

lab-demo: setup ## The lab finds a hidden effect in a simulated set of measurements (SEED=3)
	@$(PYTHON_IN_VENV) -m model_lab.cli.demo $(if $(SEED),--seed $(SEED))

lab-story: setup ## The same over ROS, from recording to monitor (HIDE=gent_stiffening SEED=3)
	@$(PYTHON_IN_VENV) -m softhand_bringup.ros.lab_story $(if $(HIDE),--hide $(HIDE)) $(if $(SEED),--seed $(SEED))

hand-story: setup ## The same on a whole hand: in which finger? (HIDE=mount_tilt SEED=3)
	@$(PYTHON_IN_VENV) -m softhand_bringup.ros.hand_story $(if $(HIDE),--hide $(HIDE)) $(if $(SEED),--seed $(SEED))

thesis: setup ## Experiments of the thesis (ARGS=list, ARGS="run equilibrium_point --force", ARGS="all chapter_4")
	@$(PYTHON_IN_VENV) -m thesis $(or $(ARGS),list)

# In three processes, of which one runs all tests that start nodes. Bytecode is kept, for the programs that tests start.
test: setup ## All tests (ARGS="test/docs", ARGS="-n 0": in one process)
	@PYTHONDONTWRITEBYTECODE= $(PYTHON_IN_VENV) -m pytest -q -n 3 $(ARGS)

test-oldest: setup .oldest/stamp ## Tests with the oldest supported versions of the libraries (ARGS=test: all of them)
	@PYTHONDONTWRITEBYTECODE= PYTHONPATH=$(CURDIR)/.oldest NUMBA_CACHE_DIR=$(CURDIR)/.oldest/numba $(PYTHON_IN_VENV) -m pytest -q -n 2 $(or $(ARGS),$(OLDEST))

.oldest/stamp: requirements/lock/oldest.txt
	@$(PYTHON_IN_VENV) -m pip install -q --no-deps --upgrade --target .oldest --require-hashes -r $< && touch $@

lint: setup ## ruff, mypy, import contracts, no conflict markers
	@! git grep -nE '^(<<<<<<<|>>>>>>>) '
	@$(PYTHON_IN_VENV) -m ruff check $(wildcard $(SOURCES))
	@$(PYTHON_IN_VENV) -m mypy
	@.venv/bin/lint-imports

# What is locked stays unless the inputs ask for another version (ARGS=--upgrade: the newest of all).
lock: setup ## Versions and hashes in requirements/lock, after a change of requirements/*.txt
	@for version in $(PYTHONS); do \
		$(LOCK) --python-version $$version --python-platform x86_64-manylinux_2_28 $(ARGS) \
			--output-file requirements/lock/$$version.txt requirements/develop.txt || exit; \
	done
	@$(LOCK) --no-deps --python-version 3.11 --output-file requirements/lock/build.txt requirements/build.txt
	@$(LOCK) --no-deps --python-version 3.11 --output-file requirements/lock/oldest.txt requirements/oldest.txt

bench: setup ## Benchmarks (NAME=lab, sim, robust, pneumatics, grasps, mutants ...; ARGS=--help)
	@$(PYTHON_IN_VENV) -m bench$(if $(NAME),.$(NAME)) $(ARGS)

docs: setup ## Pages made from docstrings and parameters
	@$(PYTHON_IN_VENV) scripts/list_errata.py
	@$(PYTHON_IN_VENV) scripts/list_effects.py
	@$(PYTHON_IN_VENV) scripts/fill_pages.py docs/reference/topics-and-services.md
	@$(PYTHON_IN_VENV) scripts/draw_architecture.py

site: setup ## A site of the docs, with search, in site/ (SERVE=1: show it and follow changes)
	@$(PYTHON_IN_VENV) -m zensical $(if $(filter-out 0,$(SERVE)),serve --open,build --clean --strict)

figures: setup ## Pictures of the docs, from the latest runs (NAME=demo, strategies, lab, live, play)
	@$(if $(FIGURE_$(or $(NAME),demo)),$(PYTHON_IN_VENV) $(FIGURE_$(or $(NAME),demo)),$(error NAME: expected one of $(FIGURES), got $(NAME)))

clean: ## Remove the environment and all results
	rm -rf .venv .oldest .setup .cache out site ros_ws/build ros_ws/install ros_ws/log .pytest_cache .mypy_cache .ruff_cache .import_linter_cache
	find src thesis test examples bench scripts -name __pycache__ -prune -exec rm -rf {} +
	rm -rf src/*/*.egg-info src/*/build
