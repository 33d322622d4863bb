# SPDX-License-Identifier: Apache-2.0
# layering.cmake must name each forbidden include of a tree that has one of every kind, and accept
# the tree without them. cmake -DTREE=<scratch folder> -P tests/layering_test.cmake
cmake_minimum_required(VERSION 3.25)

function(check expected_count)
  execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${TREE} -P ${CMAKE_CURRENT_LIST_DIR}/layering.cmake
                  OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE failed)
  string(REGEX MATCHALL "[a-z/_.]+: [^\n]*(may not include|is not a path)" named "${output}")
  list(LENGTH named count)
  if(NOT count EQUAL expected_count)
    message(FATAL_ERROR "expected ${expected_count} forbidden includes, got ${count}:\n${output}")
  elseif((expected_count EQUAL 0 AND failed) OR (expected_count GREATER 0 AND NOT failed))
    message(FATAL_ERROR "wrong exit status ${failed}:\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${TREE})
foreach(file core/a.hpp io/a.hpp voxelize/a.hpp network/a.hpp mpm_fem/a.hpp
             training/a.hpp diffusion/a.hpp scene/a.hpp cli/a.hpp examples/a.hpp python/a.hpp)
  file(WRITE ${TREE}/${file} "#include <vector>\n")
endforeach()
file(WRITE ${TREE}/core/good.cpp "#include \"core/a.hpp\"\n#include <Eigen/Core>\n")
file(WRITE ${TREE}/io/good.cpp
     "#include \"core/a.hpp\"\n#include <hdf5.h>\n#include <nlohmann/json.hpp>\n#include <tiny_gltf.h>\n")
file(WRITE ${TREE}/voxelize/good.cpp
     "#include \"core/a.hpp\"\n#include \"io/a.hpp\"\n#include <openvdb/openvdb.h>\n")
file(WRITE ${TREE}/network/good.cpp "#include \"core/a.hpp\"\n#include \"voxelize/a.hpp\"\n")
file(WRITE ${TREE}/mpm_fem/good.cpp "#include \"io/a.hpp\"\n#include \"voxelize/a.hpp\"\n")
file(WRITE ${TREE}/training/good.cpp "#include \"io/a.hpp\"\n#include \"network/a.hpp\"\n")
file(WRITE ${TREE}/diffusion/good.cpp "#include \"network/a.hpp\"\n#include \"training/a.hpp\"\n")
file(WRITE ${TREE}/scene/good.cpp "#include \"mpm_fem/a.hpp\"\n#include \"network/a.hpp\"\n")
foreach(top examples python)
  file(WRITE ${TREE}/${top}/good.cpp "#include \"${top}/a.hpp\"\n#include \"scene/a.hpp\"\n")
endforeach()
file(WRITE ${TREE}/cli/options.cpp "#include \"network/a.hpp\"\n#include <CLI/CLI.hpp>\n")
check(0)

file(WRITE ${TREE}/core/bad.cpp "#include \"io/a.hpp\"\n  #  include \"core/absent.hpp\"\n")
file(WRITE ${TREE}/io/bad.cpp "#include \"voxelize/a.hpp\"\n#include \"a.hpp\"\n")
file(WRITE ${TREE}/voxelize/bad.cpp "#include \"network/a.hpp\"\n#include <torch/torch.h>\n")
file(WRITE ${TREE}/voxelize/bad.hpp "#include <openvdb/openvdb.h>\n")
file(WRITE ${TREE}/network/bad.cu
     "#include \"cli/a.hpp\"\n#include <tbb/parallel_for.h>\n#include <nlohmann/json.hpp>\n")
file(WRITE ${TREE}/network/bad.hpp "#include <Eigen/Dense>\n#include \"io/a.hpp\"\n")
file(WRITE ${TREE}/cli/bad.cpp
     "#include <CLI/CLI.hpp>\n#include <hdf5.h>\n#include <tiny_gltf.h>\n#include <nanovdb/NanoVDB.h>\n")
file(WRITE ${TREE}/mpm_fem/bad.cpp "#include \"network/a.hpp\"\n#include \"scene/a.hpp\"\n")
file(WRITE ${TREE}/training/bad.cpp "#include \"diffusion/a.hpp\"\n#include \"scene/a.hpp\"\n")
file(WRITE ${TREE}/diffusion/bad.cpp "#include \"mpm_fem/a.hpp\"\n")
file(WRITE ${TREE}/scene/bad.cpp
     "#include \"cli/a.hpp\"\n#include \"diffusion/a.hpp\"\n#include <CLI/CLI.hpp>\n")
file(WRITE ${TREE}/examples/bad.cpp "#include \"cli/a.hpp\"\n#include \"python/a.hpp\"\n")
file(WRITE ${TREE}/python/bad.cpp "#include \"cli/a.hpp\"\n#include \"training/a.hpp\"\n")
check(28)
