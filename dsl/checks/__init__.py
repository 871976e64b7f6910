"""What a script means, and everything that is wrong with it.

Each module turns nodes of one sort into values of `dsl.program` and reports what
keeps it from doing so. Nothing here raises for a bad script.
"""
