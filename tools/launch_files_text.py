# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The texts of the reference page that no table has."""

INTRODUCTION = """\
# Launch files in YAML

This page is the reference of launch files in YAML.
The language is that of ROS 2: every file that `ros2 launch` runs has the \
same meaning here.
Deliberate differences are listed in \
[Differences from ROS 2](#differences-from-ros-2).
The columns "since" name the first ROS 2 release with the feature; \
`colcon launch` supports every feature with any release.

## The file

A launch file has one key, `launch`, which contains the list of actions:

```yaml
launch:
  - arg: {name: rate, default: '10'}
  - node:
      pkg: my_pkg
      exec: my_node
      param:
        - {name: rate, value: $(var rate)}
```

An action is a list item with one key, its name, and its attributes below it.
Actions inside an action are listed below `children`; a `group` without \
attributes may list them directly.
Actions are evaluated in the order of the file, and everything that will run \
is known before anything starts.
The file is YAML 1.1: `yes`, `no`, `on` and `off` are booleans, `010` is 8, \
and you must quote a text that contains `: ` or ` #` or starts with `{`.
A duplicate key is an error.
You can write the same actions and attributes in XML, as in ROS 2's \
`.launch.xml` files.

To mark a launch file as deprecated, give the reason and put its actions \
below `children`:

```yaml
launch:
  deprecated: use robot.yaml instead
  children:
    - include: {file: $(dirname)/robot.yaml}
```

## Conditions

Every action accepts `if` or `unless`, but not both.
After substitutions, the value must be `true`, `1`, `false` or `0`, in upper \
or lower case.
If the condition does not hold, the action is skipped with everything inside \
it:

```yaml
launch:
  - arg: {name: sim, default: 'false'}
  - node: {pkg: my_pkg, exec: driver, unless: $(var sim)}
  - node: {pkg: my_pkg, exec: simulator, if: $(var sim)}
```

## Types

| type | accepted values |
| --- | --- |
| text | a text with substitutions; a number or boolean is read as the text \
that you wrote |
| name | the same, except booleans: quote a name such as `on` |
| plain text | a text in which `$(…)` has no meaning |
| condition | `true`, `1`, `false` or `0`, or a text that is one of them \
after substitutions |
| boolean | a YAML boolean, `1` or `0`, or a text that is one after \
substitutions |
| integer | a whole number, or a text that is one after substitutions |
| seconds | a number that is not negative, or a text that is one after \
substitutions |
| command line | a text that is split into arguments as in a shell, or a \
list with one argument per item |
| parameter value | a text, number or boolean, or a list of values of one of \
these kinds |
| list | a list of one or more mappings |
| actions | a list of actions, which may be empty (`[]`) |

A command line is split before substitution, so a value with spaces stays \
one argument.

## Substitutions in texts

Write a substitution as `$(name argument …)`, with exactly one space before \
each argument.
A text may contain several substitutions anywhere, including inside the \
arguments of others.

- Quote an argument with spaces or parentheses as a whole, with `'` or `"`; \
substitutions in it still work.
- `''` is an empty argument.
- In quotes, the other kind of quote is plain text.
- `\\$(` is a literal `$(`, which starts no substitution.
- A backslash always stands for the character after it: `a\\b` is `ab`, and \
`\\\\` is a backslash.
- The result of a substitution is not searched for further substitutions.

In double quotes, YAML needs every backslash twice; in single quotes it does \
not.

## Scopes

Launch configurations (`arg`, `let`), environment variables, the namespace, \
and the parameters and remappings for nodes apply to all following actions \
in their scope.
A `group` has its own scope, which starts as a copy of the scope around it \
and ends with the group, unless you set `scoped: false`.
An `include` has no scope of its own: settings of the included file also \
apply after the include.
To avoid that, put the include into a group.
The children of a `timer` use the scope in which the timer is written.
"""

