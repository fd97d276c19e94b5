"""Writers of a film: a folder of PNG files, a GIF or an MP4."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryFile
from types import ModuleType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]  # (height, width, 3)

GIF_FASTEST = 50.0  # pictures a second; viewers slow down what is faster
PALETTE_SAMPLES = 6  # pictures that the colours of a GIF are taken from
MP4_CODEC, MP4_QUALITY = "libx264", 8


class Film(Protocol):
    """Takes pictures one by one; `close` finishes the file."""

    def add(self, picture: Picture) -> None:
        """Append a picture."""

    def close(self) -> None:
        """Write what is left to write."""


def open_film(path: Path, fps: float, size: tuple[int, int], force: bool = False) -> Film:
    """A film by the suffix of its path: `.gif`, `.mp4`, or none for a folder of PNG files.

    Nothing stays written before the first picture.

    Raises:
        ValueError: another suffix, a path that is taken (unless `force`) or cannot be written, a
            number of pictures a second or a size [pixels] that the format cannot have, or a library
            that is missing.
    """
    suffix = path.suffix.lower()
    if suffix not in KINDS:
        raise ValueError(f"-o {path}: expected a folder, .gif or .mp4, got {suffix}")
    if path.exists() and path.is_dir() != (suffix == ""):
        raise ValueError(f"-o {path}: expected a {'file' if suffix else 'folder'}, got the other")
    if path.exists() and not force:
        raise ValueError(
            f"-o {path}: expected a new path, got one that exists; --force overwrites it"
        )
    _try_to_write(path, path.parent if suffix else path)
    return KINDS[suffix](path, fps, size)


def _try_to_write(path: Path, folder: Path) -> None:
    """Raise ValueError unless a file can be made in the folder, and an earlier film overwritten;
    what is made to find out is removed.
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
    """One PNG file a picture, `frame_0000.png` and on; those of an earlier film are removed."""

    def __init__(self, path: Path, fps: float, size: tuple[int, int]) -> None:
        self._image = _pillow(path)
        self._folder, self._count = path, 0

    def add(self, picture: Picture) -> None:
        """Write a picture."""
        if self._count == 0:
            self._folder.mkdir(parents=True, exist_ok=True)
            for old in self._folder.glob("frame_[0-9]*.png"):
                old.unlink()
        self._image.fromarray(picture).save(self._folder / f"frame_{self._count:04d}.png")
        self._count += 1

    def close(self) -> None:
        """Nothing is left to write."""


class Gif:
    """An endless GIF with one palette for all pictures: with one each, still parts flicker."""

    def __init__(self, path: Path, fps: float, size: tuple[int, int]) -> None:
        self._image = _pillow(path)
        if fps > GIF_FASTEST:
            raise ValueError(f"fps: expected at most {GIF_FASTEST:g} for a GIF, got {fps:g}")
        self._path, self._fps = path, fps
        self._pictures: list[Picture] = []

    def add(self, picture: Picture) -> None:
        """Keep a picture until all are known."""
        self._pictures.append(picture)

    def close(self) -> None:
        """Choose the colours and write the file."""
        if not self._pictures:
            return
        chosen = np.linspace(0, len(self._pictures) - 1, PALETTE_SAMPLES).round().astype(int)
        sample = self._image.fromarray(np.vstack([self._pictures[k] for k in chosen]))
        palette = sample.quantize(256)
        first, *others = [
            self._image.fromarray(picture).quantize(palette=palette, dither=0)
            for picture in self._pictures
        ]
        self._path.parent.mkdir(parents=True, exist_ok=True)
        durations = gif_durations(len(self._pictures), self._fps)
        first.save(self._path, save_all=True, append_images=others, duration=durations, loop=0)


def gif_durations(count: int, fps: float) -> list[int]:
    """How long each of `count` pictures stays [ms]: whole hundredths of a second, as a GIF has
    them, which together keep the pace.

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
        self._stream: Generator[None, Any, None] | None = None

    def add(self, picture: Picture) -> None:
        """Hand a picture to ffmpeg."""
        if self._stream is None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._stream = self._ffmpeg.write_frames(
                str(self._path),
                self._size,
                fps=self._fps,
                codec=MP4_CODEC,
                quality=MP4_QUALITY,
                macro_block_size=2,
            )
            self._stream.send(None)
        self._stream.send(np.ascontiguousarray(picture))

    def close(self) -> None:
        """Let ffmpeg finish the file."""
        if self._stream is not None:
            self._stream.close()


KINDS: dict[str, type[PngFolder] | type[Gif] | type[Mp4]] = {
    "": PngFolder,
    ".gif": Gif,
    ".mp4": Mp4,
}


def _pillow(path: Path) -> ModuleType:
    try:
        from PIL import Image
    except ImportError as error:
        raise ValueError(f"{path}: needs Pillow: pip install pillow") from error
    return Image


def _ffmpeg(path: Path) -> ModuleType:
    try:
        import imageio_ffmpeg
    except ImportError as error:
        raise ValueError(
            f"{path}: needs imageio-ffmpeg: pip install imageio-ffmpeg; a .gif does not"
        ) from error
    return imageio_ffmpeg
