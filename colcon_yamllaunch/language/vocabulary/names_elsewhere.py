# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What attributes and substitutions are called in other launch files."""

#: Attributes, by their names in ROS 1 and in ROS 2's Python launch files.
ATTRIBUTES = {
    'additional_env': 'env',
    'arguments': 'args',
    'composable_node_descriptions': 'composable_node',
    'environment': 'env',
    'executable': 'exec',
    'extra_arguments': 'extra_arg',
    'ns': 'namespace',
    'package': 'pkg',
    'parameters': 'param',
    'prefix': 'launch-prefix',
    'remappings': 'remap',
    'rosparam': 'param',
    'target_container': 'target',
    'type': 'exec',
}
#: Substitutions, by their names in ROS 1.
SUBSTITUTIONS = {
    'arg': 'var',
    'find': 'find-pkg-share',
    'optenv': 'env',
}
