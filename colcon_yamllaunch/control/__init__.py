# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The control socket: the only entry point to a running launch from outside.

`docs/control.md` describes the protocol for users, :mod:`.protocol` its
requests and answers.

- Server: :mod:`.server` opens the socket in a folder of :mod:`.socket_folder`,
  :mod:`.client_connection` serves one client, and :mod:`.service` answers its
  requests; most are commands of the engine. :mod:`.subscribers` sends events
  and output, which :mod:`.journal` keeps for clients that are behind, and
  renews the lease of the client that holds the launch.
- Client: :mod:`.client` finds running launches, sends commands and receives
  events, which :mod:`.subscription` describes. :mod:`.process_names` matches
  names such as `--restart NAME`.
- Both: :mod:`.messages` reads messages from bytes, and :mod:`.command_codec`
  makes requests of commands and back. :mod:`.socket_address` creates and finds
  sockets. :mod:`.resource_usage` measures processes.
- :mod:`.launch_record` is the file that describes a launch;
  :mod:`.orphaned_launches` finds the launches whose launcher was killed.
"""
