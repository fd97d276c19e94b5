"""A user's effect file: what it does wrong is told in one line, and never takes part."""

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from softhand_model.effects import effects_in_file
from softhand_model.effects.own import guard, own_file
from softhand_model.effects.own.guard import EffectError
from softhand_model.model_file import load_model

HEAD = """
import os, sys, time
import numpy as np
from softhand_model.effects import FlowEffect, LoadEffect, ElasticEffect, Parameter

class Own(LoadEffect):
    name = "own"
    experiments = frozenset({"free_bending"})
    parameters = (Parameter("size", "", 0.0, 2.0),)

    def act_on_load(self, load, pressure, shape):
        BODY
"""
BODIES = {
    "raises": ("raise KeyError('no such key')", "expected it to run, got KeyError: 'no such key'"),
    "nothing": ("pass", "expected numbers, got None"),
    "text": ("return 'much'", "expected numbers, got 'much'"),
    "list": ("return [1.0]", r"expected numbers, got \[1.0\]"),
    "shape": ("return np.ones(7)", r"expected the shape \(2, 3, 4\), got \(7,\)"),
    "longer": ("return np.ones((5, 2, 3, 4))", "expected the shape"),
    "infinite": ("return load / 0.0", "expected finite numbers, got inf"),
    "not a number": ("return load * float('nan')", "expected finite numbers, got nan"),
    "in place": ("load *= 2.0; return load", "arguments left as they are, got a change in place"),
    "in a shape": ("shape.wall[:] = 1.0; return load", "arguments left as they are"),
    "leaves": ("sys.exit(7)", r"expected the code to return, got sys.exit\(7\)"),
    "ends": ("os._exit(7)", "got the end of its process, status 7"),
    "endless": (
        "while True: pass",
        "expected the code to end within 5 s of processor time, got longer",
    ),
}


@pytest.fixture
def file(tmp_path):
    def write(body):
        path = tmp_path / "own.py"
        path.write_text(HEAD.replace("BODY", body))
        return path

    return write


@pytest.mark.parametrize("fault", BODIES)
def test_what_a_method_does_wrong_is_told_before_it_takes_part(file, fault):
    body, expected = BODIES[fault]
    path = file(body)
    with pytest.raises(EffectError, match=expected) as told:
        effects_in_file(path)
    assert str(path) in str(told.value) and "\n" not in str(told.value)
    if fault != "ends":
        assert f"{path}: Own.act_on_load: " in str(told.value)


@pytest.mark.parametrize(
    ("line", "expected"),
    [("sys.exit(3)", r"got sys.exit\(3\)"), ("os._exit(0)", "expected"), ("1 / 0", "ZeroDivision")],
)
def test_a_file_that_ends_its_process_on_loading_is_refused(file, line, expected):
    path = file("return load")
    path.write_text(f"{path.read_text()}\n{line}\n")
    with pytest.raises(EffectError, match=expected):
        effects_in_file(path)


def loaded(path):
    return effects_in_file(path)["own"](size=1.0)


def test_what_only_shows_later_is_told_then(file):
    own = loaded(file("return load if load.max() < 1.0 else None"))
    load = np.full((1, 3, 4), 0.5)
    assert own.act_on_load(load, 1e3, None) == pytest.approx(load)
    with pytest.raises(EffectError, match=r"Own.act_on_load: expected numbers, got None"):
        own.act_on_load(2.0 * load, 1e3, None)


def test_a_call_that_does_not_end_is_ended(file, monkeypatch):
    own = loaded(file("\n        while load.max() > 1.0: pass\n        return load"))
    monkeypatch.setattr(guard, "CALL_LIMIT", 0.2)
    begun = time.monotonic()
    with pytest.raises(EffectError, match="the code to end within 0.2 s of processor time"):
        own.act_on_load(np.full(3, 2.0), 1e3, None)
    assert time.monotonic() - begun < 5.0


def test_a_call_that_waits_has_its_limit_in_wall_time(file, monkeypatch):
    own = loaded(file("\n        if load.max() > 1.0: time.sleep(20)\n        return load"))
    monkeypatch.setattr(guard, "CALL_LIMIT", 0.2)
    monkeypatch.setattr(guard, "WAIT_LIMIT", 0.5)
    with pytest.raises(EffectError, match="expected the code to end within 0.5 s of wall time"):
        own.act_on_load(np.full(3, 2.0), 1e3, None)


def test_a_call_that_is_slow_for_other_work_is_no_fault(file, monkeypatch):
    own = loaded(file("\n        if load.max() > 1.0: time.sleep(0.6)\n        return load"))
    monkeypatch.setattr(guard, "CALL_LIMIT", 0.3)  # of which it takes nothing while it sleeps
    assert own.act_on_load(np.full(3, 2.0), 1e3, None).max() == 2.0


