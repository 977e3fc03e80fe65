"""Watches: they look between launches for what no row shows, beside the guards of every row; `looks` collects them.

They find bodies that meet, contact that was missed, obstacles that were thought out of reach, and normals that have
turned.
"""
