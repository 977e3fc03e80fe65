"""The laboratory: studies of accuracy and cost (`study`), the benchmark (`bench`), the figures of the documents
(`numbers`).

Its modules use the program as a user does, from the scene to the result.
"""
