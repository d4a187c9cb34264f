"""Anonymous memory that one process writes and others read, as file descriptors.

Both ends use ``mmap(2)``. The reader's mapping is made by the C library itself: Python's ``mmap``
objects keep a descriptor each, and cannot report the end of the last view of a message.
"""

import ctypes
import fcntl
import mmap
import os
from typing import Any, Sequence

_ADD_SEALS = getattr(fcntl, "F_ADD_SEALS", 1033)
#: SEAL, SHRINK, GROW, FUTURE_WRITE (Linux 5.1): only existing mappings may write; ``fcntl(2)``.
_SEALS = 1 | 2 | 4 | 16

_libc = ctypes.CDLL(None, use_errno=True)
_libc.mmap.restype = ctypes.c_void_p
_libc.mmap.argtypes = (
    *(ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int),
    *(ctypes.c_int, ctypes.c_int, ctypes.c_long),
)
_libc.munmap.argtypes = (ctypes.c_void_p, ctypes.c_size_t)
_FAILED = ctypes.c_void_p(-1).value


class WrittenMemory:
    """Memory that only this process can write.

    :param size: size [bytes]
    :raises OSError: if there is no memory or no descriptor left
    """

    def __init__(self, size: int) -> None:
        if not hasattr(os, "memfd_create"):  # a Python built with a C library before 2.27
            raise OSError("this Python has no memfd_create")
        self.size = size
        self.descriptor = os.memfd_create("nodekit", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.ftruncate(self.descriptor, size)
            self._map = mmap.mmap(self.descriptor, size)
            fcntl.fcntl(self.descriptor, _ADD_SEALS, _SEALS)
            # Otherwise a signal would end the process at the first write to full memory.
            os.posix_fallocate(self.descriptor, 0, size)
        except BaseException:
            os.close(self.descriptor)
            raise

    def write(self, parts: Sequence[Any]) -> None:
        """Write a message.

        :param parts: bytes-like objects, one after the other
        """
        position = 0
        for part in parts:
            end = position + len(part)
            self._map[position:end] = part
            position = end

    def close(self) -> None:
        """Close the memory, which readers may still have."""
        self._map.close()
        os.close(self.descriptor)


class ReadMemory:
    """Mapping of another process's memory, for reading; ends with the last view of it.

    :param descriptor: the memory's descriptor, which may be closed afterwards
    :raises OSError: if it cannot be mapped
    """

    def __init__(self, descriptor: int) -> None:
        self._address = 0
        self.size = os.fstat(descriptor).st_size
        address = _libc.mmap(None, self.size, mmap.PROT_READ, mmap.MAP_SHARED, descriptor, 0)
        if address == _FAILED:
            error = ctypes.get_errno()
            raise OSError(error, os.strerror(error))
        self._address = address

    def __del__(self) -> None:
        if self._address:
            _libc.munmap(self._address, self.size)

    def read(self, start: int, stop: int) -> bytes:
        """Return a copy of a part.

        :param start: its begin [bytes]
        :param stop: its end [bytes]
        """
        return ctypes.string_at(self._address + start, stop - start)

    def view(self, start: int, stop: int, kept: object) -> memoryview:
        """Return a read-only view of a part.

        :param start: its begin [bytes]
        :param stop: its end [bytes]
        :param kept: kept as long as any view of this part exists, such as a slice or an array
        """
        part: Any = (ctypes.c_ubyte * (stop - start)).from_address(self._address + start)
        part.kept = (self, kept)
        return memoryview(part).toreadonly().cast("B")
