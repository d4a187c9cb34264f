"""Samples of topics, recorded in memory."""
