#!/usr/bin/env python3
"""Run the first_order_sys node: see first_order_sys_sim.nodes.first_order_sys."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("first_order_sys_sim.nodes.first_order_sys")
