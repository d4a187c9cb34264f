#!/usr/bin/env python3
"""A managed node that says what is called; ``hang:=NAME`` hangs in a callback."""

import sys
import time

from nodekit import Lifetime, ManagedNode, run


class Driver(ManagedNode):
    def note(self, name: str) -> None:
        print(name, self.previous_state.label, flush=True)
        if f"hang:={name}" in sys.argv:
            time.sleep(60.0)

    def on_configure(self, made: Lifetime) -> None:
        self.note("on_configure")

    def on_activate(self, made: Lifetime) -> None:
        self.note("on_activate")

    def on_shutdown(self) -> None:
        self.note("on_shutdown")


if __name__ == "__main__":
    run("driver", Driver)
