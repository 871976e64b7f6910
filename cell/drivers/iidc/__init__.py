"""Cameras with IIDC registers (IEEE 1394): the words, and the features they stand for."""
