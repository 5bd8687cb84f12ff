cmake_minimum_required(VERSION 3.16)
@[if build_type == 'cmake']@
# With C++ code: `project(@(name))`.
project(@(name) LANGUAGES NONE)
@[else]@
project(@(name))

find_package(ament_cmake REQUIRED)
@[end if]@

# What can be run and launched. Each script needs its line here and its
# executable bit (chmod +x).
install(
  PROGRAMS
    scripts/@(node).py
  DESTINATION lib/${PROJECT_NAME})

# These folders are installed with all that is in them.
install(
  DIRECTORY
    config
    launch
  DESTINATION share/${PROJECT_NAME})

@[if build_type == 'cmake']@
install(FILES package.xml DESTINATION share/${PROJECT_NAME})

include(CTest)
@[end if]@
if(BUILD_TESTING)
  add_test(
    NAME unittest
    COMMAND python3 -B -m unittest discover --start-directory test --verbose
    WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
endif()
@[if build_type == 'ament_cmake']@

ament_package()
@[end if]@
