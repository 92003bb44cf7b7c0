# Language level, warnings and sanitizers, the same for every target.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

add_library(primo_options INTERFACE)
target_compile_options(primo_options INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
                                               -ffp-contract=off)
target_include_directories(primo_options INTERFACE ${CMAKE_SOURCE_DIR}/libs)
if(PRIMO_SANITIZE)
  # Global, so that generated code and test frameworks built here carry the same instrumentation.
  add_compile_options(-fsanitize=${PRIMO_SANITIZE} -fno-omit-frame-pointer -g1)
  add_link_options(-fsanitize=${PRIMO_SANITIZE})
endif()
if(PRIMO_BUILD_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "PRIMO_BUILD_FUZZ needs clang: configure with --preset fuzz, or -DCMAKE_CXX_COMPILER=clang++")
  endif()
  # Global, so that the fuzzers see which branches of the libraries an input reaches, and every error ends the run.
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined
                      -fno-omit-frame-pointer -g1)
  add_link_options(-fsanitize=address,undefined)
endif()
