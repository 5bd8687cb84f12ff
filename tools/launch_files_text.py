# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The texts of the reference page that no table has."""

INTRODUCTION = """\
# Launch files in YAML

This page lists everything that a launch file in YAML can say.
The language is that of ROS 2: every file that `ros2 launch` runs means the \
same here, and what is different on purpose stands in \
[Differences from ROS 2](#differences-from-ros-2).
"Since" is the first ROS 2 release that has it; `colcon launch` has all of \
it, whichever release is there.

## The file

A launch file has one key, `launch`, with the list of actions.

```yaml
launch:
  - arg: {name: rate, default: '10'}
  - node:
      pkg: my_pkg
      exec: my_node
      param:
        - {name: rate, value: $(var rate)}
```

A launch file that should not be used any more says why, and keeps its \
actions below `children`.

```yaml
launch:
  deprecated: use robot.yaml instead
  children:
    - include: {file: $(dirname)/robot.yaml}
```

An action is a list item with one key, its name; its attributes stand below \
it.
An action that has others inside has them below `children`; a `group` \
without attributes may list them directly.
Actions are done in the order of the file, and all that is to run is known \
before anything starts.
The file is YAML 1.1: `yes`, `no`, `on` and `off` are booleans, `010` is 8, \
and a text with `: `, ` #` or a `{` at its start must be quoted.
A key that stands twice is an error.
The same actions and attributes may be written in XML, as in ROS 2's \
`.launch.xml` files.

## Conditions

Every action takes `if` or `unless`, not both.
The value is `true` or `1`, or `false` or `0`, in any case, after its \
substitutions.
An action whose condition does not hold is left out with all that is inside.

```yaml
launch:
  - arg: {name: sim, default: 'false'}
  - node: {pkg: my_pkg, exec: driver, unless: $(var sim)}
  - node: {pkg: my_pkg, exec: simulator, if: $(var sim)}
```

## Types

| type | what is written |
| --- | --- |
| text | a text with substitutions; a number or boolean is taken as it is \
written |
| name | the same, but no boolean: a name such as `on` must be quoted |
| plain text | a text in which `$(…)` has no meaning |
| condition | `true`, `1`, `false` or `0`, or a text that is one of them \
after its substitutions |
| boolean | a YAML boolean, `1` or `0`, or a text that is one after its \
substitutions |
| integer | a whole number, or a text that is one after its substitutions |
| seconds | a number that is not negative, or a text that is one after its \
substitutions |
| command line | a text that is split into arguments as a shell does, or a \
list with one argument an item |
| parameter value | a text, number or boolean, or a list of one of these \
kinds |
| list | a list of mappings, one item or more |
| actions | a list of actions, which may be empty (`[]`) |

A command line is split before its substitutions are made, so that a value \
with spaces in it stays one argument.

## Substitutions in texts

A substitution is written `$(name argument …)`, with exactly one space \
before each argument.
Substitutions may stand anywhere in a text, several of them, and in the \
arguments of others.

- An argument with spaces or parentheses is quoted as a whole, with `'` or \
`"`; substitutions in it are made all the same.
- `''` is an empty argument.
- In quotes, the other kind of quote is plain text.
- `\\$(` is a `$(` that starts no substitution.
- A backslash is dropped and the character behind it kept, everywhere: \
`a\\b` is `ab`, and `\\\\` is a backslash.
- What a substitution comes to is not searched for further substitutions.

In YAML's double quotes a backslash must be written twice; single quotes \
spare that.

## Scopes

Launch configurations (`arg`, `let`), environment variables, the namespace, \
and the parameters and remappings for nodes hold for all that follows in \
their scope.
A `group` has a scope of its own, which starts as a copy of the scope around \
it and ends with the group, unless it says `scoped: false`.
An `include` has none: what the included file sets holds behind the include \
too, so put the include into a group to keep it apart.
The children of a `timer` see the scope that the timer is written in.
"""

