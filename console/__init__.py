"""The command line `cell`: how people start what the other packages do."""
