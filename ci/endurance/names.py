"""Names of the long runs, and what each one does; needs neither ROS nor a build.

Usage: python3 ci endurance.names soak|two-hosts
"""

import sys

SOAK = {
    "record": "a signal of 1 kHz, its answers and a bag",
    "respawn": "kill -9 of each node, which is started again",
    "stalled": "a subscriber at 1 kHz that is stopped for a minute",
    "interrupt": "Ctrl-C at a random moment of a node's life",
    "managed": "kill -9 and stops of managed nodes under their manager",
    "judge": "controllers with known flaws, and a class with broken ones",
    "scope": "ten traces of 1 kHz on the page of the oscilloscope",
    "board": "a board behind a bad cable that is reset and unplugged",
    "bridge": "1 kHz through the bridge, then kill -9 of it and of each side",
    "crowd": "20 subscribers that come and go",
}
TWO_HOSTS = {
    "cable": "cw1_two_hosts.launch, and the cable pulled for a while",
    "closed": "what another host can reach of nodes that it should not reach",
}

if __name__ == "__main__":
    for name, text in {"soak": SOAK, "two-hosts": TWO_HOSTS}[sys.argv[1]].items():
        print(f"  {name:10} {text}")
