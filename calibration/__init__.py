"""How each calibrated value of a cell is measured, fitted, judged and kept."""
