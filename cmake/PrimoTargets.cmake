# primo_library(NAME [DEPS target...]): libs/NAME/*.cpp as the static library primo_NAME (header-only when there are none).
function(primo_library name)
  cmake_parse_arguments(ARG "" "" "DEPS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/libs/${name}/*.cpp)
  if(sources)
    add_library(primo_${name} STATIC ${sources})
    target_link_libraries(primo_${name} PUBLIC primo_options ${ARG_DEPS})
  else()
    add_library(primo_${name} INTERFACE)
    target_link_libraries(primo_${name} INTERFACE primo_options ${ARG_DEPS})
  endif()
endfunction()

# primo_unit_tests(NAME [DEPS target...]): tests/unit/NAME/*_test.cpp as test_NAME, linked with primo_NAME.
function(primo_unit_tests name)
  cmake_parse_arguments(ARG "" "" "DEPS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/unit/${name}/*.cpp)
  if(sources)
    add_executable(test_${name} ${sources})
    target_link_libraries(test_${name} PRIVATE primo_${name} ${ARG_DEPS} GTest::gtest GTest::gtest_main)
    target_compile_definitions(test_${name} PRIVATE PRIMO_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
    gtest_discover_tests(test_${name} TEST_PREFIX "${name}." PROPERTIES LABELS unit TIMEOUT 300
                         DISCOVERY_TIMEOUT 60)
  endif()
endfunction()

# primo_service(NAME [DEPS target...]): services/NAME/*.cpp as the executable primo_NAME.
function(primo_service name)
  cmake_parse_arguments(ARG "" "" "DEPS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/services/${name}/*.cpp)
  add_executable(primo_${name}_service ${sources})
  set_target_properties(primo_${name}_service PROPERTIES OUTPUT_NAME primo_${name})
  target_link_libraries(primo_${name}_service PRIVATE primo_service ${ARG_DEPS})
endfunction()
