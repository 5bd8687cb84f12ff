# Try it:    colcon launch @(name) @(name).launch.yaml
launch:
@[if is_ros]@
  - node:
      pkg: @(name)
      exec: @(executable)
      name: @(node)
      output: both
      param:
        - from: $(find-pkg-share @(name))/config/@(name).yaml
@[else]@
  - executable:
      cmd: >-
        $(find-pkg-prefix @(name))/lib/@(name)/@(executable)
        --settings $(find-pkg-share @(name))/config/@(name).ini
      output: both
@[end if]@
