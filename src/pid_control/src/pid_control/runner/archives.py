"""Archives of students: unpacked with bounds, and never outside of a folder."""

import os
import shutil
import tarfile
import zipfile
from typing import IO, Iterator, Tuple

#: Bounds of an archive: size of its content [bytes], and number of its files.
_LARGEST, _MOST = 200_000_000, 10_000
_ENDINGS = (".zip", ".tar", ".tar.gz", ".tgz", ".tar.bz2", ".tbz2", ".tar.xz", ".txz")
_CHUNK = 1 << 16


class ArchiveError(Exception):
    """An archive is not unpacked; the message says why."""


def stem_of(name: str) -> str:
    """Return the name of an archive without its ending, any other name as it is."""
    for ending in _ENDINGS:
        if name.lower().endswith(ending):
            return name[: -len(ending)]
    return name


def is_archive(path: str) -> bool:
    """Return True for a file that is called like an archive."""
    return os.path.isfile(path) and stem_of(path) != path


def unpack(path: str, target: str) -> None:
    """Unpack the files of an archive; links and devices are left out.

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
            place = _place(target, name)
            os.makedirs(os.path.dirname(place), exist_ok=True)
            with source, open(place, "wb") as file:
                left = _copy(source, file, left)
            os.chmod(place, 0o600 | (mode & 0o111))
    except ArchiveError:
        shutil.rmtree(target, ignore_errors=True)
        raise
    except Exception as error:  # of any kind: the modules do not check what they read
        shutil.rmtree(target, ignore_errors=True)
        raise ArchiveError(f"it cannot be unpacked: {error}") from None


def _files(path: str) -> Iterator[Tuple[str, int, IO[bytes]]]:
    if path.lower().endswith(".zip"):
        with zipfile.ZipFile(path) as archive:
            for info in archive.infolist():
                mode = info.external_attr >> 16
                if not info.is_dir() and mode & 0o170000 in (0, 0o100000):
                    yield info.filename, mode, archive.open(info)
        return
    with tarfile.open(path) as packed:
        for member in packed:
            source = packed.extractfile(member) if member.isfile() else None
            if source is not None:
                yield member.name, member.mode, source


def _place(target: str, name: str) -> str:
    parts = name.replace("\\", "/").split("/")
    if name.startswith(("/", "\\")) or ".." in parts or ":" in parts[0]:
        raise ArchiveError(f"a path leads out of it ({name})")
    return os.path.join(target, *(part for part in parts if part not in ("", ".")))


def _copy(source: IO[bytes], file: IO[bytes], left: int) -> int:
    """Copy a file, and return how much more may be unpacked [bytes]."""
    while True:
        chunk = source.read(_CHUNK)  # not by the size that the archive claims
        left -= len(chunk)
        if left < 0:
            raise ArchiveError(f"too large (more than {_LARGEST // 1_000_000} MB)")
        if not chunk:
            return left
        file.write(chunk)
