#!/usr/bin/env python3
"""Greet again and again, and count how often."""

import argparse
import configparser
import time


def read_settings(path):
    """Return the section [@(node)] of an INI file, or only the defaults."""
    settings = configparser.ConfigParser(interpolation=None)
    settings['@(node)'] = {'greeting': 'Hello', 'period': '1.0'}
    if path is not None:
        with open(path, encoding='utf-8') as file:
            settings.read_file(file)
    return settings['@(node)']


def greet(settings, count):
    """Return the greeting with its number."""
    return f"{settings['greeting']} {count}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--settings', metavar='FILE', help='an INI file')
    settings = read_settings(parser.parse_args().settings)
    count = 0
    try:
        while True:
            count += 1
            print(greet(settings, count), flush=True)
            time.sleep(settings.getfloat('period'))
    except KeyboardInterrupt:
        pass  # Ctrl-C: the usual way for it to end


if __name__ == '__main__':
    main()
