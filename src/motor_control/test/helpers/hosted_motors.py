#!/usr/bin/env python3
"""Motors and their set points in one process, without connections between them."""

from motor_control.nodes.dc_motor import DcMotor
from motor_control.nodes.set_point import SetPoint
from nodekit import host

if __name__ == "__main__":
    host(
        "hosted",
        [
            (name, f"/pair{number}", cls)
            for number in range(3)
            for name, cls in (("motor_sys", DcMotor), ("sp_gen", SetPoint))
        ],
    )
