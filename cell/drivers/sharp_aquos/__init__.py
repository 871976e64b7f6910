"""Sharp AQUOS televisions: the RS-232 control protocol."""
