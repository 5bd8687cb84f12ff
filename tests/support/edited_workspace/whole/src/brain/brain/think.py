import os, signal, sys, time
import pylib.words

def main():
    signal.signal(signal.SIGINT, lambda *_: os._exit(0))
    print('mind says', 'v0', pylib.words.WORD, sys.argv[1],
        os.environ['SAID'], flush=True)
    while True: time.sleep(1000)
