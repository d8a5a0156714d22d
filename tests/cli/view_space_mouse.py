#!/usr/bin/env python3
"""A fake spacenavd for one viewer. usage: view_space_mouse.py SOCKET FIFO

Sends each line of FIFO as an event: eight integers (type, six values, period). Missing ones are 0;
`end` ends.
"""
import socket
import struct
import sys

listener = socket.socket(socket.AF_UNIX)
listener.bind(sys.argv[1])
listener.listen(1)
client, _ = listener.accept()
client.send(struct.pack("=I", struct.unpack("=I", client.recv(4))[0] & ~0xff)) # version 0 of the protocol
with open(sys.argv[2]) as events:
    for line in events:
        if line == "end\n":
            break
        values = [int(word) for word in line.split()]
        client.send(struct.pack("=8i", *values, *[0] * (8 - len(values))))