def test_a_file_that_hides_its_endless_work_is_ended_by_its_processor_time(file, monkeypatch):
    path = file("return load")
    endless = "import threading\nt = threading.Thread(target=lambda: [0 for _ in iter(int, 1)])\n"
    path.write_text(f"{path.read_text()}\n{endless}t.start()\nt.join(0.1)\n")
    monkeypatch.setattr(own_file, "REHEARSAL_LIMIT", 3)
    with pytest.raises(EffectError, match="expected the code to end within 3 s of processor time"):
        effects_in_file(path)


def test_what_was_no_number_before_is_not_put_down_to_the_effect(file):
    own = loaded(file("return 2.0 * load"))
    assert np.isnan(own.act_on_load(np.array([np.nan, 1.0]), 1e3, None)).tolist() == [True, False]


def test_a_sound_effect_gives_what_it_gives_in_any_thread(file):
    own = loaded(file("return load * self.values['size'] + pressure"))
    load, pressure = np.full((3, 4), 0.5), np.ones((3, 1))
    found = own.act_on_load(load, pressure, None)
    assert (found == 1.5).all() and found.flags.writeable
    with ThreadPoolExecutor(1) as pool:
        assert (pool.submit(own.act_on_load, load, pressure, None).result() == 1.5).all()
    lanes = type(own).in_lanes({"size": [1.0, 2.0]})
    assert lanes.act_on_load(load, pressure, None)[:, 0, 0].tolist() == [1.5, 2.0]
    unchanged = loaded(file("return load"))
    given = np.ones(3)
    unchanged.act_on_load(given, 1.0, None)[:] = 2.0
    assert given.tolist() == [1.0, 1.0, 1.0]


FLOW = """
from softhand_model.effects import FlowEffect, Parameter

class Own(FlowEffect):
    name = "own"
    parameters = (Parameter("size", "", 0.0, 2.0),)

    def act_on_pulse(self, pulse, mass):
        return {result}
"""


@pytest.mark.parametrize(
    ("result", "expected"),
    [
        ("mass", "expected a Pulse, got array"),
        ("pulse.lasting(pulse.duration * float('inf'))", "duration: expected finite numbers"),
        ("pulse.fed_at(pulse.p_in * self.values['size'])", "p_in: expected the shape"),
    ],
)
def test_a_pulse_is_looked_at_field_by_field(tmp_path, result, expected):
    path = tmp_path / "own.py"
    path.write_text(FLOW.format(result=result))
    with pytest.raises(EffectError, match=f"Own.act_on_pulse: {expected}"):
        effects_in_file(path)
    path.write_text(FLOW.format(result="pulse.lasting(pulse.duration * self.of('size'))"))
    assert "own" in effects_in_file(path)


MODEL = """format: softhand-model/1
base: pneuflex
effects:
  - {{name: own, file: {file}, {rest}}}
"""


def test_the_code_of_a_model_file_is_run_on_request_alone(file, tmp_path, monkeypatch):
    path = file("return load")
    path.write_text(f"{path.read_text()}\nopen('ran', 'w').close()\n")
    monkeypatch.chdir(tmp_path)
    model = tmp_path / "model.yaml"
    model.write_text(MODEL.format(file="own.py", rest="parameters: {size: 1.0}"))
    with pytest.raises(ValueError, match=r"effects\[0\].file: .*--allow-effect-files"):
        load_model(model)
    assert not (tmp_path / "ran").exists()
    assert load_model(model, allow_effect_files=True).effects[0].values == {"size": 1.0}
    assert (tmp_path / "ran").exists()


@pytest.mark.parametrize("given", ["../own.py", "/tmp/own.py", "link.py"])
def test_the_code_of_a_model_file_lies_in_its_folder(file, tmp_path, given):
    path = file("return load")
    folder = tmp_path / "models"
    folder.mkdir()
    (folder / "link.py").symlink_to(path)
    model = folder / "model.yaml"
    model.write_text(MODEL.format(file=given, rest="parameters: {size: 1.0}"))
    with pytest.raises(ValueError, match="expected a file in the model file's folder"):
        load_model(model, allow_effect_files=True)


def test_an_effect_that_was_given_stands_for_the_file_of_its_name(file, tmp_path):
    own = effects_in_file(file("return load"))
    model = tmp_path / "model.yaml"
    model.write_text(MODEL.format(file="own.py", rest="parameters: {size: 1.0}"))
    assert isinstance(load_model(model, own).effects[0], own["own"])
