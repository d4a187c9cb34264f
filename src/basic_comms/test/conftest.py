"""Makes pytest search this folder for modules: the tests import helpers from it."""
