#!/bin/sh
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

# Stand for a part of which nothing is to be seen.
exec sleep 1000