DIFFERENCES = """\
## Differences from ROS 2

`colcon launch` accepts more and says what is wrong earlier, but a file that \
ROS 2 runs keeps its meaning.

- Where ROS 2 insists on a quoted text, a number or boolean will do \
(`if: true`, `respawn_delay: 2`, `default: 5`), and a list will do for a \
command line.
- Where ROS 2 takes every text for true (`scoped: 'false'`), the text is \
read as a boolean; what is none is an error.
- `set_use_sim_time` sets the parameter `use_sim_time` of the nodes and the \
clock of each `ros_timer` in the scope, and a list in `set_parameter` reaches \
the nodes as a list.
- `set_parameter` and `set_remap` in a group always end with the group.
- `$(dirname)` and `$(filename)` always name the file that they are written \
in, also behind an include.
- A relative path in `include` is looked up beside the including file too.
- For launch files in Python, see \
[python_launch_files.md](python_launch_files.md#differences-from-ros2-launch).
- The default for `output` is `both`: all output is shown.
- An empty or blank text for `args` or `ros_args` has no arguments; ROS 2 \
makes one empty argument of it (an empty substitution is one in both).
- A quote in a command line may span a substitution, as in \
`bash -c 'echo $(var text)'`.
- `name:=` on the command line gives an empty value, and an argument that no \
file declares is a warning.
- `respawn` also tries a start again that failed, and first stops what the \
former run left running.
- Without `respawn_delay`, a process that ended ten times in a row within a \
second of its start is respawned after a pause, which grows from 0.1 to 5 s \
until it runs longer.
- For components and lifecycle nodes, see \
[components.md](components.md#what-is-different-from-ros-2).
- Mistakes show as `file:line:column` before anything is started; a program \
that cannot be started, or that fails, makes the exit code 1.
"""

PARAMETERS = """\
A parameter is one of three things: a `name` with a `value`, a `name` with \
further parameters below `param`, or a file after `from`.
A text without substitutions stays a text: `'5'` is no number.
"""
COMPONENTS = """\
A component is a node that is loaded into a running container; see \
[components.md](components.md).
An item also takes `if` and `unless`.
"""
EXPOSED = """\
Packages bring actions and substitutions of their own, such as `gz_server` of \
`ros_gz_sim`, by the entry point group `launch.frontend.launch_extension` \
and `@expose_action('name')` or `@expose_substitution('name')` of \
`launch.frontend`.
They stand in YAML and XML files like those above, with `if` and `unless`, \
and what they start is a part of the launch like all else:

```xml
<launch>
  <group>
    <push_ros_namespace namespace="robot"/>
    <gz_server world_sdf_file="$(find-pkg-share my_pkg)/worlds/yard.sdf"/>
  </group>
</launch>
```

Only Python can run them: `launch` and `launch_ros` of the sourced \
environment do, as they do for launch files in Python, in the scope where the \
action or substitution stands.
So they are the real ones, with the attributes and defaults that they have \
there, but for `output`, which is `both` here, too.
Of what stands inside of such an action, actions of this page are ROS 2's, \
too, and take values of the types that ROS 2 wants.

- The names are read from the packages without importing them: from those \
that are installed in the environment (`PYTHONPATH`, `AMENT_PREFIX_PATH`, the \
Python on the `PATH`), and from the sources of the workspace \
(`setup.py`, `setup.cfg`, `pyproject.toml`).
- A name that nobody has is an error, with the nearest one of all.
- A package of the workspace that brings one that is used is built first.
- `--plan` and `--check` run them, too, with the arguments given and the \
defaults of the others.
- A check passes over an action that reads an argument without a default.
- `$(dirname)`, `$(filename)` and the variables of loops are made where they \
are written.
- `--schema` has the actions of the environment and the workspace, without \
their attributes.
- Where `launch` is not in the environment, an error names the package that \
has the action.
"""
