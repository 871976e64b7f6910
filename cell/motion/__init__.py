"""What happens between a wish to move and a command to the arm: the guard."""
