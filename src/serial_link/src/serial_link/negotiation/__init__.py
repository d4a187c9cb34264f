# Pure: knows no ROS.
"""Negotiation of topics and services, and payloads of special frames. Pure."""
