"""Settings of these unit tests, which pytest reads before any of them imports numpy."""

import os

# The matrices of a fit are small: further threads of OpenBLAS only spin while they wait.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
