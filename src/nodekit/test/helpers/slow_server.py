#!/usr/bin/env python3
"""Plain rospy service that answers on request; ``/slow`` adds two numbers."""

import sys
import threading
import time

import rospy
from std_srvs.srv import SetBool, SetBoolResponse, Trigger, TriggerResponse


def main() -> None:
    rospy.init_node("slow_server")
    may_answer = threading.Event()

    def answer(request: object) -> TriggerResponse:
        may_answer.wait(60.0)
        return TriggerResponse(True, "at last")

    rospy.Service("slow", Trigger, answer)
    rospy.Service("echo", SetBool, lambda request: SetBoolResponse(request.data, "quick"))

    def fail(request: object) -> TriggerResponse:
        raise ValueError("on purpose")

    rospy.Service("fails", Trigger, fail)
    print("up", flush=True)
    for line in sys.stdin:
        may_answer.set()
        print(line, end="", flush=True)
    time.sleep(60.0)


if __name__ == "__main__":
    main()
