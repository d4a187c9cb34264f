"""Measurements of the workspace's nodes beside their peers."""
