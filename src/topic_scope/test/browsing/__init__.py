"""Helpers of the page's tests: a headless browser, a scope, and waits for conditions."""
