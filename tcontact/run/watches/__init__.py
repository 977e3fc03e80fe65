"""What a run looks for between launches, beside the guards of every row; `looks` collects them.

Bodies that meet, contact that was missed, obstacles that were out of reach, normals that have turned.
"""
