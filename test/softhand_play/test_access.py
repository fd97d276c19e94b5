"""The page against clients that are not its user: real HTTP, websockets and values from outside."""

import http.client
import math
import time

import msgspec
import numpy as np
import pytest
import viser
from play_page import served, wait_until
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

EVIL = "http://evil.example"
FATAL = 1008  # websocket close code: a message against the policy


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    with served(hand="single_finger", scene="stand") as page:
        wait_until(lambda: page.hand.sliders, "sliders")
        yield page


def status(page, path, **headers):
    connection = http.client.HTTPConnection("127.0.0.1", page.server.get_port(), timeout=20)
    connection.putrequest("GET", path, skip_host="Host" in headers)
    for name, value in headers.items():
        connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer.status


def opened(page, token=None, origin=""):
    """A websocket as viser's client opens it."""
    port, token = page.server.get_port(), token or page.server.access.token
    return connect(
        f"ws://127.0.0.1:{port}/{token}",
        origin=origin or f"http://127.0.0.1:{port}",
        subprotocols=[f"viser-v{viser.__version__}"],
    )


def widget(page, label):
    handles = page.server.gui._gui_input_handle_from_uuid.values()
    return next(each for each in handles if each.label == label)


def update(page, handle, **updates):
    """Send values for a widget from a websocket; the sentence of the page after it."""
    page.report("")
    message = {"type": "GuiUpdateMessage", "uuid": handle._impl.uuid, "updates": updates}
    with opened(page) as browser:
        browser.send(msgspec.msgpack.encode(message))
        return wait_until(lambda: page.message, "a refusal", 30.0)


def test_the_printed_address_is_served(page):
    token = page.server.access.token
    assert page.server.address == f"http://127.0.0.1:{page.server.get_port()}/{token}/"
    assert status(page, f"/{token}/") == 200
    with opened(page) as browser:
        assert browser.recv(timeout=30)


def test_requests_without_token_or_of_a_foreign_host_are_refused(page):
    token = page.server.access.token
    assert status(page, "/") == 403
    assert status(page, f"/{token[:-1]}/") == 403
    assert status(page, f"/{token}/", Host="evil.example") == 403
    assert status(page, f"/{token}/", Host="127.0.0.1@evil.example") == 403
    assert status(page, f"/{token}/", Origin=EVIL) == 403


FOREIGN = [{"origin": EVIL}, {"token": "x"}, {"origin": "http://127.0.0.1:1"}, {"origin": "null"}]


@pytest.mark.parametrize("wrong", FOREIGN)
def test_foreign_websockets_are_refused(page, wrong):
    with pytest.raises(InvalidStatus, match="403"):
        opened(page, **wrong)


@pytest.mark.parametrize("value", [1e9, -1.0, math.nan, math.inf, "5", None, True, [1.0]])
def test_a_value_that_a_slider_cannot_have_is_refused_and_nothing_moves(page, value):
    slider = page.hand.sliders[0]
    before = slider.value
    assert "expected a number from 0 to" in update(page, slider, value=value)
    assert slider.value == before
    assert np.nanmax(np.abs(page.player.frames[-1].pressures)) < 1e3


@pytest.mark.parametrize(
    ("label", "updates"),
    [
        ("hand", {"value": "/etc/shadow"}),
        ("pause", {"value": "yes"}),
        ("folder", {"value": "x" * 10_000}),
        ("folder", {"value": "out", "removed": True}),
        ("pause", {"update_cb": []}),
    ],
)
def test_other_widgets_refuse_what_they_cannot_have(page, label, updates):
    handle = widget(page, label)
    before = handle.value
    assert update(page, handle, **updates).startswith(f"{label}: expected")
    assert handle.value == before


@pytest.mark.parametrize(
    "message",
    [
        {"type": "ShareUrlRequest"},
        {"type": "TransformControlsUpdateMessage", "name": "/wrist_handle", "owner": "",
         "wxyz": [1, 0, 0, 0], "position": [1e9, 0, 0]},
        {"type": "FileTransferPartAck"},
        {"type": "Nonsense"},
        [1, 2],
    ],
)  # fmt: skip
def test_messages_that_no_widget_sends_are_refused_and_the_page_goes_on(page, message):
    page.report("")
    with opened(page) as browser:
        browser.send(msgspec.msgpack.encode(message))
        assert "expected" in wait_until(lambda: page.message, "a refusal", 30.0)
    test_the_printed_address_is_served(page)


CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": [1, 0, 0, 0], "position": [0, 0, 0], "fov": 1.0,
    "near": 0.1, "far": 10.0, "image_height": 10, "image_width": 10, "look_at": [0, 0, 1],
    "up_direction": [0, 0, 1],
}  # fmt: skip
POSE = {"wxyz": [1, 0, 0, 0], "position": [0, 0, 0]}
UPLOAD = {
    "type": "FileTransferStartUpload", "source_component_uuid": "x", "transfer_uuid": "t",
    "filename": "a.yaml", "mime_type": "", "part_count": 1, "size_bytes": 1,
}  # fmt: skip


@pytest.mark.parametrize(
    "message",
    [
        {"type": "GuiUpdateMessage", "uuid": [1], "updates": {"value": 1}},
        {"type": "GuiUpdateMessage", "uuid": {"a": 1}, "updates": {"value": 1}},
        {"type": "GuiUpdateMessage", "uuid": "x", "updates": None},
        {"type": "TransformControlsUpdateMessage", "name": ["/wrist_handle"], **POSE},
        {"type": "TransformControlsDragStartMessage", "name": ["/wrist_handle"]},
        {"type": "TransformControlsDragEndMessage", "name": {"a": 1}},
        CAMERA | {"position": [[1], [2, 3]]},
        CAMERA | {"wxyz": "abcd"},
        UPLOAD | {"transfer_uuid": [1]},
        UPLOAD | {"source_component_uuid": [1]},
    ],
    ids=str,
)
def test_a_field_of_another_type_ends_the_connection_with_one_line(page, message, capfd):
    with opened(page) as browser:
        browser.send(msgspec.msgpack.encode(CAMERA))
        browser.send(msgspec.msgpack.encode(message))
        with pytest.raises(ConnectionClosed) as closed:
            end = time.monotonic() + 20.0
            while time.monotonic() < end:
                browser.recv(timeout=20)
    assert closed.value.rcvd.code == FATAL
    said = capfd.readouterr().err
    assert said.count("expected a message of viser's client, got ") == 1
    assert "Traceback" not in said


def test_the_page_is_watched_while_a_browser_shows_it(page):
    wait_until(lambda: not page.player.is_watched(), "that those before have gone")
    with opened(page) as browser:
        browser.send(msgspec.msgpack.encode(CAMERA))
        wait_until(page.player.is_watched, "a browser")
    wait_until(lambda: not page.player.is_watched(), "that it has gone")


def test_an_upload_beyond_the_limit_is_refused(page):
    page.report("")
    button = widget(page, "open a file, or drop it anywhere")
    message = {
        "type": "FileTransferStartUpload", "source_component_uuid": button._impl.uuid,
        "transfer_uuid": "t", "filename": "big.mcap", "mime_type": "", "part_count": 1000,
        "size_bytes": 10**12,
    }  # fmt: skip
    with opened(page) as browser:
        browser.send(msgspec.msgpack.encode(message))
        assert wait_until(lambda: page.message, "a refusal", 30.0).startswith("big.mcap: expected")


def test_files_elsewhere_are_refused_and_links_are_followed(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out").mkdir()
    (tmp_path / "secret.jsonl").write_text("{}\n")
    (tmp_path / "out" / "link.jsonl").symlink_to(tmp_path / "secret.jsonl")
    (tmp_path / "out" / "mine.jsonl").write_text("{}\n")
    (tmp_path / "out" / "mine.txt").write_text("")
    for path in ("/etc/shadow", "out/../secret.jsonl", "out/link.jsonl", str(tmp_path)):
        with pytest.raises(ValueError, match="expected a file below out"):
            page.files.results(path)
    with pytest.raises(ValueError, match=r"expected a file .jsonl, got .txt"):
        page.files.results("out/mine.txt")
    assert page.files.results("out/mine.jsonl").is_file()


def test_a_document_that_names_a_file_elsewhere_is_refused(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "object.yaml").write_text("file: /etc/hostname\n")
    with pytest.raises(ValueError, match="expected a file below out"):
        page.files.check_document(tmp_path / "own" / "object.yaml")
