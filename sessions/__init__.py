"""Serve `.cell` scripts to experiment clients over MAS, record and replay them."""
