# SPDX-License-Identifier: Apache-2.0
# Installs a build below FOLDER, builds tests/package against it, and runs the result.
#   cmake -DBUILD=<build> -DFOLDER=<scratch> -DASSET=<mesh> -DPYTHON=<python with numpy> -P tests/package_test.cmake
file(REMOVE_RECURSE ${FOLDER})

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nended with ${code}:\n${out}")
  endif()
  set(output "${out}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${FOLDER}/installed)
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/package -B ${FOLDER}/build -G Ninja
    -DCMAKE_PREFIX_PATH=${FOLDER}/installed)
run(${CMAKE_COMMAND} --build ${FOLDER}/build)
run(${FOLDER}/build/solvers ${ASSET})
message("${output}")
run(${FOLDER}/build/clip ${ASSET} ${FOLDER}/hanging.glb)
message("${output}")
run(${PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/package/check_clip.py ${FOLDER}/hanging.glb)
message("${output}")
run(${FOLDER}/installed/bin/elastogen --version)
message("${output}")
