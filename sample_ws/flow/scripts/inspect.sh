#!/bin/sh
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

# Say what was inspected, and end. A launch goes on when one of its processes
# has ended well. Edit this text and launch again: nothing is built anew,
# because the installed script is a link to this file.
printf 'Inspected %s: valve open, tank dry\n' "${1:-the pump}"
