"""A run as one web page that needs nothing else: facts, verdicts, curves to zoom, the film and a surface to turn.

facts.py       tables: how the run ended, its scene, checks, balance of energy and momentum
curves.py      curves of the history, thinned to what a screen can show
surface.py     the surface in all frames with its fields, and the obstacles, as numbers of 16 bits
film.py        the pictures of the frames
document.py    the page of all this: assets/page.html with the scripts and styles beside it
studies.py     the tables and figure of a study

assets/three.js is three.js 0.187.0 (MIT licence, LICENSE-three.txt), bundled from the names in assets/three-names.js by
`esbuild three-names.js --bundle --minify --format=iife --global-name=THREE --legal-comments=inline`.
"""
