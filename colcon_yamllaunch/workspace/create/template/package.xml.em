<?xml version="1.0"?>
<?xml-model href="http://download.ros.org/schema/package_format3.xsd" schematypens="http://www.w3.org/2001/XMLSchema"?>
<package format="3">
  <name>@(name)</name>
  <version>0.1.0</version>
  <description>@(xml(description))</description>
  <maintainer email=@(xml_attribute(maintainer_email))>@(xml(maintainer_name))</maintainer>
  <license>@(xml(license))</license>

@[if build_type != 'ament_python']@
  <buildtool_depend>@(build_type)</buildtool_depend>

@[end if]@
@[for dependency in dependencies]@
  <depend>@(dependency)</depend>
@[end for]@
@[if build_type == 'ament_python']@
  <test_depend>python3-pytest</test_depend>
@[end if]@
@[if dependencies or build_type == 'ament_python']@

@[end if]@
  <export>
    <build_type>@(build_type)</build_type>
  </export>
</package>
