"""What pictures tell: blocks on the playground."""
