cmake_minimum_required(VERSION 3.16)
@[if build_type == 'cmake' and not is_cpp]@
# With C++ code: `project(@(name))`.
project(@(name) LANGUAGES NONE)
@[else]@
project(@(name))
@[end if]@
@[if build_type == 'ament_cmake']@

find_package(ament_cmake REQUIRED)
@[end if]@
@[if is_cpp and is_ros]@
find_package(rclcpp REQUIRED)
@[end if]@

@[if is_cpp]@
# What can be run and launched. Each program needs these lines.
add_executable(@(node) src/@(node).cpp)
target_compile_features(@(node) PUBLIC cxx_std_17)
@[if is_ros]@
target_link_libraries(@(node) rclcpp::rclcpp)
@[end if]@
install(
  TARGETS
    @(node)
  DESTINATION lib/${PROJECT_NAME})
@[else]@
# What can be run and launched. Each script needs its line here and its
# executable bit (chmod +x).
install(
  PROGRAMS
    scripts/@(node).py
  DESTINATION lib/${PROJECT_NAME})
@[end if]@

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
@[if not is_cpp]@
if(BUILD_TESTING)
  add_test(
    NAME unittest
    COMMAND python3 -B -m unittest discover --start-directory test --verbose
    WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
endif()
@[elif not is_ros]@
if(BUILD_TESTING)
  add_test(NAME greetings COMMAND @(node) --times 2)
  set_tests_properties(
    greetings PROPERTIES PASS_REGULAR_EXPRESSION "Hello 2")
endif()
@[end if]@
@[if build_type == 'ament_cmake']@
@[if not is_cpp]@

@[end if]@
ament_package()
@[end if]@
