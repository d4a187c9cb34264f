#!/usr/bin/env python3
"""Run the first_order_sys node: see first_order_sys_sim.nodes.first_order_sys."""

from first_order_sys_sim.nodes.first_order_sys import main

if __name__ == "__main__":
    main()
