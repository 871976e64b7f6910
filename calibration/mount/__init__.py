"""The camera on the arm's flange: its lens, and where it hangs, found together."""
