# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""One example for each action: what stands in a list of actions."""

#: The examples by the name of the action, each ending with a line end.
EXAMPLES = {
    'arg': """\
- arg:
    name: mode
    default: fast
    description: How the robot drives
    choice:
      - value: fast
      - value: careful
- node:
    pkg: my_pkg
    exec: my_node
    args: --mode $(var mode)
""",
    'bool_arg': """\
- bool_arg: {name: sim, default: 'false', description: Simulate the robot}
- node:
    if: $(var sim)
    pkg: my_pkg
    exec: simulator
""",
    'let': """\
- let: {name: config, value: $(find-pkg-share my_pkg)/config}
- node:
    pkg: my_pkg
    exec: my_node
    param:
      - from: $(var config)/rates.yaml
""",
    'reset': """\
- let: {name: robot, value: r2d2}
- reset:
    keep:
      - {name: robot, value: $(var robot)}
""",
    'set_env': """\
- set_env: {name: RCUTILS_COLORIZED_OUTPUT, value: '1'}
""",
    'unset_env': """\
- unset_env: {name: DISPLAY}
""",
    'append_env': """\
- append_env:
    name: GZ_SIM_RESOURCE_PATH
    value: $(find-pkg-share my_pkg)/models
    prepend: true
""",
    'reset_env': """\
- set_env: {name: LANG, value: C}
- reset_env: {}
""",
    'log': """\
- log: {message: Driving as $(env ROBOT_NAME nobody), level: WARNING}
""",
    'log_info': """\
- log_info: {message: The map is $(var map office)}
""",
    'log_warning': """\
- log_warning: {message: This launch file is for the old robot}
""",
    'log_error': """\
- log_error:
    if: $(not-equals $(env ROS_DOMAIN_ID 0) 0)
    message: The robot listens to domain 0 only
""",
    'log_debug': """\
- log_debug: {message: The log is in $(log_dir)}
""",
    'shutdown': """\
- timer:
    period: 60.0
    children:
      - shutdown: {reason: The minute is over}
""",
    'group': """\
- group:
    - push_ros_namespace: {namespace: left}
    - node: {pkg: my_pkg, exec: camera}
- group:
    if: $(var second true)
    scoped: true
    children:
      - push_ros_namespace: {namespace: right}
      - node: {pkg: my_pkg, exec: camera}
""",
    'timer': """\
- node: {pkg: my_pkg, exec: driver}
- timer:
    period: 2.5
    children:
      - node: {pkg: my_pkg, exec: planner}
""",
    'ros_timer': """\
- set_use_sim_time: {value: true}
- ros_timer:
    period: 2.5
    children:
      - node: {pkg: my_pkg, exec: planner}
""",
    'for_each': """\
- for_each:
    values: '{robot: r2d2, x: 0}; {robot: c3po, x: 2}'
    children:
      - node:
          pkg: my_pkg
          exec: spawn
          name: spawn_$(for-var robot)
          args: -x $(for-var x)
""",
    'for': """\
- for:
    len: $(var robots 3)
    name: i
    children:
      - node: {pkg: my_pkg, exec: my_node, name: robot_$(index i)}
""",
    'include': """\
- group:
    - push_ros_namespace: {namespace: front}
    - include:
        file: $(find-pkg-share my_pkg)/launch/camera.yaml
        arg:
          - {name: rate, value: '30'}
""",
    'executable': """\
- executable:
    cmd: ros2 bag record --all --output $(log_dir)/bag
    name: recorder
    sigterm_timeout: 20
- executable:
    cmd: [echo, the values of a list, are one argument each]
""",
    'node': """\
- node:
    pkg: my_pkg
    exec: my_node
    name: driver
    namespace: base
    param:
      - {name: rate, value: 10}
      - {name: serial, value: $(env SERIAL ''), type: str}
      - name: wheels
        param:
          - {name: radius, value: 0.1}
      - from: $(find-pkg-share my_pkg)/config/driver.yaml
    remap:
      - {from: cmd_vel, to: /safe/cmd_vel}
    respawn: true
    respawn_delay: 2
""",
    'node_container': """\
- node_container:
    pkg: rclcpp_components
    exec: component_container
    name: vision
    namespace: ''
    composable_node:
      - pkg: my_pkg
        plugin: my_pkg::Camera
        name: camera
        param:
          - {name: rate, value: 30}
        extra_arg:
          - {name: use_intra_process_comms, value: 'true'}
      - pkg: my_pkg
        plugin: my_pkg::Viewer
        name: viewer
        if: $(var view true)
        remap:
          - {from: image, to: camera/image}
""",
    'load_composable_node': """\
- load_composable_node:
    target: vision
    composable_node:
      - {pkg: my_pkg, plugin: 'my_pkg::Viewer', name: second_viewer}
""",
    'lifecycle_node': """\
- lifecycle_node:
    pkg: my_pkg
    exec: driver
    name: driver
    namespace: ''
    autostart: true
""",
    'push_ros_namespace': """\
- push_ros_namespace: {namespace: $(var robot r2d2)}
- node: {pkg: my_pkg, exec: my_node}
""",
    'set_parameter': """\
- set_parameter: {name: use_sim_time, value: true}
- node: {pkg: my_pkg, exec: my_node}
""",
    'set_parameters_from_file': """\
- set_parameters_from_file:
    filename: $(find-pkg-share my_pkg)/config/common.yaml
- node: {pkg: my_pkg, exec: my_node}
""",
    'set_remap': """\
- set_remap: {from: /tf, to: tf}
- node: {pkg: my_pkg, exec: my_node}
""",
    'set_use_sim_time': """\
- set_use_sim_time: {value: $(var sim false)}
- node: {pkg: my_pkg, exec: my_node}
""",
    'set_ros_log_dir': """\
- set_ros_log_dir: {new_log_dir: drivers}
- node: {pkg: my_pkg, exec: my_node}
""",
}
