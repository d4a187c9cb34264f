#!/usr/bin/env python3
"""A fleet of three groups looks like three pairs of nodes; one member has an invalid parameter."""

import unittest
import xmlrpc.client

import rosgraph
import rospy
from rosgraph_msgs.msg import Log
from std_msgs.msg import Float32
from std_srvs.srv import SetBool, Trigger

from basic_comms.conditioning.process_parameters import ProcessParameters
from basic_comms.msg import signal_msg
from basic_comms.signals.signal_parameters import SignalParameters
from nodekit.testing.graph import Graph
from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until


class FleetOfThree(unittest.TestCase):
    """Robot1 and Robot3 are whole; of Robot2 only the generator is up."""

    graph: Graph

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node("test_fleet")
        cls.graph = Graph()
        rospy.wait_for_service("/fleet/describe", 60.0)

    def test_topics_and_services_are_those_of_separate_nodes(self) -> None:
        topics = self.graph.topics()
        services = {name for name, _ in rosgraph.Master("/test_fleet").getSystemState()[2]}
        for group in ("/Robot1", "/Robot3"):
            self.assertEqual(topics[group + "/signal"], "basic_comms/signal_msg")
            self.assertEqual(topics[group + "/proc_signal"], "std_msgs/Float32")
            self.assertEqual(topics[group + "/signal_generator/status"], "std_msgs/String")
            for service in ("signal_generator/enable", "signal_generator/reset"):
                self.assertIn(f"{group}/{service}", services)
            for node in ("signal_generator", "process"):
                self.assertIn(f"{group}/{node}/describe", services)

    def test_parameters_are_those_of_separate_nodes(self) -> None:
        for group in ("/Robot1", "/Robot3"):
            generator = self.graph.parameter(group + "/signal_generator")
            process = self.graph.parameter(group + "/process")
            self.assertEqual(set(generator), set(SignalParameters.declared))
            self.assertEqual(set(process), set(ProcessParameters.declared))

    def test_members_hear_each_other_without_connections(self) -> None:
        recorder = MessageRecorder("/Robot1/proc_signal", Float32)
        recorder.wait_for(lambda answer: True)
        recorder.close()
        with xmlrpc.client.ServerProxy(rosgraph.Master("/test_fleet").lookupNode("/fleet")) as node:
            connections = node.getBusInfo("/test_fleet")[2]
        incoming = [
            (topic, transport)
            for _, _, direction, transport, topic, *_ in connections
            if direction == "i"
        ]
        # Listed, as rosnode info and roswtf expect, but without a socket.
        links = [(f"/{name}/signal", "INTRAPROCESS") for name in ("Robot1", "Robot3")]
        self.assertEqual(sorted(incoming), links)

    def test_a_refused_member_stays_down_alone(self) -> None:
        self.assertNotIn("/Robot2/proc_signal", self.graph.topics())
        self.assertIn("/Robot2/signal", self.graph.topics())
        for group in ("/Robot1", "/Robot3"):
            recorder = MessageRecorder(group + "/proc_signal", Float32)
            recorder.wait_for(lambda answer: True)
            recorder.close()

    def test_each_member_has_parameters_of_its_own(self) -> None:
        recorders = {
            name: MessageRecorder(f"/{name}/signal", signal_msg) for name in ("Robot1", "Robot3")
        }
        recorders["Robot3"].wait_for(lambda sample: sample.amplitude == 3.0)
        self.graph.set_parameter("/Robot1/signal_generator/amplitude", 7.0)
        recorders["Robot1"].wait_for(lambda sample: sample.amplitude == 7.0)
        recorders["Robot3"].clear()
        recorders["Robot3"].wait_for(lambda sample: sample.amplitude == 3.0)
        self.graph.set_parameter("/Robot1/signal_generator/amplitude", -1.0)
        wait_until(
            lambda: self.graph.parameter("/Robot1/signal_generator/amplitude") == 7.0,
            lambda: "the bad value was not put back",
        )
        for recorder in recorders.values():
            recorder.close()

    def test_lines_of_the_log_do_not_carry_the_names_of_all_topics(self) -> None:
        log = MessageRecorder("/rosout", Log)
        self.graph.wait_until_heard("/fleet", "/rosout", rospy.get_name())
        self.graph.set_parameter("/Robot3/process/offset", 0.25)
        line = log.wait_for(lambda heard: heard.msg == "/Robot3/process/offset: 0 -> 0.25")
        self.assertEqual((line.name, line.topics), ("/fleet", []))
        log.close()

    def test_services_reach_one_member_only(self) -> None:
        rospy.ServiceProxy("/Robot1/signal_generator/enable", SetBool)(False)
        stopped, running = (
            MessageRecorder("/Robot1/signal", signal_msg),
            MessageRecorder("/Robot3/signal", signal_msg),
        )
        stopped.wait_for(lambda sample: sample.amplitude == 0.0)
        running.wait_for(lambda sample: sample.amplitude > 0.0)
        rospy.ServiceProxy("/Robot1/signal_generator/enable", SetBool)(True)
        stopped.wait_for(lambda sample: sample.amplitude > 0.0)
        answer = rospy.ServiceProxy("/Robot3/process/describe", Trigger)()
        self.assertIn("phase_shift", answer.message)
        stopped.close()
        running.close()


if __name__ == "__main__":
    rosrun("basic_comms", "fleet", FleetOfThree)
