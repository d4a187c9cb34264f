"""Samples from bags: played, plotted, written as CSV."""
