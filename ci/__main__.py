"""Run one of the project's modules: ``python3 ci FOLDER.MODULE [ARGUMENT…]``."""

import pathlib
import runpy
import sys

if __name__ == "__main__":
    # The folder ci itself must not be searched: its folders are packages of ``ci``.
    sys.path[0] = str(pathlib.Path(__file__).resolve().parents[1])
    del sys.argv[0]
    runpy.run_module(f"ci.{sys.argv[0]}", run_name="__main__", alter_sys=True)
