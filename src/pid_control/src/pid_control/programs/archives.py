"""Unpacking of students' archives, with limits, and only into one folder."""

import bz2
import gzip
import lzma
import os
import re
import shutil
import tarfile
import zipfile
from typing import IO, Any, Callable, Dict, Iterator, Optional, Tuple

#: Bounds of an archive: size of its content [bytes], and number of its members.
_LARGEST, _MOST = 200_000_000, 10_000
_ENDINGS = (".zip", ".tar", ".tar.gz", ".tgz", ".tar.bz2", ".tbz2", ".tar.xz", ".txz")
_CHUNK = 1 << 16
#: Decompressor of a file, by its first bytes.
_OPENERS: Dict[bytes, Callable[..., Any]] = {
    b"\x1f\x8b": gzip.open,
    b"BZh": bz2.open,
    b"\xfd7zXZ": lzma.open,
}
#: Letter of a drive at the start of a path of Windows.
_DRIVE = re.compile("[A-Za-z]:")


class ArchiveError(Exception):
    """Error of an archive that is not unpacked; the text gives the reason."""


def stem_of(name: str) -> str:
    """Return the name of an archive without its ending, any other name unchanged."""
    for ending in _ENDINGS:
        if name.lower().endswith(ending):
            return name[: -len(ending)]
    return name


def is_archive(path: str) -> bool:
    """Return True for a file with an archive's ending."""
    return os.path.isfile(path) and stem_of(path) != path


def unpack(path: str, target: str) -> None:
    """Unpack the files of an archive; skip links and devices.

    :param path: path of the archive
    :param target: folder, created
    :raises ArchiveError: if it is broken, encrypted, too large, or a path leads out of the folder
    """
    os.makedirs(target)
    left, count = _LARGEST, 0
    try:
        for name, mode, source in _files(path):
            count += 1
            if count > _MOST:
                raise ArchiveError(f"too many files (more than {_MOST})")
            if source is None:
                continue
            place = _place(target, name)
            os.makedirs(os.path.dirname(place), exist_ok=True)
            with source, open(place, "wb") as file:
                left = _copy(source, file, left)
            os.chmod(place, 0o600 | (mode & 0o111))
    except ArchiveError:
        shutil.rmtree(target, ignore_errors=True)
        raise
    except Exception as error:  # of any type: the modules do not check what they read
        shutil.rmtree(target, ignore_errors=True)
        raise ArchiveError(f"it cannot be unpacked: {error}") from None


class _SizeLimitedFile:
    """Unpacked content of a tar file; raises an error if it becomes too large.

    :param file: the content
    """

    def __init__(self, file: IO[bytes]) -> None:
        self._file, self._left = file, _LARGEST

    def read(self, size: int) -> bytes:
        """Return the next bytes.

        :param size: largest number of them
        :raises ArchiveError: if they are too many, together with those before
        """
        data = self._file.read(size)
        self._left -= len(data)
        _check(self._left)
        return data


def _files(path: str) -> Iterator[Tuple[str, int, Optional[IO[bytes]]]]:
    """Yield name, mode and content of each member; the content is None unless it is a file."""
    if path.lower().endswith(".zip"):
        with zipfile.ZipFile(path) as archive:
            for info in archive.infolist():
                mode = info.external_attr >> 16
                is_file = not info.is_dir() and mode & 0o170000 in (0, 0o100000)
                yield info.filename, mode, archive.open(info) if is_file else None
        return
    with open(path, "rb") as file:
        start = file.read(max(map(len, _OPENERS)))
    opener = next((_OPENERS[one] for one in _OPENERS if start.startswith(one)), open)
    with opener(path, "rb") as unpacked:
        # As a stream, which is read in small parts: a header may claim any size.
        content: Any = _SizeLimitedFile(unpacked)
        with tarfile.open(fileobj=content, mode="r|") as packed:
            for member in packed:
                source = packed.extractfile(member) if member.isfile() else None
                yield member.name, member.mode, source
        while content.read(_CHUNK):
            pass  # to its end, where the checksum is


def _place(target: str, name: str) -> str:
    parts = name.replace("\\", "/").split("/")
    if name.startswith(("/", "\\")) or ".." in parts or _DRIVE.match(name):
        raise ArchiveError(f"a path leads out of it ({name})")
    return os.path.join(target, *(part for part in parts if part not in ("", ".")))


def _copy(source: IO[bytes], file: IO[bytes], left: int) -> int:
    """Copy a file, and return how much more may be unpacked [bytes]."""
    while True:
        chunk = source.read(_CHUNK)  # not by the size that the archive claims
        left -= len(chunk)
        _check(left)
        if not chunk:
            return left
        file.write(chunk)


def _check(left: int) -> None:
    if left < 0:
        raise ArchiveError(f"too large (more than {_LARGEST // 1_000_000} MB)")
