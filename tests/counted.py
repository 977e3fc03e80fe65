"""Names, times and tuples that count how often they are compared, hashed or gone through."""


class Name(str):
    """A text that counts comparisons and hashes of all its kind."""

    uses = 0

    def __eq__(self, other):
        Name.uses += 1
        return str.__eq__(self, other)

    def __hash__(self):
        Name.uses += 1
        return str.__hash__(self)


class Time(float):
    """A number that counts the subtractions from all its kind."""

    uses = 0

    def __sub__(self, other):
        Time.uses += 1
        return float(self) - other


class Passes(tuple):
    """A tuple that counts how often one goes through it."""

    count = 0

    def __iter__(self):
        self.count += 1
        return super().__iter__()
