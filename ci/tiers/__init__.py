"""Test tiers: which steps they consist of, and how steps are run and reported."""
