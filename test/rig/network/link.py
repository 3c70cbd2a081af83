#!/usr/bin/env python3
"""A link between two hosts that are network namespaces: it delays packets, loses some, and can be cut.

What one host sends leaves at the other end after a delay; some of it is lost. The commands "down" and "up" are
read from stdin, and the link ends with stdin. The hosts limit the rate themselves, with ``tc``.
"""
import ctypes
import fcntl
import os
import random
import struct
import sys
import threading
import time
from collections import deque
from contextlib import suppress

TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454ca, 1, 0x1000  # linux/if_tun.h
NEW_NETWORK = 0x40000000                               # CLONE_NEWNET of linux/sched.h
MOST_BYTES = 2048                                      # the largest packet


class Link:
    """Carries packets from one tunnel to the other."""

    def __init__(self):
        self.is_up = True

    def carry(self, source, target, delay, loss, seed):
        chance, waiting, more = random.Random(seed), deque(), threading.Condition()

        def deliver():
            while True:
                with more:
                    more.wait_for(lambda: waiting)
                    due, packet = waiting.popleft()
                time.sleep(max(0.0, due - time.monotonic()))
                if self.is_up:
                    with suppress(OSError):  # the device is not up yet
                        os.write(target, packet)
        threading.Thread(target=deliver, daemon=True).start()
        while True:
            packet = os.read(source, MOST_BYTES)
            if self.is_up and chance.random() >= loss:
                with more:
                    waiting.append((time.monotonic() + delay, packet))
                    more.notify()


def tunnel(host, name):
    """Create a tunnel as a device of a network namespace; returns the file descriptor of its end."""
    with open('/run/netns/' + host) as namespace:
        if ctypes.CDLL(None, use_errno=True).setns(namespace.fileno(), NEW_NETWORK):
            raise OSError(ctypes.get_errno(), 'cannot enter the namespace ' + host)
    end = os.open('/dev/net/tun', os.O_RDWR)
    fcntl.ioctl(end, TUNSETIFF, struct.pack('16sH22x', name.encode(), IFF_TUN | IFF_NO_PI))
    return end


def main(one, one_device, other, other_device, delay, loss):
    link = Link()
    ends = tunnel(one, one_device), tunnel(other, other_device)
    for seed, (source, target) in enumerate((ends, ends[::-1])):
        threading.Thread(target=link.carry, args=(source, target, float(delay), float(loss), seed),
                         daemon=True).start()
    print('ready', flush=True)
    for line in sys.stdin:
        link.is_up = line.strip() == 'up'
        print('done', flush=True)


if __name__ == '__main__':
    main(*sys.argv[1:])
