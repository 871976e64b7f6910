"""Benchmarks: each figure beside a ceiling or peer measured in the same run."""
