"""Main function of a node's process: starts and spins the node, and sets the exit status."""

import importlib
import os
import sys
import threading
import time
from typing import Any, Callable, List

import rospy

from nodekit.argument_checks import check_function, check_name
from nodekit.entry_point import end
from nodekit.master import MasterClient, MasterUnreachable
from nodekit.node.clients import client_names
from nodekit.node.name_rules import IllegalName
from nodekit.node.ros_node import Node
from nodekit.parameter_server.watcher import get_watcher
from nodekit.parameters.declaration import OwnParameters
from nodekit.parameters.parameter_types import ParameterError
from nodekit.process import arguments, launch_arguments, own_address
from nodekit.process.constructor_watch import ConstructorWatch
from nodekit.process_context import PROCESS
from nodekit.rospy_internals import registration_listener, shared_memory_offers, startup
from nodekit.rospy_internals.registry import NameTaken, all_entries

#: A node's class, or a function that returns its object.
NodeClass = Callable[[Node], object]

#: Exit status of a process whose start is refused, or that aborts.
EXIT_REFUSED = 1

#: Errors that end the start in one sentence.
_START_ERRORS = (
    arguments.ArgumentError,
    own_address.AddressError,
    IllegalName,
    NameTaken,
    ParameterError,
)

#: Longest wait for a running start when the node has to end [s].
_START_WAIT_S = 1.0


def run(name: str, cls: NodeClass) -> None:
    """Run a node until it is shut down, then end the process.

    The exit status is 0 after SIGINT, SIGTERM, SIGHUP or ``rosnode kill``, and 1
    if the start was refused because of an argument, a name, an address, a parameter or
    an unreachable master, or if the node called :func:`abort`.

    :param name: name of the node unless ``__name`` is given
    :param cls: the node's class, called with the process's :class:`.Node`
    :raises TypeError: if the name is not text, or the class not callable
    """
    check_name(name, "run: name, which comes first")
    check_function(cls, "run: class", 1)
    try:
        arguments.check(rospy.names.get_mappings().get("__name", name), os.environ, sys.argv)
        own_address.default_to_loopback(os.environ, sys.argv)
        own_address.check()
        startup.register_signals()
        _tighten_timer_slack()
        _wait_for_master(name)
        kept_alive = _start_beside(name, cls)
        if not rospy.is_shutdown():
            rospy.spin()
        del kept_alive
    except _START_ERRORS as error:
        rospy.logfatal("%s", error)
        end(EXIT_REFUSED)
    except MasterUnreachable as error:
        rospy.logfatal("the master stopped answering during the start: %s", error)
        end(EXIT_REFUSED)
    except KeyboardInterrupt:
        pass  # Ctrl-C before rospy took over the signal
    end(PROCESS.exit_status)


def abort(why: object) -> None:
    """End the process with status 1, after a start that succeeded.

    :param why: the reason in one sentence, which is logged
    """
    PROCESS.exit_status = EXIT_REFUSED
    rospy.logfatal("%s", why)
    rospy.signal_shutdown(str(why))


def init_node(name: str) -> Node:
    """Make this process a node of the graph; its class is created and started next.

    :func:`run` does this; a test with a node in its own process calls it instead of
    ``rospy.init_node``.

    :param name: name of the node unless ``__name`` is given
    :returns: the node, an argument of its class
    :raises MasterUnreachable: if the master does not respond
    """
    own_address.default_to_loopback(os.environ, sys.argv)
    startup.apply_patches()
    with startup.fast_init_poll():
        rospy.init_node(name, disable_signals=True)
    # The watcher also registers the node again after a restart of the master.
    registration_listener.install(get_watcher().client.request)
    return Node()


def _tighten_timer_slack() -> None:
    """Make the kernel wake threads on time, instead of up to 50 us late to save energy.

    Applies to the calling thread and those it starts from now on, see ``proc(5)``. Nothing changes
    if the kernel has no such setting.
    """
    try:
        with open("/proc/self/timerslack_ns", "w") as slack:
            slack.write("1")
    except OSError:
        pass


def _wait_for_master(name: str) -> None:
    """Wait until the master responds or the node has to end.

    ``rospy.init_node`` waits too, but holds a lock that its signal handler needs.
    """
    is_logged = False
    with MasterClient("/" + name, timeout=1.0) as master:
        while not rospy.is_shutdown():
            try:
                master.read([])
                return
            except MasterUnreachable as error:
                if not is_logged:
                    rospy.logwarn("waiting for the master: %s", error)
                    is_logged = True
                time.sleep(0.1)


def _start_beside(name: str, cls: NodeClass) -> List[object]:
    """Start a node in another thread, so that this thread can handle signals.

    rospy handles a signal by a request to the master, over a connection with a lock. A thread
    that is registering a topic over that connection would deadlock.

    :returns: the node and the object of its class; empty if a signal arrived first
    :raises Exception: from the start, unless the node is shutting down
    """
    watch = ConstructorWatch()
    made: List[object] = []
    errors: List[BaseException] = []

    def work() -> None:
        try:
            node = init_node(name)
            for warning in launch_arguments.warnings():
                rospy.logwarn("%s", warning)
            with get_watcher().reading_ahead([node.name]) as held:
                selected = selected_class(cls, node.name, held[node.name])
                with watch.running():
                    made.extend([node, selected(node)])
            node.start()
            for warning in _misspelt_settings(node) + arguments.surprising_values(sys.argv):
                rospy.logwarn("%s", warning)
        except BaseException as error:
            errors.append(error)

    worker = threading.Thread(target=work, name="start", daemon=True)
    worker.start()
    while worker.is_alive() and not rospy.is_shutdown():
        worker.join(0.1)
        watch.warn_if_waiting()
    worker.join(_START_WAIT_S)
    if errors and not rospy.is_shutdown():
        raise errors[0]
    return made


def _misspelt_settings(node: Node) -> List[str]:
    """Return a warning for each argument that looks like a setting of a started node."""
    live = node._context.live
    declared = live.declaration.declared if live is not None else {}
    names = client_names().union(name for _, name, _ in all_entries())
    return arguments.misspelt_settings(
        sys.argv, declared, lambda name: rospy.resolve_name(name) in names
    )


def selected_class(cls: NodeClass, node: str, held: Any) -> NodeClass:
    """Return a node's class, or a managed node's class that creates it at configure.

    A node with ``transport`` set to ``tcp`` has its whole process use TCP only.

    :param cls: the class
    :param node: global name of the node
    :param held: raw value of its private parameters; ``managed`` selects the class
    :raises ParameterError: if ``managed`` is not a truth value, or ``transport`` not a valid word
    """
    known = OwnParameters.declared
    given = {name: held[name] for name in known if name in held} if isinstance(held, dict) else {}
    try:
        own = OwnParameters(**given)
    except ParameterError as error:
        raise error.in_namespace(node) from None
    if own.transport == "tcp":
        shared_memory_offers.disable()
    if not own.managed:
        return cls
    # Imported only if needed: it takes time and memory.
    wrapped: NodeClass = importlib.import_module("nodekit.managed.managed_adapter").managed_class(
        cls
    )
    return wrapped
