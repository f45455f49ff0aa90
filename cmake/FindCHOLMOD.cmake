# CHOLMOD, the sparse Cholesky factorisation of SuiteSparse. Defines the target glossa::cholmod.
#
# SuiteSparse 7 installs a CMake package; Debian's and Ubuntu's libsuitesparse-dev before it does not, so header and
# libraries are then looked for by name.

if(TARGET glossa::cholmod)
  return()
endif()

find_package(CHOLMOD CONFIG QUIET)
if(CHOLMOD_FOUND AND TARGET SuiteSparse::CHOLMOD)
  add_library(glossa::cholmod INTERFACE IMPORTED)
  target_link_libraries(glossa::cholmod INTERFACE SuiteSparse::CHOLMOD)
  message(STATUS "CHOLMOD: package ${CHOLMOD_DIR}")
  return()
endif()
set(CHOLMOD_FOUND FALSE)

find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
set(missing "")
if(NOT CHOLMOD_INCLUDE_DIR)
  list(APPEND missing cholmod.h)
endif()
set(libraries "")
foreach(name IN ITEMS cholmod amd colamd camd ccolamd suitesparseconfig)
  string(TOUPPER "CHOLMOD_${name}_LIBRARY" variable)
  find_library(${variable} ${name})
  if(${variable})
    list(APPEND libraries "${${variable}}")
  else()
    list(APPEND missing lib${name})
  endif()
endforeach()

if(missing)
  string(REPLACE ";" ", " missing "${missing}")
  message(FATAL_ERROR
    "glossa needs CHOLMOD from SuiteSparse; not found: ${missing}. Install it with one of\n"
    "  apt install libsuitesparse-dev            (Debian, Ubuntu)\n"
    "  dnf install suitesparse-devel             (Fedora)\n"
    "  conda install -c conda-forge suitesparse  (conda)\n"
    "  brew install suite-sparse                 (macOS)\n"
    "or point CMAKE_PREFIX_PATH to where it is.")
endif()

set(CHOLMOD_FOUND TRUE)
add_library(glossa::cholmod INTERFACE IMPORTED)
set_target_properties(glossa::cholmod PROPERTIES
  INTERFACE_INCLUDE_DIRECTORIES "${CHOLMOD_INCLUDE_DIR}"
  INTERFACE_LINK_LIBRARIES "${libraries}")
message(STATUS "CHOLMOD: ${CHOLMOD_CHOLMOD_LIBRARY}")
mark_as_advanced(CHOLMOD_INCLUDE_DIR)
