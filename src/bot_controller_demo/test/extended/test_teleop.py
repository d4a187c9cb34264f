#!/usr/bin/env python3
"""Teleoperation by the keys of a terminal, which the test plays."""

import os
import signal
import subprocess
import sys
import termios
import unittest
from typing import Any, List

import rospy
from geometry_msgs.msg import Twist

from nodekit import ParameterClient
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.processes import Process
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../scripts/teleop_keyboard")


class Terminal:
    """A terminal with the node in it.

    :param arguments: of the node's command line
    """

    def __init__(self, *arguments: str) -> None:
        self.keyboard, self.screen = os.openpty()
        self.before = termios.tcgetattr(self.screen)
        self._said = ""
        os.set_blocking(self.keyboard, False)
        self.popen = subprocess.Popen(
            [sys.executable, SCRIPT, *arguments],
            stdin=self.screen,
            stdout=self.screen,
            stderr=self.screen,
            start_new_session=True,
        )

    def said(self) -> str:
        """Return all that the screen has shown."""
        try:
            self._said += os.read(self.keyboard, 65536).decode()
        except OSError:
            pass
        return self._said

    def wait_for(self, text: str) -> None:
        wait_until(lambda: text in self.said(), lambda: self._said)

    def type(self, keys: str) -> None:
        """Press keys."""
        os.write(self.keyboard, keys.encode())

    def mode(self) -> List[Any]:
        return termios.tcgetattr(self.screen)

    def wait(self) -> int:
        """Wait for the end; return the exit status."""
        wait_until(lambda: [self.said(), self.popen.poll() is not None][1], lambda: "it runs on")
        return self.popen.wait(TIMEOUT_S)

    def close(self) -> None:
        self.popen.kill()
        self.popen.wait(TIMEOUT_S)
        for descriptor in (self.keyboard, self.screen):
            try:
                os.close(descriptor)
            except OSError:
                pass


