"""Settings of the unit tests; pytest reads them before a test imports numpy."""

import os

# The matrices of a fit are small: further threads of OpenBLAS only spin while they wait.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
