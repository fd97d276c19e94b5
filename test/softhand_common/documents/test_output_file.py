"""Files are written whole or not at all, by one module in the whole suite."""

import ast
import errno
import os
import resource
import stat
import threading
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from softhand_common.documents.output_file import (
    UnwritableFile,
    save_figure,
    write_file,
    write_files,
    write_new,
    written_whole,
)

ROOT = Path(__file__).parents[3]
WRITERS = {
    *("write_text", "write_bytes", "savefig", "imsave", "savetxt", "savez", "savez_compressed"),
    *("save", "export", "dump", "tofile", "to_csv", "to_json", "write_image", "write_html"),
}
STREAMS = {  # what may write by itself, and why
    "sweep/results.py": "lines are appended, so that a run that is killed loses none",
    "film/writing.py": "tries whether an earlier film may be overwritten; frames go to a folder "
    "beside",
    "report/drawing.py": "SVG as text, into memory",
    "processes/launcher.py": "the log of a process that runs",
    "documents/output_file.py": "the module itself",
    "processes/domain.py": "a lock, which is empty",
}


@pytest.fixture
def full_disk():
    """No file of this process grows beyond 1000 bytes, as on a disk that is nearly full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_file_that_does_not_fit_leaves_the_earlier_one(tmp_path, full_disk):
    path = tmp_path / "result.json"
    write_file(path, "earlier")
    with pytest.raises(UnwritableFile, match=r"result\.json: expected a place to write to, got F"):
        write_file(path, "x" * 2000)
    assert path.read_text() == "earlier" and names(tmp_path) == ["result.json"]


def test_of_files_that_belong_together_none_is_new_when_one_does_not_fit(tmp_path, full_disk):
    paths = [tmp_path / name for name in ("a.csv", "b.csv", "c.csv")]
    write_files(dict.fromkeys(paths, "earlier"))
    with pytest.raises(UnwritableFile, match=r"b\.csv"):
        write_files(dict(zip(paths, ["new", b"x" * 2000, "new"], strict=True)))
    assert [path.read_text() for path in paths] == ["earlier"] * 3
    assert names(tmp_path) == ["a.csv", "b.csv", "c.csv"]


def test_a_picture_that_does_not_fit_leaves_the_earlier_one(tmp_path, full_disk):
    for ending in ("png", "pdf", "svg"):
        path = tmp_path / f"curve.{ending}"
        write_file(path, b"earlier")
        with pytest.raises(UnwritableFile, match=f"curve.{ending}"):
            save_figure(Figure(), path)
        assert path.read_bytes() == b"earlier"
    assert len(names(tmp_path)) == 3


def test_a_block_that_raises_leaves_the_earlier_file(tmp_path):
    path = tmp_path / "film.mp4"
    write_file(path, "earlier")
    with pytest.raises(KeyError), written_whole(path) as file:
        file.write_text("half")
        raise KeyError
    assert path.read_text() == "earlier" and names(tmp_path) == ["film.mp4"]


def test_mode_and_link_stay(tmp_path):
    path, link = tmp_path / "box.yaml", tmp_path / "link.yaml"
    path.write_text("earlier")
    path.chmod(0o640)
    link.symlink_to(path)
    write_file(link, "new")
    assert link.is_symlink() and path.read_text() == "new"
    assert path.stat().st_mode & 0o777 == 0o640


def test_a_loop_of_links_is_named(tmp_path):
    (tmp_path / "a.json").symlink_to(tmp_path / "b.json")
    (tmp_path / "b.json").symlink_to(tmp_path / "a.json")
    with pytest.raises(UnwritableFile, match=r"a\.json: expected a place to write to, got"):
        write_file(tmp_path / "a.json", "new")


def test_a_path_below_dev_that_is_a_file_is_written_whole(tmp_path, full_disk):
    path = Path("/dev/..") / tmp_path.relative_to("/") / "result.json"
    write_file(path, "earlier")
    with pytest.raises(UnwritableFile):
        write_file(path, "x" * 2000)
    assert path.read_text() == "earlier"


def test_where_the_disk_fails_at_the_last_moment_none_of_the_files_is_new(tmp_path, monkeypatch):
    paths = [tmp_path / name for name in ("a.csv", "b.csv")]
    write_files(dict.fromkeys(paths, "earlier"))
    calls, fsync = [], os.fsync

    def fail(descriptor):
        calls.append(descriptor)
        if len(calls) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(UnwritableFile, match=r"b\.csv: .*No space left on device"):
        write_files(dict.fromkeys(paths, "new"))
    assert [path.read_text() for path in paths] == ["earlier", "earlier"]
    assert names(tmp_path) == ["a.csv", "b.csv"]


def test_two_threads_that_write_the_same_file_both_succeed(tmp_path):
    path, errors = tmp_path / "result.json", []

    def write(content):
        try:
            for _ in range(100):
                write_file(path, content)
        except ValueError as error:
            errors.append(error)

    threads = [threading.Thread(target=write, args=(letter * 1000,)) for letter in "ab"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors
    assert path.read_text() in ("a" * 1000, "b" * 1000) and names(tmp_path) == ["result.json"]


def test_what_is_secret_is_so_while_it_is_written(tmp_path):
    path = tmp_path / "result.json"
    write_file(path, "earlier")
    path.chmod(0o600)
    with written_whole(path) as beside:
        assert stat.S_IMODE(beside.stat().st_mode) == 0o600
        beside.write_text("new")


@pytest.mark.parametrize("length", [250, 255])
def test_a_name_may_be_as_long_as_the_file_system_takes(tmp_path, length):
    path = tmp_path / ("ä" * ((length - 5) // 2) + ".json")
    write_file(path, "new")
    assert path.read_text() == "new"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everything")
def test_a_file_that_may_not_be_written_is_not_replaced(tmp_path):
    path = tmp_path / "result.json"
    write_file(path, "earlier")
    path.chmod(0o400)
    with pytest.raises(UnwritableFile, match="Permission denied"):
        write_file(path, "new")
    assert path.read_text() == "earlier"


def test_folders_above_are_made_and_a_file_among_them_is_named(tmp_path):
    write_new(tmp_path / "a" / "b" / "c.txt", "text")
    with pytest.raises(UnwritableFile, match=r"c\.txt/d\.txt"):
        write_new(tmp_path / "a" / "b" / "c.txt" / "d.txt", "text")


def test_a_pipe_is_written_to_and_stays(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    got = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_text()))
    reader.start()
    write_file(pipe, "text")
    reader.join()
    assert got == ["text"] and pipe.is_fifo()


def test_a_full_device_is_named_and_stays():
    device = Path("/dev/full")
    if not device.exists():
        pytest.skip("no /dev/full on this system")
    with pytest.raises(UnwritableFile, match="/dev/full: .*No space left on device"):
        write_file(device, "text")
    assert device.is_char_device()


# ---------------------------------------------------------------------- nothing goes past it
def writing_calls(tree):
    """Calls that write a file, but for those to a file that `written_whole` gave."""
    given = {
        item.optional_vars.id
        for node in ast.walk(tree)
        if isinstance(node, ast.With)
        for item in node.items
        if isinstance(item.context_expr, ast.Call)
        and getattr(item.context_expr.func, "attr", getattr(item.context_expr.func, "id", ""))
        == "written_whole"
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and writes(node, given):
            yield node.lineno


def writes(call, given):
    name = getattr(call.func, "attr", getattr(call.func, "id", ""))
    first, owner = call.args[0] if call.args else None, getattr(call.func, "value", None)
    if name == "open":
        modes = [a.value for a in call.args if isinstance(a, ast.Constant)]
        modes += [k.value.value for k in call.keywords if k.arg == "mode"]
        return any(isinstance(m, str) and len(m) < 4 and set(m) & set("wax+") for m in modes)
    if (isinstance(first, ast.Name) and first.id in given) or is_self(owner):
        return False
    return name in WRITERS and first is not None and not makes_text(call)


def is_self(owner):
    return isinstance(owner, ast.Name) and owner.id == "self"


def makes_text(call):
    """`yaml.dump(content)` without a stream returns the text."""
    return call.func.attr == "dump" and len(call.args) == 1


SOURCES = [
    path
    for room in ("src", "thesis", "scripts")
    for path in sorted((ROOT / room).rglob("*.py"))
    if path.name != "setup.py"
]


def test_results_are_written_by_this_module_alone():
    found = {
        f"{path.relative_to(ROOT)}:{line}"
        for path in SOURCES
        for line in writing_calls(ast.parse(path.read_text(encoding="utf-8")))
        if not path.as_posix().endswith(tuple(STREAMS))
    }
    assert not found, "to be written by softhand_common.documents.output_file"


def test_every_exception_still_writes():
    for ending in STREAMS:
        (path,) = [path for path in SOURCES if path.as_posix().endswith(ending)]
        assert list(writing_calls(ast.parse(path.read_text(encoding="utf-8")))), ending


@pytest.mark.parametrize(
    ("line", "count"),
    [
        ("path.write_text('x')", 1),
        ("open(path, 'w')", 1),
        ("path.open(mode='ab')", 1),
        ("figure.savefig(path)", 1),
        ("json.dump(content, stream)", 1),
        ("with path.open('x') as file: pass", 1),
        ("with written_whole(path) as file: figure.savefig(file)", 0),
        ("state = scene.save()", 0),
        ("text = yaml.dump(content, Dumper=Plain)", 0),
        ("path.open('rb')", 0),
    ],
)
def test_a_call_that_writes_is_seen(line, count):
    assert len(list(writing_calls(ast.parse(line)))) == count
