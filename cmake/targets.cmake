# SPDX-License-Identifier: GPL-3.0-or-later
# How Drogue declares a library, an executable and a test.

add_library(drogue_options INTERFACE)
target_compile_features(drogue_options INTERFACE cxx_std_20)
target_compile_options(drogue_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wno-psabi -fno-math-errno)
if(DROGUE_WARNINGS_AS_ERRORS)
  target_compile_options(drogue_options INTERFACE -Werror)
endif()
if(DROGUE_ASSERTIONS)
  target_compile_options(drogue_options INTERFACE -UNDEBUG)
endif()
if(DROGUE_SANITIZE)
  target_compile_options(drogue_options INTERFACE -fsanitize=${DROGUE_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(drogue_options INTERFACE -fsanitize=${DROGUE_SANITIZE})
endif()
set(CMAKE_CXX_EXTENSIONS OFF)

# drogue_library(NAME SOURCES a.cpp ... DEPS drogue::b ...)
# Declares drogue::NAME. Headers stand beside their sources and are included by their path from the
# repository's root: #include "common/mesh/mesh.hpp".
function(drogue_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  if(ARG_SOURCES)
    add_library(drogue_${name} STATIC ${ARG_SOURCES})
    target_include_directories(drogue_${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>)
    target_link_libraries(drogue_${name} PUBLIC $<BUILD_INTERFACE:drogue_options> ${ARG_DEPS})
    target_compile_features(drogue_${name} PUBLIC cxx_std_20)
    set_target_properties(drogue_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  else()
    add_library(drogue_${name} INTERFACE)
    target_include_directories(drogue_${name} INTERFACE ${CMAKE_SOURCE_DIR})
    target_link_libraries(drogue_${name} INTERFACE drogue_options ${ARG_DEPS})
  endif()
  add_library(drogue::${name} ALIAS drogue_${name})
endfunction()

# drogue_executable(NAME SOURCES main.cpp DEPS drogue::b ...)
function(drogue_executable name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE drogue_options ${ARG_DEPS})
endfunction()

# drogue_test(NAME LABEL unit SOURCES a_test.cpp ... DEPS drogue::b ... [TIMEOUT seconds])
# One GoogleTest executable, one CTest entry. LABEL: one or more of unit verification integration faults slow;
# scripts/test leaves out slow, scripts/verify runs every verification, slow or not.
function(drogue_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;DEPS;LABEL" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_compile_definitions(${name} PRIVATE DROGUE_SOURCE_DIR="${CMAKE_SOURCE_DIR}"
                                             DROGUE_BIN_DIR="${CMAKE_BINARY_DIR}/bin"
                                             DROGUE_TEST_BIN_DIR="${CMAKE_BINARY_DIR}/tests")
  target_link_libraries(${name} PRIVATE drogue_options ${ARG_DEPS} GTest::gtest GTest::gtest_main)
  # What is tested is compiled at full optimisation; the tests themselves need not be, and compile in half the time.
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  add_test(NAME ${name} COMMAND ${name} WORKING_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  set_tests_properties(${name} PROPERTIES LABELS "${ARG_LABEL}" TIMEOUT ${ARG_TIMEOUT}
    ENVIRONMENT "TSAN_OPTIONS=suppressions=${CMAKE_SOURCE_DIR}/tests/tsan.suppressions;OPENBLAS_NUM_THREADS=1;OMP_NUM_THREADS=1;OMPI_ALLOW_RUN_AS_ROOT=1;OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1;OMPI_MCA_ess_singleton_isolated=1")
endfunction()

# drogue_benchmark(NAME SOURCES a_bench.cpp DEPS drogue::b ...)
# One Google Benchmark executable, NAME ending in _bench and starting with its group: common, fluid, structure, mesh,
# coupler, participants, t10. The target benchmarks builds them all, scripts/bench runs them.
add_custom_target(benchmarks)
function(drogue_benchmark name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  add_dependencies(benchmarks ${name})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE drogue_options ${ARG_DEPS} benchmark::benchmark benchmark::benchmark_main)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/benchmarks)
endfunction()

# drogue_kernels(NAME SOURCE...)
# Compiles sources of the library drogue_NAME once for each instruction set of common/base/isa.hpp, with DROGUE_ISA
# defined to its name. What such a source defines must stand in a namespace of that name or be local to it: a function
# that two objects share would be taken from either (the test kernel_symbols_test looks). Kernels throw nothing.
set(drogue_isas baseline avx2 avx512)
set(drogue_isa_flags_avx2 -march=x86-64-v3)
set(drogue_isa_flags_avx512 -march=x86-64-v4 -mprefer-vector-width=512)
function(drogue_kernels name)
  get_target_property(libraries drogue_${name} LINK_LIBRARIES)
  foreach(isa ${drogue_isas})
    add_library(drogue_${name}_${isa} OBJECT ${ARGN})
    target_include_directories(drogue_${name}_${isa} PRIVATE ${CMAKE_SOURCE_DIR})
    target_compile_definitions(drogue_${name}_${isa} PRIVATE DROGUE_ISA=${isa})
    target_compile_options(drogue_${name}_${isa} PRIVATE -ffp-contract=fast -fno-exceptions ${drogue_isa_flags_${isa}})
    target_link_libraries(drogue_${name}_${isa} PRIVATE ${libraries})
    set_target_properties(drogue_${name}_${isa} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_sources(drogue_${name} PRIVATE $<TARGET_OBJECTS:drogue_${name}_${isa}>)
    set_property(GLOBAL APPEND PROPERTY DROGUE_KERNEL_OBJECTS $<TARGET_OBJECTS:drogue_${name}_${isa}>)
  endforeach()
endfunction()

# drogue_native(SOURCE...)
# Compiles numerical kernels (and nothing else) for the processor of this machine.
option(DROGUE_NATIVE "Compile the numerical kernels for this machine's processor" ON)
function(drogue_native)
  if(DROGUE_NATIVE)
    set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "-march=native")
  endif()
endfunction()
