"""Test tiers: their steps, the runner, and the report."""
