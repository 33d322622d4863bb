# SPDX-License-Identifier: Apache-2.0
# Target elastogen_libtorch: the headers and libraries of libtorch, of Debian's libtorch-dev or of the
# folder ELASTOGEN_TORCH (that of the Python package torch). Its own CMake files are not used: they
# want the whole CUDA toolkit and set flags for everyone.
set(ELASTOGEN_TORCH "" CACHE PATH "folder with libtorch's include and lib; empty: the system's")
set(torch_hints)
if(ELASTOGEN_TORCH)
  set(torch_hints HINTS ${ELASTOGEN_TORCH} NO_DEFAULT_PATH)
endif()
find_path(ELASTOGEN_TORCH_INCLUDE ATen/ATen.h PATH_SUFFIXES include ${torch_hints} REQUIRED)
set(torch_libraries torch torch_cpu c10)
if(ELASTOGEN_CUDA)
  list(APPEND torch_libraries torch_cuda c10_cuda)
endif()

add_library(elastogen_libtorch INTERFACE)
target_include_directories(elastogen_libtorch SYSTEM INTERFACE
  ${ELASTOGEN_TORCH_INCLUDE} ${ELASTOGEN_TORCH_INCLUDE}/torch/csrc/api/include)
# nothing refers to the CUDA part, which registers itself when it is loaded; the libraries that it
# needs in turn are found by its own path, not by the linker
target_link_options(elastogen_libtorch INTERFACE LINKER:--no-as-needed
                    LINKER:--allow-shlib-undefined)
foreach(library ${torch_libraries})
  find_library(ELASTOGEN_LIB_${library} ${library} PATH_SUFFIXES lib ${torch_hints} REQUIRED)
  target_link_libraries(elastogen_libtorch INTERFACE ${ELASTOGEN_LIB_${library}})
endforeach()
