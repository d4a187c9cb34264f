"""Print the median time of a transition of the node /managed, from request to reply, as JSON."""

import json
import statistics
import time
from typing import List

import rospy

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState

ROUNDS = 100


def main() -> None:
    """Measure and print; this client looks the service up for each call, as rospy's do."""
    rospy.init_node("transition_client")
    change = rospy.ServiceProxy("/managed/change_state", ChangeState)
    taken: List[float] = []
    for _ in range(ROUNDS):
        for label in ("configure", "activate", "deactivate", "cleanup"):
            began = time.monotonic()
            if not change(Transition(0, label)).success:
                raise RuntimeError(f"{label} has failed")
            taken.append(time.monotonic() - began)
    print(json.dumps({"p50_ms": 1e3 * statistics.median(taken)}))


if __name__ == "__main__":
    main()
