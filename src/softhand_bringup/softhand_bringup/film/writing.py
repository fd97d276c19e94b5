"""Writers of a film: a folder of PNG files, a GIF or an MP4."""

from __future__ import annotations

import os
import shutil
from collections.abc import Generator
from contextlib import ExitStack, suppress
from pathlib import Path
from tempfile import TemporaryFile
from types import ModuleType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from softhand_common.documents.output_file import UnwritableFile, named, written_whole

Picture = NDArray[np.uint8]  # (height, width, 3)

GIF_FASTEST = 50.0  # [frames/s]; viewers play faster ones slowly
PALETTE_SAMPLES = 6  # frames from which the colours of a GIF are chosen
MP4_CODEC, MP4_QUALITY = "libx264", 8
NO_ROOM = "ffmpeg could not write it: is there room on the disk?"


class Film(Protocol):
    """A film that is written frame by frame; a context manager. When the block ends, the film
    replaces an earlier one; if the block raises, the earlier film is kept. Raises ValueError when
    it cannot be written.
    """

    def add(self, picture: Picture) -> None:
        """Append a frame."""

    def __enter__(self) -> Film: ...

    def __exit__(self, kind: type[BaseException] | None, *rest: Any) -> None: ...


def open_film(path: Path, fps: float, size: tuple[int, int], force: bool = False) -> Film:
    """A film in the format of its path's suffix: `.gif`, `.mp4`, or none for a folder of PNG files.
    `size` is (width, height) [pixels].

    Nothing is left on the disk before the first frame.

    Raises:
        ValueError: another suffix, a path that exists (unless `force`) or cannot be written, a
            frame rate [1/s] or a size [pixels] that the format does not support, or a missing
            library.
    """
    suffix = path.suffix.lower()
    if suffix not in FILM_WRITERS:
        raise ValueError(f"-o {path}: expected a folder, .gif or .mp4, got {suffix}")
    if path.exists() and path.is_dir() != (suffix == ""):
        kinds = ("file", "folder") if suffix else ("folder", "file")
        raise ValueError(f"-o {path}: expected a {kinds[0]}, got a {kinds[1]} of that name")
    if path.exists() and not force:
        raise ValueError(
            f"-o {path}: expected a new path, got one that exists; --force overwrites it"
        )
    _try_to_write(path, path.parent if suffix else path)
    return FILM_WRITERS[suffix](path, fps, size)


def _try_to_write(path: Path, folder: Path) -> None:
    """Raise ValueError unless a file can be made in the folder and an earlier film overwritten;
    folders and files made for this check are removed.
    """
    missing = [part for part in (folder, *folder.parents) if not part.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):
            pass
        if path.is_file():
            path.open("ab").close()
    except OSError as error:
        raise ValueError(
            f"-o {path}: expected a place that can be written, got: {error.strerror}"
        ) from error
    finally:
        for part in missing:
            with suppress(OSError):
                part.rmdir()


class PngFolder:
    """A PNG file for each frame, `frame_0000.png` and so on; files of an earlier film are
    replaced.
    """

    def __init__(self, path: Path, fps: float, size: tuple[int, int]) -> None:
        self._image = _pillow(path)
        self._folder, self._count = path.resolve(), 0
        self._beside = self._folder.with_name(f"{self._folder.name}.part-{os.getpid()}")

    def add(self, picture: Picture) -> None:
        """Write a frame into a temporary folder."""
        with named(self._folder):
            self._beside.mkdir(parents=True, exist_ok=True)
            self._image.fromarray(picture).save(self._beside / f"frame_{self._count:04d}.png")
        self._count += 1

    def __enter__(self) -> PngFolder:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_rest: Any) -> None:
        """Move the frames into the folder, unless the block raised."""
        try:
            if kind is None and self._count:
                with named(self._folder):
                    self._replace()
        finally:
            shutil.rmtree(self._beside, ignore_errors=True)

    def _replace(self) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)
        for old in self._folder.glob("frame_[0-9]*.png"):
            old.unlink()
        for picture in self._beside.iterdir():
            picture.replace(self._folder / picture.name)


