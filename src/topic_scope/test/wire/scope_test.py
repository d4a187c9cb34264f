"""Base of tests of a scope's messages to its pages."""

import unittest
from typing import Any, ClassVar, List

import rospy
from browsing.scope_process import ScopeProcess, shared_scope
from wire.client import Client

from nodekit.testing.waiting import wait_until


class ScopeTest(unittest.TestCase):
    """Test with a scope, shared by all tests of its arguments, and pages that close at the end."""

    #: Its arguments, except the port.
    ARGUMENTS: ClassVar[List[str]] = []
    scope: ClassVar[ScopeProcess]

    @classmethod
    def setUpClass(cls) -> None:
        cls.scope = shared_scope(*cls.ARGUMENTS)
        cls.scope.wait_until_served()

    def page(self, *fields: str, **arguments: Any) -> Client:
        """Open a page.

        :param fields: its selection; empty for the scope's default
        """
        client = Client(self.scope.url, **arguments)
        self.addCleanup(client.close)
        client.wait_for("hello")
        if fields:
            client.send("select", fields=list(fields))
        return client

    def publisher(self, topic: str, message_class: Any, page: Client) -> rospy.Publisher:
        """Return a publisher that the scope listens to, for a field that a page has selected."""
        publisher = rospy.Publisher(topic, message_class, queue_size=1000)
        self.addCleanup(publisher.unregister)
        wait_until(
            publisher.get_num_connections,
            lambda: f"no subscriber of {topic}; errors: {page.messages('error')}",
        )
        return publisher
