# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The package.xml of packages that tests make."""

_MANIFEST = """\
<?xml version="1.0"?>
<package format="3">
  <name>{name}</name>
  <version>0.1.0</version>
  <description>A package</description>
  <maintainer email="{mail}">Someone</maintainer>
  <license>Apache-2.0</license>
  {depends}
  <export><build_type>{build_type}</build_type></export>
</package>
"""


def manifest(
    name: str,
    build_type: str,
    depends: str = '',
    mail: str = 'someone@example.com',
) -> str:
    """Return a package.xml; one with another mail may be invalid."""
    return _MANIFEST.format(
        name=name, build_type=build_type, depends=depends, mail=mail
    )
