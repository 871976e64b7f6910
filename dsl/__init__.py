"""The `.cell` language: parse, check, run and explain scripts.

Knows no devices, no sockets and no arrays; a running task reaches the cell only
through the `dsl.host.Host` protocol.
"""
