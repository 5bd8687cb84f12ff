# Parameters of the nodes that the launch file gives this file to; `/**` stands
# for a node of any name.
/**:
  ros__parameters:
    greeting: Hello from @(name)
    period: 1.0  # seconds; a number with its point, as the default has one
