"""Phases of a step that work on nodes: kick, drift, supports, damping, periodic images."""