class Gif:
    """An endless GIF with one palette for all frames; with a palette for each frame, parts that do
    not move would flicker.
    """

    def __init__(self, path: Path, fps: float, size: tuple[int, int]) -> None:
        self._image = _pillow(path)
        if fps > GIF_FASTEST:
            raise ValueError(f"fps: expected at most {GIF_FASTEST:g} for a GIF, got {fps:g}")
        self._path, self._fps = path, fps
        self._pictures: list[Picture] = []

    def add(self, picture: Picture) -> None:
        """Keep a frame until all frames are known."""
        self._pictures.append(picture)

    def __enter__(self) -> Gif:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_rest: Any) -> None:
        """Choose the colours and write the file."""
        if kind is not None or not self._pictures:
            return
        chosen = np.linspace(0, len(self._pictures) - 1, PALETTE_SAMPLES).round().astype(int)
        sample = self._image.fromarray(np.vstack([self._pictures[k] for k in chosen]))
        palette = sample.quantize(256)
        first, *others = [
            self._image.fromarray(picture).quantize(palette=palette, dither=0)
            for picture in self._pictures
        ]
        durations = gif_durations(len(self._pictures), self._fps)
        with written_whole(self._path) as file:
            first.save(file, save_all=True, append_images=others, duration=durations, loop=0)


def gif_durations(count: int, fps: float) -> list[int]:
    """Duration of each of `count` frames [ms], in whole hundredths of a second as a GIF has them,
    such that errors do not add up.

    >>> gif_durations(3, 30.0)
    [30, 40, 30]
    """
    ends = np.round(100.0 * np.arange(count + 1) / fps)
    return (10 * np.diff(ends)).astype(int).tolist()


class Mp4:
    """An MP4 (H.264) by ffmpeg."""

    def __init__(self, path: Path, fps: float, size: tuple[int, int]) -> None:
        self._ffmpeg = _ffmpeg(path)
        if any(length % 2 for length in size):
            raise ValueError(f"size: expected even numbers for an MP4, got {size[0]}x{size[1]}")
        self._path, self._fps, self._size = path, fps, size
        self._file, self._beside, self._count = ExitStack(), path, 0
        self._stream: Generator[None, Any, None] | None = None

    def add(self, picture: Picture) -> None:
        """Pass a frame to ffmpeg."""
        if self._stream is None:
            self._beside = self._file.enter_context(written_whole(self._path))
            self._stream = self._ffmpeg.write_frames(
                str(self._beside),
                self._size,
                fps=self._fps,
                codec=MP4_CODEC,
                quality=MP4_QUALITY,
                ffmpeg_log_level="fatal",  # errors are reported here
                macro_block_size=2,
            )
            self._stream.send(None)
        try:
            self._stream.send(np.ascontiguousarray(picture))
        except OSError as reason:  # ffmpeg has ended; its own message shows only the command
            raise UnwritableFile(self._path, OSError(NO_ROOM)) from reason
        self._count += 1

    def __enter__(self) -> Mp4:
        return self

    def __exit__(self, *reason: Any) -> None:
        """Let ffmpeg finish the file, and check that it has all frames."""
        if self._stream is None:
            return
        self._stream.close()
        if reason[0] is not None:
            self._file.__exit__(*reason)  # removes the incomplete file
            return
        with self._file:
            self._check()

    def _check(self) -> None:
        """Raise UnwritableFile unless the file has all frames: ffmpeg reports no full disk."""
        try:
            count, _ = self._ffmpeg.count_frames_and_secs(self._beside)
        except RuntimeError:  # not a film
            count = 0
        if count != self._count:
            raise UnwritableFile(self._path, OSError(NO_ROOM))


FILM_WRITERS: dict[str, type[PngFolder] | type[Gif] | type[Mp4]] = {
    "": PngFolder,
    ".gif": Gif,
    ".mp4": Mp4,
}


def _pillow(path: Path) -> ModuleType:
    try:
        from PIL import Image
    except ImportError as error:
        raise ValueError(
            f"{path}: expected the package Pillow, got none: pip install pillow"
        ) from error
    return Image


def _ffmpeg(path: Path) -> ModuleType:
    try:
        import imageio_ffmpeg
    except ImportError as error:
        raise ValueError(
            f"{path}: expected the package imageio-ffmpeg, got none: "
            "pip install imageio-ffmpeg, or write a .gif"
        ) from error
    return imageio_ffmpeg