class Teleop(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_teleop")
        cls.graph = Graph()

    def terminal(self, *arguments: str) -> Terminal:
        terminal = Terminal(*arguments)
        self.addCleanup(terminal.close)
        return terminal

    def wait_for_recorder(self, namespace: str) -> None:
        """Wait until the test is connected to a node's topic."""
        node, topic = namespace + "/teleop_keyboard", namespace + "/cmd_vel"
        self.graph.wait_until_heard(node, topic, rospy.get_name())

    def test_keys_drive_within_limits_and_each_release_is_one_zero(self) -> None:
        """Course 001-robot-7."""
        recorder = MessageRecorder("/one/cmd_vel", Twist)
        terminal = self.terminal("__ns:=one", "_speed:=0.22", "_first_timeout:=10.0")

        def heard() -> List[Any]:
            return [(twist.linear.x, twist.angular.z) for twist in recorder.messages()]

        def released() -> bool:
            return heard()[-1:] == [(0.0, 0.0)]

        def release() -> None:
            """Have the node count the key as released, however late this process looks."""
            parameters.change({"first_timeout": 0.1})
            wait_until(released, lambda: str(heard()))
            parameters.change({"first_timeout": 10.0})

        terminal.wait_for("speed 0.22 m/s, turn 1 rad/s")
        terminal.wait_for("first_timeout=10")  # the settings: from here on it repeats commands
        self.wait_for_recorder("/one")
        self.assertEqual(heard(), [])
        parameters = ParameterClient("/one/teleop_keyboard", TIMEOUT_S)
        terminal.type("i")
        wait_until(lambda: len(heard()) > 2, lambda: f"only {heard()}")
        release()
        self.assertEqual(set(heard()[:-1]), {(0.22, 0.0)})
        terminal.type("z")
        terminal.wait_for("speed 0.198 m/s, turn 0.9 rad/s")
        self.graph.wait_for_parameters("/one/teleop_keyboard", {"speed": 0.22 * 0.9, "turn": 0.9})
        terminal.type("m")
        wait_until(lambda: heard()[-1] == (-0.22 * 0.9, -0.9), lambda: str(heard()))
        release()
        self.graph.set_parameter("/one/teleop_keyboard/speed", 99.0)
        terminal.wait_for("speed must be at most 0.22 m/s")
        self.graph.wait_for_parameters("/one/teleop_keyboard", {"speed": 0.22 * 0.9})
        self.graph.set_parameter("/one/teleop_keyboard/model", "waffle")
        self.graph.set_parameter("/one/teleop_keyboard/speed", 0.25)
        terminal.wait_for("speed 0.25 m/s, turn 0.9 rad/s")
        terminal.type("i")
        wait_until(lambda: heard()[-1] == (0.25, 0.0), lambda: str(heard()))
        terminal.type("\x1b[A")  # an arrow: one key, which stops
        wait_until(released, lambda: str(heard()))
        self.assertEqual(heard().count((0.0, 0.0)), 3)
        # Ctrl-Z, Ctrl-S and Ctrl-\ would leave the robot driving: they count as keys, and stop it.
        mode = terminal.mode()
        self.assertEqual([mode[6][key] for key in (termios.VQUIT, termios.VSUSP)], [b"\0"] * 2)
        self.assertEqual(mode[0] & termios.IXON, 0)
        for key in ("\x1a", "\x13", "\x1c"):
            recorder.clear()
            terminal.type("i")
            wait_until(heard, lambda: "it stays")
            terminal.type(key)
            wait_until(released, lambda: str(heard()))
        terminal.type("j")
        wait_until(lambda: heard()[-1] == (0.0, 0.9), lambda: str(heard()))
        terminal.popen.send_signal(signal.SIGINT)
        self.assertEqual(terminal.wait(), 0)
        wait_until(released, lambda: str(heard()))

    def test_terminal_is_given_back_at_every_end(self) -> None:
        names = ("interrupt", "terminate", "kill", "refused")
        dying = {"quit": signal.SIGQUIT, "abort": signal.SIGABRT, "end": signal.SIGKILL}
        terminals = {
            name: self.terminal(
                "__ns:=ends", f"__name:={name}", f"_rate:={-1 if name == 'refused' else 20}"
            )
            for name in (*names, *dying)
        }
        self.assertEqual(terminals["refused"].wait(), 1)
        self.assertIn("parameter /ends/refused/rate: refused -1", terminals["refused"].said())
        alive = (*names[:3], *dying)
        for name in alive:
            terminals[name].wait_for("turn 1 rad/s")
            terminals[name].wait_for("rad/s\r\n")
            self.assertNotEqual(terminals[name].mode(), terminals[name].before)
        self.graph.wait_for_nodes(*("/ends/" + name for name in alive), under="/ends/")
        terminals["interrupt"].popen.send_signal(signal.SIGINT)
        terminals["terminate"].popen.send_signal(signal.SIGTERM)
        self.graph.kill("/ends/kill")
        for name in names:
            self.assertEqual(terminals[name].wait(), 1 if name == "refused" else 0, name)
            self.assertEqual(terminals[name].mode(), terminals[name].before, name)
            self.assertNotIn("Traceback", terminals[name].said())
        for name, number in dying.items():
            terminals[name].popen.send_signal(number)
            self.assertEqual(terminals[name].wait(), -number)
            wait_until(
                lambda name=name: terminals[name].mode() == terminals[name].before,
                lambda name=name: f"after {name}: {terminals[name].mode()}",
            )

    def test_terminal_that_is_closed_stops_the_robot_and_ends_the_node(self) -> None:
        recorder = MessageRecorder("/two/cmd_vel", Twist)
        terminal = self.terminal("__ns:=two", "_first_timeout:=10.0", "_controller_type:=rviz")
        terminal.wait_for("turn 1 rad/s")
        self.wait_for_recorder("/two")
        terminal.type("i")
        recorder.wait_for(lambda twist: twist.linear.x == 0.2)
        os.close(terminal.screen)
        os.close(terminal.keyboard)
        self.assertEqual(terminal.popen.wait(TIMEOUT_S), 0)
        wait_until(lambda: recorder.messages()[-1] == Twist(), lambda: "it drives on")

    def test_without_a_terminal_it_says_so(self) -> None:
        process = Process(SCRIPT)
        self.addCleanup(process.end)
        self.assertEqual(process.wait(), 1)
        self.assertEqual(len(process.error_lines), 1)
        self.assertIn("standard input is not a terminal", process.error_lines[0])


if __name__ == "__main__":
    rosrun("bot_controller_demo", "teleop", Teleop)
