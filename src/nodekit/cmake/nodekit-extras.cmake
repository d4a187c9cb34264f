# The tests of a package: pytest on test/unit, rostest on each test/integration/*.test and
# test/extended/*.test, and a check of the folder launch, as far as these exist. Arguments are passed
# on to roslaunch_add_file_check. Without rostest or roslaunch, the build skips the tests and says so
# once for all packages.
#
#   if(CATKIN_ENABLE_TESTING)
#     nodekit_tests()
#   endif()
#catkin_lint: ignore_once literal_project_name
macro(nodekit_tests)
  find_package(rostest QUIET)
  find_package(roslaunch QUIET)
  if(rostest_FOUND AND roslaunch_FOUND)
    if(IS_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/test/unit)
      catkin_run_tests_target("pytest" "unit" "pytest-unit.xml"
        COMMAND "${PYTHON_EXECUTABLE} -m pytest ${CMAKE_CURRENT_SOURCE_DIR}/test/unit --junitxml=${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME}/pytest-unit.xml")
    endif()

    file(GLOB rostest_files CONFIGURE_DEPENDS
      ${CMAKE_CURRENT_SOURCE_DIR}/test/integration/*.test
      ${CMAKE_CURRENT_SOURCE_DIR}/test/extended/*.test)
    foreach(rostest_file ${rostest_files})
      add_rostest(${rostest_file})
    endforeach()

    if(IS_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/launch)
      roslaunch_add_file_check(launch USE_TEST_DEPENDENCIES ${ARGN})
    endif()
  else()
    get_property(nodekit_tests_left_out GLOBAL PROPERTY NODEKIT_TESTS_LEFT_OUT)
    if(NOT nodekit_tests_left_out)
      message(STATUS "nodekit_tests: the tests are left out, as rostest and roslaunch are not both installed")
      set_property(GLOBAL PROPERTY NODEKIT_TESTS_LEFT_OUT TRUE)
    endif()
  endif()
endmacro()
