# SPDX-License-Identifier: GPL-3.0-or-later
# Installs the SDK, and nothing else of the build, into PREFIX; then builds the examples in C, C++ and Fortran against it, as a
# stranger would. cmake -D BUILD=... -D SOURCE=... -D PREFIX=... -D EXAMPLES=... -D CC=... [-D FORTRAN=...] -P build_examples.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(status)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${PREFIX} ${EXAMPLES})
run(${CMAKE_COMMAND} --install ${BUILD} --component participant --prefix ${PREFIX})
set(examples c_piston_fluid cpp_spring)
if(FORTRAN)
  list(APPEND examples fortran_spring)
endif()
foreach(example ${examples})
  run(${CMAKE_COMMAND} -S ${SOURCE}/examples/${example} -B ${EXAMPLES}/${example} -D CMAKE_PREFIX_PATH=${PREFIX}
      -D CMAKE_BUILD_TYPE=Release)
  run(${CMAKE_COMMAND} --build ${EXAMPLES}/${example})
endforeach()
# Without CMake, one library is all that a C program needs.
run(${CC} ${SOURCE}/examples/c_piston_fluid/piston_fluid.c -o ${EXAMPLES}/piston_fluid_by_hand -I ${PREFIX}/include/drogue
    -L ${PREFIX}/lib -ldrogue_participant -Wl,-rpath,${PREFIX}/lib)
