# The four verbs every CMakeLists.txt here is written in: vox_library, vox_service, vox_test, vox_fuzz;
# vox_bench beside them, and vox_lcm_types for lcmtypes/.

include(GNUInstallDirs)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)

# presets: scripts/build passes VOX_SANITIZE=address|thread for asan and tsan.
set(VOX_SANITIZE "" CACHE STRING "address, thread or empty")
# scripts/build fuzz passes it: fuzz targets get clang's libFuzzer in place of a replay.
option(VOX_FUZZ "build the fuzz targets with libFuzzer (clang only)" OFF)
if(VOX_FUZZ AND NOT CMAKE_CXX_COMPILER_ID MATCHES Clang)
  message(FATAL_ERROR "VOX_FUZZ needs clang, not ${CMAKE_CXX_COMPILER}: use scripts/build fuzz")
endif()

add_library(vox_flags INTERFACE)
target_compile_features(vox_flags INTERFACE cxx_std_20)
target_compile_options(vox_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion)
if(VOX_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)  # Coverage in every library that is fuzzed.
else()
  target_compile_options(vox_flags INTERFACE -Werror)  # g++'s warnings are the ones kept at none.
endif()
# A fused multiply-add rounds once where two operations round twice: with it the cells a ray crosses
# would depend on the compiler and the processor. The same scan must give the same bytes anywhere.
add_compile_options(-ffp-contract=off)
if(VOX_SANITIZE AND NOT VOX_FUZZ)
  # g++ 12 sees uninitialised members in the standard library's own code once it is instrumented
  # (std::regex within Catch2); the plain builds keep the warning.
  target_compile_options(vox_flags INTERFACE -Wno-maybe-uninitialized)
endif()
if(VOX_SANITIZE STREQUAL "address")
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
elseif(VOX_SANITIZE STREQUAL "thread")
  add_compile_options(-fsanitize=thread -fno-omit-frame-pointer)
  add_link_options(-fsanitize=thread)
endif()

# Reading the same headers again is most of a small source's compile time: they are read once, for
# sources and, with Catch2, for tests. The sanitizers' builds do without, so that a source that
# forgets an include shows there.
function(vox_headers name)
  file(CONFIGURE OUTPUT ${name}.cpp CONTENT "")
  add_library(${name} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE vox_flags fmt::fmt tl::expected Eigen3::Eigen)
  target_precompile_headers(${name} PRIVATE
    <algorithm> <array> <cmath> <cstdint> <deque> <filesystem> <functional> <map> <memory> <mutex>
    <optional> <span> <string> <vector> <fmt/format.h> <tl/expected.hpp> <Eigen/Geometry> ${ARGN})
endfunction()
# A source takes the optimisation flags of the header that is precompiled, in g++ without a word: what
# speaks LCM must not lose its -fno-strict-aliasing (vox_lcm_types) that way, so it has one of its own.
function(vox_reuse_headers target kind deps)
  if(VOX_SANITIZE)
    return()
  endif()
  if(deps MATCHES "vox::(lcmtypes|bus|[a-z_]+_service)(;|$)")
    set(kind ${kind}_lcm)
  endif()
  target_precompile_headers(${target} REUSE_FROM vox_${kind}_headers)
endfunction()
if(NOT VOX_SANITIZE)
  foreach(speaks "" _lcm)
    vox_headers(vox_source${speaks}_headers)
    vox_headers(vox_test${speaks}_headers <catch2/catch.hpp>)
  endforeach()
  target_compile_options(vox_source_lcm_headers PRIVATE -fno-strict-aliasing)
  target_compile_options(vox_test_lcm_headers PRIVATE -fno-strict-aliasing)
endif()

