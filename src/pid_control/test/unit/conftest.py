"""Settings of the unit tests, which pytest reads before a test imports numpy, and a fixture."""

import os
from typing import Iterator

import pytest

# The matrices of a fit are small: further threads of OpenBLAS only spin while they wait.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@pytest.fixture
def typed() -> Iterator[None]:
    """Let this process have an input, which no program of a student may read."""
    before, (read, write) = os.dup(0), os.pipe()
    os.write(write, b"typed\n")
    os.dup2(read, 0)
    yield
    os.dup2(before, 0)
    for descriptor in (before, read, write):
        os.close(descriptor)
