"""Helpers of integration tests; a .test file puts the folder above on PYTHONPATH."""
