#!/usr/bin/env python3
"""Ctrl-C at any moment of a node's life ends it cleanly; moments drawn with a fixed seed."""

import unittest

import rosgraph
from helpers.interrupt_rounds import interrupt_rounds
from helpers.machine_lag import measured_lag

from nodekit.testing.graph import Graph
from nodekit.testing.running import rosrun

PROGRAMS = ("talker.py", "listener.py", "signal_generator.py", "process.py", "fleet")
ROUNDS = 15
#: Longest shutdown on an idle machine [s].
END = 2.0


class Interrupts(unittest.TestCase):
    """Nodes that are interrupted after up to a second."""

    def test_any_moment(self) -> None:
        graph = Graph()
        with measured_lag() as lag:
            ends = interrupt_rounds(PROGRAMS, ROUNDS, seed=7)
        self.assertEqual([end for end in ends if not end.clean and not end.early], [])
        # Python's own startup is the margin of "too early".
        self.assertEqual([end for end in ends if end.early and end.from_our_lines], [])
        self.assertEqual([end.imported_too_soon for end in ends if end.imported_too_soon], [])
        self.assertEqual(graph.nodes(), set())
        self.assert_no_name_is_known()
        longest = max(end.seconds for end in ends)
        print(f"longest end: {longest:.2f} s")
        self.assertLess(longest, lag.allowed(END))

    def assert_no_name_is_known(self) -> None:
        """Check that the master has forgotten them all, subscriptions of parameters included."""
        for program in PROGRAMS:
            with self.subTest(program=program), self.assertRaises(rosgraph.MasterError):
                rosgraph.Master("/test").lookupNode("/" + program.partition(".")[0])


if __name__ == "__main__":
    rosrun("basic_comms", "interrupts", Interrupts)
