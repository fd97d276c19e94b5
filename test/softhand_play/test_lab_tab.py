"""The tab Lab in a real browser: from two dropped files to a hand that moves by the new model."""

import threading
from functools import partial
from pathlib import Path

import pytest
from finger_csvs import HAND, finger_csvs
from hand_csvs import hand_header, motion_capture, one_row_a_pose
from play_page import PATIENCE, SELDOM, Window, served, wait_until

from model_lab.measurements.load import load_measurements
from softhand_model.effects import effect_classes
from softhand_model.model_file import load_model
from softhand_play.lab_tab import AS_SHOWN, NO_HAND
from softhand_play.messages import Look

pytestmark = pytest.mark.timeout(900)
LONG = 4 * PATIENCE  # for a diagnosis on a busy machine [s]
PHONE = {"width": 390, "height": 844}
WIDEST = 1.02  # of the width of a window
BALLOONING = effect_classes()["ballooning"]
BOX = """selector => {
  const box = document.querySelector(selector).getBoundingClientRect();
  return [box.left, box.top, box.right, box.bottom];
}"""


@pytest.fixture(scope="module")
def page():
    with served(hand="rbo_hand_2", scene="stand") as page:
        yield page


@pytest.fixture(scope="module")
def texts():
    return finger_csvs(BALLOONING(gain=0.6, onset=45e3, sharpness=8.0))


def test_two_files_become_a_verdict_and_the_hand_moves_by_the_new_model(page, texts, open_window):
    window = open_window(page)
    window.press("Lab")
    window.choose("measured finger or hand", HAND)
    for name, text in texts.items():
        window.drop(name, text)
    window.reads("free_bending, 2 runs")
    assert all(words in window.text() for words in (*texts, "tip_angle"))
    window.press("diagnose")
    window.reads("diagnose: computing")
    before = page.player.frames[-1].time
    wait_until(lambda: page.player.frames[-1].time > before + 0.2, "a hand that goes on")
    wait_until(lambda: not page.lab.work.is_running, "the diagnosis", LONG)
    wait_until(lambda: "ballooning" in page.lab.effect.options, "the effect that is in the data")
    window.reads("verdict: ")
    window.press("add it, and move the hand with it")
    settings = wait_until(
        lambda: page.player.world.settings if page.player.world.settings.model else None,
        "the new model in the hand",
        LONG,
    )
    assert "ballooning" in [effect.name for effect in load_model(Path(settings.model)).effects]
    window.press("Hand")
    straight = page.player.frames[-1].state.joints
    window.slide("b: index")
    wait_until(lambda: page.player.frames[-1].pressures[1] > 60e3, "the pressure")
    assert abs(page.player.frames[-1].state.joints - straight).max() > 0.05


def test_a_diagnosis_is_cancelled_and_its_process_ends(page, texts):
    page.lab._forget()
    page.lab.finger.value = HAND
    for name, text in texts.items():
        page.dropped.open(name, text.encode())
    page.lab._diagnose()
    process = page.lab.work._process
    page.lab._cancel()
    assert process.returncode is not None
    assert not page.lab.work.is_running and page.message == "cancelled"
    assert not [thread for thread in threading.enumerate() if thread.name == "model-lab"]


def test_a_file_that_can_be_read_in_two_ways_waits_for_what_is_said_of_it(page):
    page.lab._forget()
    rows = "\n".join(f"{n};{1 + n / 10:.3f};{n},{100 + n}".replace(".", ",") for n in range(1, 9))
    text = f"time [s];stretch [-];stress [kPa]\n{rows}\n"
    page.attempt(lambda: page.dropped.open("pull_1.csv", text.encode()))
    assert page.look is Look.ERROR and "decimal sign" in page.message
    given = {"decimal": "comma", "specimen": "strip", "stretched": "pull_1.csv=2.5"}
    for name, value in given.items():
        getattr(page.lab, name).value = value
    page.attempt(page.lab._look)
    (run,) = load_measurements(page.lab._set).runs
    assert (run.specimen, run.stretched_to) == ("strip", 2.5)
    assert run.columns["stress"][0] == pytest.approx(1.101e3)
    page.lab.stretched.value = "far"
    page.attempt(page.lab._look)
    assert page.message == "stretched to: expected STRETCH or FILE=STRETCH, such as 1.5, got far"
    for name in given:
        getattr(page.lab, name).value = AS_SHOWN if name == "decimal" else ""