DIFFERENCES = """\
## Differences from ROS 2

`colcon launch` accepts more and reports mistakes earlier, but a file that \
ROS 2 runs keeps its meaning.

- Where ROS 2 requires a quoted text, a number or boolean also works \
(`if: true`, `respawn_delay: 2`, `default: 5`), and a list works for a \
command line.
- Where ROS 2 reads every text as true (`scoped: 'false'`), the text is \
read as a boolean; a text that is not a boolean is an error.
- `set_use_sim_time` sets the parameter `use_sim_time` of the nodes and the \
clock of each `ros_timer` in the scope.
- A list in `set_parameter` reaches the nodes as a list.
- `set_parameter` and `set_remap` in a group always end with the group.
- `$(dirname)` and `$(filename)` always refer to the file in which they are \
written, also after an include.
- A relative path in `include` is also looked up in the folder of the \
including file.
- For launch files in Python, see \
[python_launch_files.md](python_launch_files.md#differences-from-ros2-launch).
- The default for `output` is `both`: all output is shown.
- An empty or blank text for `args` or `ros_args` means no arguments; ROS 2 \
passes one empty argument (both do for an empty substitution).
- A quote in a command line may span a substitution, as in \
`bash -c 'echo $(var text)'`.
- `name:=` on the command line sets an empty value, and an argument that no \
file declares is a warning.
- `respawn` also retries a start that failed, and first stops the processes \
that the previous run left behind.
- Without `respawn_delay`, a process that ended ten times in a row within a \
second of its start is respawned after a pause, which grows from 0.1 to 5 s \
until the process runs longer.
- For components and lifecycle nodes, see \
[components.md](components.md#what-is-different-from-ros-2).
- Mistakes are reported as `file:line:column` before anything starts.
- If a program cannot be started or fails, the exit code is 1.
"""

PARAMETERS = """\
An item is one of three things: a `name` with a `value`, a `name` with \
further parameters below `param`, or a file after `from`.
A text without substitutions stays a text: `'5'` is not a number.
"""
COMPONENTS = """\
A component is a node that is loaded into a running container; see \
[components.md](components.md).
An item also accepts `if` and `unless`.
"""
EXPOSED = """\
Other packages can provide actions and substitutions, such as `gz_server` \
of `ros_gz_sim`.
Use them in YAML and XML files like those above, with `if` and `unless`; \
the processes that they start are part of the launch:

```xml
<launch>
  <group>
    <push_ros_namespace namespace="robot"/>
    <gz_server world_sdf_file="$(find-pkg-share my_pkg)/worlds/yard.sdf"/>
  </group>
</launch>
```

A package provides them through the entry point group \
`launch.frontend.launch_extension` and the decorators \
`@expose_action('name')` and `@expose_substitution('name')` of \
`launch.frontend`.
Only Python can run them, so `launch` and `launch_ros` of the sourced \
environment do, as for launch files in Python, in the scope in which the \
action or substitution is written.
They have the same attributes and defaults as in ROS 2, except that the \
default of `output` is `both`.
Inside such an action, the actions of this page are also run by ROS 2 and \
accept only the types of values that ROS 2 accepts.

- The names are read from the packages without importing them: from the \
packages that are installed in the environment (`PYTHONPATH`, \
`AMENT_PREFIX_PATH`, the Python on the `PATH`), and from the sources of the \
workspace (`setup.py`, `setup.cfg`, `pyproject.toml`).
- An unknown name is an error, which suggests the most similar known name.
- If a package of the workspace provides one that you use, it is built first.
- `--plan` and `--check` run them, too, with the given launch arguments and \
the defaults of the others.
- A check skips an action that reads a launch argument without a default.
- `$(dirname)`, `$(filename)` and the variables of loops are evaluated where \
they are written.
- `--schema` contains the actions of the environment and the workspace, \
without their attributes.
- If `launch` is not in the environment, an error names the package that \
provides the action.
"""
