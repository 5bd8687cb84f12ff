# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
How the programs of these tests write down what they got.

The records go to the folder that RECORDS names: `N.start` at the start of the
N-th process, `N.end` at its end, and `N.M.json` for what else it is told.
"""

import itertools
import json
import os
from pathlib import Path
import signal
import sys
import time

import yaml

_PAUSE = 0.01


class _Loader(yaml.SafeLoader):
    """Reads parameters as nodes do, which overlook the tags of lists."""


_Loader.add_constructor(
    'tag:yaml.org,2002:python/tuple',
    lambda loader, node: loader.construct_sequence(node, deep=True),
)


class Recording:
    """The records of this process."""

    def __init__(self):
        self.folder = Path(os.environ['RECORDS'])
        self._more = itertools.count(1)
        self.number = self._take_number()
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._signalled)
        arguments = sys.argv[1:]
        program = Path(sys.argv[0])
        self._write(
            f'{self.number}.start',
            {
                'exe': program.name,
                'from': program.absolute().parent.name,
                'params': _take_parameter_files(arguments),
                'args': arguments,
                'cwd': os.getcwd(),
                'env': dict(os.environ),
                'terminals': [os.isatty(1), os.isatty(2)],
            },
        )

    def add(self, what):
        """Write down something that happened."""
        self._write(f'{self.number}.{next(self._more)}.json', what)

    def end(self, how):
        """Write down how the process ends."""
        self._write(f'{self.number}.end', how)

    def wait_for_others(self, count):
        """Wait until so many processes have started, this one included."""
        while len(list(self.folder.glob('*.start'))) < count:
            time.sleep(_PAUSE)

    def wait_for_ends(self, count):
        """Wait until so many processes have ended."""
        while len(list(self.folder.glob('*.end'))) < count:
            time.sleep(_PAUSE)

    def wait_for_more(self, count):
        """Wait until so many other things have been written down."""
        while len(list(self.folder.glob('*.json'))) < count:
            time.sleep(_PAUSE)

    def _take_number(self):
        number = 1
        while not self._is_taken(number):
            number += 1
        return number

    def _is_taken(self, number):
        try:
            (self.folder / f'{number}.taken').touch(exist_ok=False)
        except FileExistsError:
            return False
        return True

    def _signalled(self, number, _frame):
        if '--stubborn' in sys.argv:
            self.add(signal.Signals(number).name)
            return
        self.end(signal.Signals(number).name)
        os._exit(0)

    def _write(self, name, content):
        # a reader must never see half of it
        unfinished = self.folder / f'.{name}'
        unfinished.write_text(json.dumps(content), encoding='utf-8')
        unfinished.rename(self.folder / name)


def _take_parameter_files(arguments):
    """Read the files with parameters, and put numbers for their paths."""
    contents = []
    for index, argument in enumerate(arguments[:-1], 1):
        if argument == '--params-file':
            with open(arguments[index], encoding='utf-8') as file:
                contents.append(yaml.load(file, _Loader))
            arguments[index] = str(len(contents) - 1)
    return contents
