"""The laboratory: studies of accuracy and cost (`study`), the benchmark (`bench`), the figures of the documents
(`numbers`).

What stands here uses the program as a user does, from the scene to the result.
"""
