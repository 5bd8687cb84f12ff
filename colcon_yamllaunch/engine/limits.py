# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The timeouts and limits of the engine.

A name ends with its unit. Timeouts, delays, intervals, pauses, waits and times
are in seconds.
"""

#: Bytes read from a process at once; the usual capacity of a pipe.
READ_BYTES = 64 * 1024
#: Capacity in bytes that a pipe gets once its process fills it; the most that
#: Linux allows without privileges.
LARGE_PIPE_BYTES = 1024 * 1024
#: How many pipes get it at the same time, as what they hold is read at once
#: when their processes end.
LARGE_PIPE_COUNT = 16
#: Bytes of one line that are collected before it is passed on in pieces.
LINE_BYTES = 16 * 1024 * 1024
#: Bytes of all lines that have not ended, before the longest is passed on.
UNFINISHED_LINES_BYTES = 16 * 1024 * 1024

#: Bytes of one stream that may wait for a slow screen before the stream is
#: not read any more, so that its process waits.
STREAM_BACKLOG_BYTES = 256 * 1024
#: Bytes of all streams that may wait before no stream may add to its own.
SCREEN_BACKLOG_BYTES = 4 * 1024 * 1024
#: Bytes of all streams that may wait before no process is read any more.
SCREEN_MAXIMUM_BYTES = 16 * 1024 * 1024
#: Pieces that are handed to the screen in one system call.
WRITE_BATCH_PIECES = 256

#: Bytes for the log of the whole launch that are collected at most.
PENDING_LOG_BYTES = 256 * 1024
#: Bytes that all log files of a launch may take together, unless the user
#: gives another limit.
DEFAULT_LOG_BYTES = 2_000_000_000
#: The share of the disk that logs leave free is one divided by this.
FREE_DISK_DIVISOR = 10
#: Bytes that the log files of a launch may take all the same.
MINIMUM_LOG_BYTES = 1_000_000
#: Bytes that they may grow by before the disk is looked at again.
DISK_CHECK_BYTES = 16_000_000
#: Log files that the limit is divided among at least, so that one of a few
#: files does not lose half of its content at once.
MINIMUM_LOG_SHARES = 8
#: A log file may be as large as its rotated files together, divided by this.
ROTATED_LOG_DIVISOR = 8
#: Bytes that a log file may have before it rotates, however small the limit.
MINIMUM_LOG_FILE_BYTES = 64 * 1024
#: Bytes by which a full log file may grow until the line that it is in ends;
#: after that the line is torn.
LOG_LINE_BYTES = 1024 * 1024

#: Characters of the widest label that others are aligned to.
LABEL_CHARACTERS = 24
#: Columns of a terminal below which there is no table.
TABLE_COLUMNS = 40
#: Lines of a terminal that a table of single processes leaves free.
TABLE_MARGIN_LINES = 4
#: Names that a progress line lists before it only counts.
LISTED_NAMES = 6
#: Lines of a failed process that are shown again at the end.
TAIL_LINES = 10
#: Bytes of the output of a process that are kept for these lines.
TAIL_BYTES = 4096
#: Bytes of a label that a folder's name takes.
FOLDER_NAME_BYTES = 200

#: Bytes of output that wait for the table of what was started.
TABLE_BACKLOG_BYTES = 1024 * 1024
#: Characters that are kept of what a build that failed has said.
BUILD_ERROR_CHARACTERS = 64 * 1024
#: Processes that are started before output and signals get a turn.
STARTS_PER_TURN = 4
#: Quiet processes whose log files are opened before the same.
LOGS_OPENED_PER_TURN = 8
#: Seconds below which a run of a process that is respawned ended quickly.
QUICK_END_SECONDS = 1.0
#: How many quick ends in a row cost no pause where `respawn_delay` is 0.
QUICK_ENDS_WITHOUT_PAUSE = 10
#: Seconds of the first pause before a restart after that; each further one is
#: twice as long.
SHORTEST_RESTART_PAUSE = 0.1
#: Seconds of the longest one.
LONGEST_RESTART_PAUSE = 5.0
#: How many times as long as a search for what processes left running the
#: launcher does without another one, when processes are respawned often.
SEARCH_PAUSE_FACTOR = 10
#: Seconds of silence after which a process is reported that may hold back
#: what it writes.
SILENCE_WARNING_DELAY = 10.0
#: Seconds between two looks at what is still being waited for, and between
#: two lines about it where nothing changed.
PROGRESS_INTERVAL = 1.0
PROGRESS_REPEAT_INTERVAL = 10.0
#: Seconds in which a repeated signal is the same one; `timeout` sends its
#: signal to the process and once more to the group.
SIGNAL_ECHO_INTERVAL = 0.1
#: Seconds that a screen which takes nothing is waited for after a stop.
SCREEN_TIMEOUT = 5.0
#: Seconds between two looks for processes that the launcher adopted, while
#: something happens; and seconds after which it looks while nothing does. What
#: it has not seen, the guard does not know.
ADOPTION_INTERVAL = 1.0
IDLE_ADOPTION_INTERVAL = 10.0
#: Seconds that the worker of Python launch files gets, once all has ended, to
#: answer what happened last.
WORKER_ANSWER_TIMEOUT = 5.0
#: Seconds after which it is sent more of what it has not taken.
WORKER_RETRY_DELAY = 0.005
#: How often a guard that died is replaced in one launch.
GUARD_RESTARTS = 3
#: Seconds that are waited for at once; epoll counts milliseconds in an int,
#: which is enough for 24.8 days.
LONGEST_LOOP_WAIT = 86_400.0
#: How many searches for an expression may take too long before the launch
#: does without.
SLOW_SEARCH_COUNT = 10
#: The most frames of a message to the guard, each with a descriptor; Linux
#: takes no more than 253 of these (SCM_MAX_FD).
GUARD_MESSAGE_FRAMES = 16
#: Bytes of the longest message to the guard, with room for the longest paths.
GUARD_MESSAGE_BYTES = 2 * 1024 * 1024
#: Bytes that the guard adds to the logs of a launch whose launcher is gone.
GUARD_LOG_BYTES = 64 * 1024 * 1024
#: Seconds that a launcher whose lease has expired gets to stop its processes,
#: besides their timeouts.
LEASE_STOP_TIMEOUT = 5.0
#: Seconds by which the time of a file may be before that of the clock.
FILE_TIME_TOLERANCE = 1.0

#: Seconds after which a warning says what loading components, activating
#: lifecycle nodes and timers on ROS time wait for; later pauses are longer.
WAIT_WARNING_DELAY = 5.0
#: Seconds of the longest of these pauses.
LONGEST_WARNING_DELAY = 600.0
#: Seconds until a container that could not say what is loaded is asked again.
LIST_RETRY_DELAY = 1.0
#: How often a process that serves the launcher (the one that speaks with ROS,
#: the one that watches files) is started again in a row.
HELPER_RESTARTS = 5
#: Seconds that it must have run for an end to be the first of a row.
HELPER_STEADY_TIME = 60.0
#: Seconds that it gets to end by itself at the end of a launch.
CLIENT_END_TIMEOUT = 0.5
#: How many Python interpreters of the environment are tried.
TRIED_INTERPRETERS = 4
#: Seconds that an interpreter gets to say which modules it does not find.
INTERPRETER_TIMEOUT = 5.0

#: Seconds that the processes of other machines may take to stop before those
#: that they waited for are stopped here.
STOP_STAGE_TIMEOUT = 15.0
#: Seconds between two looks whether a port or file is there for which a
#: process counts as ready.
READY_POLL_DELAY = 0.1
#: Seconds from the end of a command that says whether a process is ready to
#: its next start.
READY_COMMAND_DELAY = 1.0

#: Seconds that a report of what is not ready waits for what there is instead.
EXPLANATION_TIMEOUT = 1.0

#: Bytes of the latest events, and of the latest output, that are kept in
#: memory for clients of the control socket, and pieces of output at most.
EVENT_BACKLOG_BYTES = 512 * 1024
OUTPUT_BACKLOG_BYTES = 1024 * 1024
OUTPUT_BACKLOG_PIECES = 8192
#: Bytes of events that are kept while a client has not read them.
UNREAD_EVENT_BYTES = 4 * 1024 * 1024
#: Bytes of output that such a client may be behind before it misses some, and
#: those in one file of the journal.
JOURNAL_BYTES = 256 * 1024 * 1024
JOURNAL_FILE_BYTES = 8 * 1024 * 1024
#: Seconds in which pieces of one stream become one in the journal.
JOURNAL_MERGE_SECONDS = 0.005

#: Bytes typed at a process that wait until it reads them.
TYPED_BYTES = 64 * 1024

#: Bytes of files with parameters that are read to find what a process that
#: runs has been given; that many take some tenths of a second.
PARAMETER_FILE_BYTES = 256 * 1024
