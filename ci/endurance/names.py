"""Names and descriptions of the long runs; needs neither ROS nor a build.

Usage: python3 ci endurance.names soak|two-hosts
"""

import sys

COMMANDS = {
    "soak": {
        "record": "a signal of 1 kHz, its answers and a bag",
        "managed": "kill -9 and stops of managed nodes under their manager",
        "identify": "15 plants, and how often each ± of identify holds",
        "judge": "controllers with known flaws, and correct ones drawn at random",
        "board": "a sketch on a simulated AVR under resets, cable pulls and noise",
        "scope": "ten traces of 1 kHz on the page of the oscilloscope",
        "images": "large messages through shared memory, and kill -9 of subscribers",
        "bridge": "1 kHz, images and goals through the bridge, then kill -9 of it and of each side",
    },
    "two-hosts": {
        "cable": "cw1_two_hosts.launch, and the cable pulled for a while",
        "closed": "what another host can reach of nodes that it should not reach",
        "doctor": "rosrun nodekit doctor on both hosts, with nodes on each",
        "networks": "the bridge and a ROS 2 node on another host, without multicast",
    },
}

if __name__ == "__main__":
    for name, text in COMMANDS[sys.argv[1]].items():
        print(f"  {name:10} {text}")
