"""What every room may use: errors and warnings, checks of what a user hands in, the version, old names of modules."""
