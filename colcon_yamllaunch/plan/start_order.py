# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""In which order the members of a plan start, as their settings say."""

from collections.abc import Iterable, Mapping

from colcon_yamllaunch.plan.plan import Member


def dependencies_of(
    members: Iterable[Member],
) -> dict[str, tuple[str, ...]]:
    """Return for each label the labels that it waits for."""
    return {
        member.label: () if member.settings is None else member.settings.after
        for member in members
    }


def cycle_in(after: Mapping[str, Iterable[str]]) -> list[str]:
    """
    Return a cycle, as labels that each wait for the next one.

    :param after: For each label the labels that it waits for
    :returns: the first label again at the end, or nothing if there is none
    """
    done: set[str] = set()
    for start in after:
        # the labels on the way here, with what is still to be visited of each
        path = {start: iter(after.get(start, ()))}
        while path and start not in done:
            label, others = next(reversed(path.items()))
            for other in others:
                if other in path:
                    labels = list(path)
                    return [*labels[labels.index(other) :], other]
                if other not in done:
                    path[other] = iter(after.get(other, ()))
                    break
            else:
                done.add(label)
                del path[label]
    return []


def stages_of(after: Mapping[str, Iterable[str]]) -> list[list[str]]:
    """
    Return labels in stages: each one waits only for those of earlier stages.

    :param after: For each label the labels that it waits for, without cycles;
      labels that are no keys are ignored
    """
    remaining = {
        label: {other for other in others if other in after}
        for label, others in after.items()
    }
    stages: list[list[str]] = []
    while remaining:
        stage = [label for label, others in remaining.items() if not others]
        if not stage:
            raise ValueError('the labels wait for one another')
        stages.append(stage)
        for label in stage:
            del remaining[label]
        for others in remaining.values():
            others.difference_update(stage)
    return stages
