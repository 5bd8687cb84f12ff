# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Many runs of one launch, each with other arguments.

`table` makes the runs from the arguments. A runner launches them: either
`local_runner`, through its run launchers, or `slurm_runner`, through tasks of
Slurm (`slurm_task`). Both use `run`, which launches one run, in `isolation`,
and report to `progress`, which records each result in the folder of `results`.
From these, `reports` writes `results.csv`, `junit.xml` and, with
`report_page`, `report.html`. Start with `run.Sweep`, which a runner gets.
"""
