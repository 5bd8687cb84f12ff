# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The colcon verbs: arguments in, exit code out.

Where nothing else is said, an `environment` is that of the user, and `known`
is what colcon's parser has made of the command line.
"""
