"""Several nodes in one process, with a common executor."""

from executors_demo.demo import Demo, ExecutorParameters, period_of, sleep_of
from nodekit import Node, ParameterSet, run

NAMES = ("camera", "lidar", "planner")


class MemberParameters(ParameterSet):
    """Parameters of each of the nodes."""

    period = period_of(1.0, "its timer")
    sleep = sleep_of(0.3, "its timer")


class SeveralNodes(Demo[ExecutorParameters]):
    """Host of the nodes ``camera``, ``lidar`` and ``planner``; one executor calls their timers.

    By default, the callbacks of one node exclude each other, those of two nodes do not. So with
    four threads the nodes work in parallel, and with ``_executor:=single`` one after the other.

    :ROS Services:
        - ``~executor`` (std_srvs/Trigger), also of each hosted node

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.ExecutorParameters`
        - of each hosted node: see :class:`MemberParameters`
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node, ExecutorParameters)
        for name in NAMES:
            self.add_node(node.host(name, "", lambda member: Member(member, self)))


class Member:
    """Node with one timer.

    :ROS Parameters:
        - private, can be changed at run time: see :class:`MemberParameters`
    """

    def __init__(self, node: Node, demo: SeveralNodes) -> None:
        self._demo = demo
        self._name = node.name.rpartition("/")[2]
        self._parameters = node.declare_parameters(MemberParameters)
        node.create_timer(lambda: 1.0 / self._parameters.values.period, self.timer)

    def timer(self, elapsed: float) -> None:
        """Work for ``~sleep``."""
        self._demo.work(self._name, self._parameters.values.sleep)


def main() -> None:
    """Run the nodes until they are shut down."""
    run("several_nodes", SeveralNodes)
