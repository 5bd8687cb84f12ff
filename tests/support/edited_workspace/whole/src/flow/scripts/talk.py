#!/usr/bin/env python3
import signal, sys, time
import helper
def end(*_):
    time.sleep(0.2)
    sys.exit(0)
signal.signal(signal.SIGINT, end)
texts = [open(p).read() for p in sys.argv if p.endswith(('.yaml', '.rviz'))]
words = [w for t in texts for w in t.split()]
words = [w for w in words if w[0] == 'v' and w[1:].isdigit()]
print('talk says', 'v0', helper.WORD, *words, flush=True)
while True: time.sleep(1000)
