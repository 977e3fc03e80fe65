"""Names of history columns that are made of names of bodies and sets."""


def column_word(text: str) -> str:
    """Return the text with "-" for "/", which would make a folder of the column in the result file."""
    return text.replace("/", "-")
