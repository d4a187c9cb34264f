"""Base of the tests of signals sent to pages."""

import csv
import io
import time
from typing import List, Tuple

import rospy
from wire.client import fetch
from wire.scope_test import ScopeTest

PEAK = 1e6


class SignalsTest(ScopeTest):
    """Test of a scope that records the course's signals."""

    ARGUMENTS = ["/signal/signal_y", "/proc_signal"]

    def samples(self, *fields: str) -> List[Tuple[float, List[str]]]:
        """Return time and cells of each row of the CSV."""
        query = "&".join("field=" + field for field in fields)
        status, text = fetch(f"{self.scope.url}/data.csv?{query}")
        self.assertEqual(status, 200, text)
        head, *rows = csv.reader(io.StringIO(text))
        self.assertEqual(head, ["time", "received", *fields])
        return [(float(row[0]), row[2:]) for row in rows]

    def publish(self, publisher: rospy.Publisher, values: List[float]) -> None:
        for value in values:
            publisher.publish(value)
            time.sleep(0.002)
