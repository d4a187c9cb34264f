"""Stands here to make pytest look for modules in this folder: the tests import helpers from it."""
