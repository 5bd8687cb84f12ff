# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The control socket: the only entry point to a running launch from outside.

`docs/control.md` describes the protocol for users, :mod:`.protocol` its
requests and answers, and how messages are read from bytes.

- Server: :mod:`.server` opens the socket, accepts clients, and writes the
  record that describes the launch in case that it is killed.
  :mod:`.client_connection` serves one client, and :mod:`.service` answers its
  requests; most are commands of the engine. :mod:`.journal` keeps events and
  output for clients that subscribe.
- Client: :mod:`.client` finds running launches, sends commands and receives
  events, which :mod:`.subscription` describes. :mod:`.selection` chooses the
  launches and processes that a user means, and :mod:`.process_names` matches
  names such as `--restart NAME`. :mod:`.orphaned_launches` finds the launches
  whose launcher was killed, :mod:`.doubled_nodes` nodes that run already.
- Both: :mod:`.socket_folder` creates and finds sockets,
  :mod:`.command_codec` makes requests of commands and back, and
  :mod:`.resource_usage` measures processes.
"""
