"""Errors, warnings, checks of user input, the version and the old names of modules: every room may import these."""
