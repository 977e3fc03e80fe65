"""Phases of nodes: kick, drift, supports, damping, images."""
