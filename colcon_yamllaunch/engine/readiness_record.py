# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What became ready in a launch, from its events."""

from colcon_yamllaunch.engine import events


class ReadinessRecord:
    """Keeps which members are ready, and what the others wait for."""

    def __init__(self) -> None:
        #: After how many seconds members were ready last, by label.
        self.seconds: dict[str, float] = {}
        #: The labels of those that are ready now.
        self.ready: set[str] = set()
        #: Why others are not, by label, as a part of a sentence.
        self.reasons: dict[str, str] = {}
        #: Those of `reasons` that are failures.
        self.failed: set[str] = set()
        self._is_over = False

    def handle(self, event: events.Event) -> None:
        """Note an event of the launch."""
        member = events.member_of(event)
        label = '' if member is None else member.label
        match event:
            case events.Waiting():
                labels = events.listed(event.labels)
                self.reasons[label] = f'waiting for {labels}'
            case events.MemberChanged() if event.unmet:
                conditions = ' and '.join(event.unmet)
                self.reasons[label] = f'waiting for {conditions}'
            case events.NotReady():
                self.reasons[label] = event.text
                self.failed.add(label)
            case events.NotStarted():
                labels = events.listed(event.labels)
                self.reasons[label] = f'not started, as it waits for {labels}'
                self.failed.add(label)
            case events.Ready():
                self.seconds[label] = event.seconds
                self.ready.add(label)
                self.reasons.pop(label, None)
                self.failed.discard(label)
            case events.Started() | events.Loaded():
                self.ready.discard(label)
                self.reasons.pop(label, None)
            case events.Exited() | events.Unloaded():
                # one that has done its work stays ready, and at the end of
                # the launch all end
                is_done = (
                    isinstance(event, events.Exited)
                    and event.outcome.code == 0
                )
                if is_done or self._is_over:
                    return
                self.ready.discard(label)
                if isinstance(event, events.Exited):
                    self.reasons.setdefault(label, str(event.outcome))
            case events.ShuttingDown():
                self._is_over = True
            case _:
                return
