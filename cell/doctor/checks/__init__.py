"""The doctor's checks, one module a part of the cell; each writes into the notes."""
