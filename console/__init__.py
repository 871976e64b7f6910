"""The command line and the screens of the toolkit."""
