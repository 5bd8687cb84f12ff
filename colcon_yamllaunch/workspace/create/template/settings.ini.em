# The launch file gives this file to the program.
[@(node)]
greeting = Hello from @(name)
# seconds
period = 1.0
