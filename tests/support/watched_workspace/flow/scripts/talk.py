#!/usr/bin/env python3
import signal, sys, time
signal.signal(signal.SIGINT, lambda *_: sys.exit(0))
text = ''.join(open(p).read().strip() for p in sys.argv if p.endswith('.yaml'))
print('talk says one', text, flush=True)
while True: time.sleep(1000)
