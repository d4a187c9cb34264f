"""The soak's modules are scripts beside each other, not a package: find them."""

import pathlib
import sys

CI = pathlib.Path(__file__).resolve().parents[2]

sys.path[:0] = [str(CI / "endurance"), str(CI / "benchmark"), str(CI / "lib")]
