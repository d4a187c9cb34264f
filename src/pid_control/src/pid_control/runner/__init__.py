"""Runners that start an unchanged controller and run it through scenarios."""