def test_a_file_of_a_testing_machine_becomes_a_set_by_the_text_that_the_page_proposes(page):
    page.lab._forget()
    page.lab.finger.value = NO_HAND
    rows = "\n".join(f"{n},{n},{0.001 * n}" for n in range(1, 9))
    page.attempt(lambda: page.dropped.open("pull.csv", f"s,Weg (mm),Kraft (kN)\n{rows}\n".encode()))
    proposed = "--map 'stretch=elongation(Weg,LENGTH)'", "--map 'stress=per_area(Kraft,AREA)'"
    assert page.look is Look.ERROR and all(text in page.message for text in proposed)
    pasted = " ".join(proposed).replace("LENGTH", "10 mm").replace("AREA", "5mm x 2mm")
    page.lab.maps.value = pasted
    page.attempt(page.lab._look)
    (run,) = load_measurements(page.lab._set).runs
    assert run.columns["stretch"][[0, -1]] == pytest.approx([1.0, 1.7])
    assert run.columns["stress"][-1] == pytest.approx(8.0 / 10e-6)
    page.lab.maps.value = pasted + "'"
    page.attempt(page.lab._look)
    assert page.look is Look.ERROR and page.message.startswith("columns: ")
    page.lab.maps.value = ""


def test_files_of_motion_capture_and_a_logger_become_a_set_of_the_whole_hand(page, tmp_path):
    page.lab._forget()
    page.lab.finger.value = "rbo_hand_2"
    with pytest.raises(ValueError, match="expected pressure and markers of one run"):
        page.dropped.open("alone.csv", motion_capture(tmp_path)[0].read_bytes())
    page.lab._forget()
    files = one_row_a_pose(tmp_path, hand_header(), (1e-3, 1e3))
    for file in files:
        page.attempt(partial(page.dropped.open, file.name, file.read_bytes()))
    assert page.look is Look.ERROR and "the orientation of the wrist" in page.message
    page.lab.wrist.value = "; ".join(f"{file.name}=0,90,0" for file in files)
    page.attempt(page.lab._look)
    assert page.message.startswith("hand_pose, 3 runs")
    assert load_measurements(page.lab._set).hand.name == "rbo_hand_2"
    page.lab.wrist.value = ""


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("../../x.csv", "a,b\n", "x.csv"),
        ("two.csv", "foo,bar\n1,2\n2,3\n3,4\n", "expected"),
    ],
)
def test_a_file_that_is_no_measurement_becomes_a_sentence(page, name, text, words):
    page.lab._forget()
    page.attempt(lambda: page.dropped.open(name, text.encode()))
    assert words in page.message
    assert page.look is Look.ERROR
    page.attempt(page.lab._diagnose)
    assert page.message.startswith("lab: no measurements")


def _lowest_of_view(window):
    return window.tab.evaluate(BOX, "canvas[data-engine]")[3]


def _top_of_panel(window):
    return window.tab.evaluate(BOX, "[role=tab]")[1]


def test_on_a_phone_the_panel_lies_below_the_hand_and_the_status_above(page, chromium):
    context = chromium.new_context(viewport=PHONE)
    context.add_init_script(SELDOM)
    window = Window(context.new_page(), page.server.address)
    page.report("bad.yaml: format: expected a hand", Look.ERROR)
    window.reads("⚠ bad.yaml: format: expected a hand")
    wait_until(lambda: _lowest_of_view(window) <= _top_of_panel(window), "the panel below the hand")
    _, top, right, bottom = window.tab.evaluate(BOX, "canvas[data-engine]")
    status = window.tab.evaluate(BOX, "#softhand-status")
    assert bottom - top >= 0.45 * PHONE["height"]
    assert right <= WIDEST * PHONE["width"]
    assert status[2] - status[0] > 0.9 * PHONE["width"] and status[3] < 0.15 * PHONE["height"]
    window.tab.get_by_text("Softhand Play").click()
    wait_until(
        lambda: _lowest_of_view(window) > 0.9 * PHONE["height"],
        "the folded panel",
    )
    assert window.tab.title() == "Softhand Play"
    context.close()