# vox_library(grid SOURCES tile_key.cpp DEPS vox::base Eigen3::Eigen)   ->   target vox::grid
function(vox_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPS;PRIVATE_DEPS")
  if(arg_SOURCES)
    add_library(vox_${name} STATIC ${arg_SOURCES})
    target_include_directories(vox_${name} PUBLIC
      $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/libs>
      $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/voxatlas/libs>)
    target_link_libraries(vox_${name} PUBLIC ${arg_DEPS}
                                      PRIVATE $<BUILD_INTERFACE:vox_flags> ${arg_PRIVATE_DEPS})
    target_compile_features(vox_${name} PUBLIC cxx_std_20)
    vox_reuse_headers(vox_${name} source "${arg_DEPS}")
    set_target_properties(vox_${name} PROPERTIES EXPORT_NAME ${name})
  else()
    add_library(vox_${name} INTERFACE)
    target_include_directories(vox_${name} INTERFACE ${PROJECT_SOURCE_DIR}/libs)
    target_link_libraries(vox_${name} INTERFACE ${arg_DEPS})
  endif()
  add_library(vox::${name} ALIAS vox_${name})
endfunction()

# What runs, without tests and benches: all that scripts/demo and the image need to build.
add_custom_target(programs)

# vox_service(compress SOURCES compress_service.cpp DEPS vox::codec vox::bus)
#   -> library vox::compress_service (all sources, testable) and the process, built from main.cpp:
#      voxatlas-compress, or NAME where given (the command line is `voxatlas`).
function(vox_service name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "NAME" "SOURCES;DEPS")
  if(NOT arg_NAME)
    set(arg_NAME voxatlas-${name})
  endif()
  add_library(vox_${name}_service STATIC ${arg_SOURCES})
  target_include_directories(vox_${name}_service PUBLIC ${PROJECT_SOURCE_DIR}/services
                                                        ${PROJECT_SOURCE_DIR}/libs)
  target_link_libraries(vox_${name}_service PUBLIC ${arg_DEPS} PRIVATE vox_flags CLI11::CLI11)
  vox_reuse_headers(vox_${name}_service source "${arg_DEPS}")
  add_library(vox::${name}_service ALIAS vox_${name}_service)
  add_executable(vox_${name}_main main.cpp)
  set_target_properties(vox_${name}_main PROPERTIES OUTPUT_NAME ${arg_NAME})
  target_link_libraries(vox_${name}_main PRIVATE vox_${name}_service vox_flags CLI11::CLI11)
  vox_reuse_headers(vox_${name}_main source vox::${name}_service)
  add_dependencies(programs vox_${name}_main)
endfunction()

# What runs by itself, without the services: what the sanitizers build (scripts/test --preset asan).
add_custom_target(unit_tests)

# vox_test(grid SOURCES tile_key_test.cpp DEPS vox::grid)   ->   ctest "unit_grid", one binary a room
function(vox_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "TIMEOUT" "SOURCES;DEPS")
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 300)
  endif()
  add_executable(unit_${name} ${arg_SOURCES})
  target_link_libraries(unit_${name} PRIVATE vox_test_support ${arg_DEPS} vox_flags)
  vox_reuse_headers(unit_${name} test "${arg_DEPS}")
  add_dependencies(unit_tests unit_${name})
  add_test(NAME unit_${name} COMMAND unit_${name})
  set_tests_properties(unit_${name} PROPERTIES TIMEOUT ${arg_TIMEOUT} SKIP_RETURN_CODE 77)
endfunction()

# vox_fuzz(tile_key_fuzz.cpp CORPUS DIR DEPS vox::grid)   ->   bin/fuzz_tile_key
#   With VOX_FUZZ a libFuzzer target: `fuzz_tile_key DIR` mutates for as long as it is let. Otherwise,
#   with every compiler, a program that replays the corpus and then a fixed number of seeded
#   mutations of it: ctest "fuzz_tile_key".
add_custom_target(fuzz_targets)
function(vox_fuzz source)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "CORPUS" "DEPS")
  get_filename_component(stem ${source} NAME_WE)
  string(REGEX REPLACE "_fuzz$" "" name ${stem})
  add_executable(fuzz_${name} ${source})
  target_link_libraries(fuzz_${name} PRIVATE ${arg_DEPS} vox_flags)
  add_dependencies(fuzz_targets fuzz_${name})
  if(VOX_FUZZ)
    target_link_options(fuzz_${name} PRIVATE -fsanitize=fuzzer)
    return()
  endif()
  target_sources(fuzz_${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support/fuzz_replay.cpp)
  add_dependencies(unit_tests fuzz_${name})
  add_test(NAME fuzz_${name} COMMAND fuzz_${name} ${arg_CORPUS})
  set_tests_properties(fuzz_${name} PROPERTIES TIMEOUT 120)
endfunction()

# vox_bench(import SOURCES import_bench.cpp DEPS vox::integrate)   ->   bin/bench_import
function(vox_bench name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPS")
  add_executable(bench_${name} ${arg_SOURCES})
  target_link_libraries(bench_${name} PRIVATE ${arg_DEPS} vox_flags CLI11::CLI11)
endfunction()

# vox_lcm_types(lcmtypes scan_t.lcm bot_core/pose_t.lcm ...)
#   ->   target vox::lcmtypes, headers <voxatlas/scan_t.hpp>, <bot_core/pose_t.hpp>: a folder is a package
function(vox_lcm_types name)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/generated)
  set(headers)
  foreach(file IN LISTS ARGN)
    get_filename_component(type ${file} NAME_WE)
    get_filename_component(package ${file} DIRECTORY)
    if(NOT package)
      set(package voxatlas)
    endif()
    set(header ${out}/${package}/${type}.hpp)
    add_custom_command(
      OUTPUT ${header}
      COMMAND ${LCM_GEN} --cpp --cpp-std c++11 --cpp-hpath ${out} ${CMAKE_CURRENT_SOURCE_DIR}/${file}
      DEPENDS ${file}
      VERBATIM)
    list(APPEND headers ${header})
  endforeach()
  add_custom_target(vox_${name}_generated DEPENDS ${headers})
  add_library(vox_${name} INTERFACE)
  add_dependencies(vox_${name} vox_${name}_generated)
  target_include_directories(vox_${name} SYSTEM INTERFACE
    $<BUILD_INTERFACE:${out}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  set_target_properties(vox_${name} PROPERTIES EXPORT_NAME ${name})
  # lcm-gen's decoders store a double through an int64_t*: under strict aliasing, once inlined, a
  # pose has been seen to keep its old numbers.
  target_compile_options(vox_${name} INTERFACE -fno-strict-aliasing)
  target_link_libraries(vox_${name} INTERFACE vox::lcm)
  add_library(vox::${name} ALIAS vox_${name})
endfunction()
