# Headers of other projects that most sources include, compiled once for each kind of target: modules,
# whose code may go into a shared library, programs, and tests. Sources still include what they use: the
# other presets, and continuous integration on Ubuntu, build without.
set(standard_headers <algorithm> <array> <chrono> <cmath> <cstdint> <cstdio> <cstring> <filesystem>
    <fstream> <functional> <iostream> <limits> <map> <memory> <numeric> <optional> <random> <set>
    <sstream> <string> <utility> <vector>)
set(PRISM_MODULE_HEADERS ${standard_headers} <Eigen/Dense> <glog/logging.h> <opencv2/core.hpp>)
set(PRISM_PROGRAM_HEADERS ${PRISM_MODULE_HEADERS} <gflags/gflags.h> <nlohmann/json.hpp>)
set(PRISM_TEST_HEADERS ${PRISM_MODULE_HEADERS} <gmock/gmock.h> <gtest/gtest.h> <nlohmann/json.hpp>)

if(PRISM_PRECOMPILE_HEADERS)
  # What a precompiled header was made with has to hold wherever it is used; else the compiler says so
  # (-Winvalid-pch).
  target_compile_definitions(prism_compile_options INTERFACE
    $<TARGET_PROPERTY:glog::glog,INTERFACE_COMPILE_DEFINITIONS>
    $<TARGET_PROPERTY:gflags,INTERFACE_COMPILE_DEFINITIONS>)
endif()

# prism_precompiled_headers(target MODULE|PROGRAM|TEST)
function(prism_precompiled_headers target kind)
  if(NOT PRISM_PRECOMPILE_HEADERS)
    return()
  endif()
  string(TOLOWER prism_${kind}_headers headers)
  if(NOT TARGET ${headers})
    set(source ${PROJECT_BINARY_DIR}/generated/${headers}.cc)
    file(CONFIGURE OUTPUT ${source} CONTENT "// Has precompiled headers.\n")
    add_library(${headers} OBJECT ${source})
    target_compile_features(${headers} PRIVATE cxx_std_17)
    target_link_libraries(${headers} PRIVATE prism_compile_options Eigen3::Eigen glog::glog opencv_core)
    find_package(nlohmann_json REQUIRED)
    if(kind STREQUAL MODULE)
      get_target_property(pic ${target} POSITION_INDEPENDENT_CODE)
      set_target_properties(${headers} PROPERTIES POSITION_INDEPENDENT_CODE ${pic})
    elseif(kind STREQUAL PROGRAM)
      target_link_libraries(${headers} PRIVATE gflags nlohmann_json::nlohmann_json)
    else()
      target_link_libraries(${headers} PRIVATE GTest::gmock GTest::gtest nlohmann_json::nlohmann_json)
    endif()
    target_precompile_headers(${headers} PRIVATE ${PRISM_${kind}_HEADERS})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${headers})
endfunction()
