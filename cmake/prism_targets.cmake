# Helpers that declare what the project needs and its targets: libraries, programs, tests.
include(GNUInstallDirs)

# prism_dependency(package version ...): a package the library needs, found here, and again by
# prismConfig.cmake for whoever links the installed library.
macro(prism_dependency)
  find_package(${ARGV} REQUIRED)
  string(REPLACE ";" " " arguments "${ARGV}")
  string(APPEND PRISM_FIND_DEPENDENCIES "find_dependency(${arguments})\n")
endmacro()

# How the project's own sources are compiled; nothing of it reaches those who use the library.
add_library(prism_compile_options INTERFACE)
# No -march here: the distribution's Ceres was built without AVX, and Eigen's alignment differs
# on the two sides of that boundary. Kernels that want wide vectors dispatch at run time instead.
if(PRISM_STRICT)
  target_compile_options(prism_compile_options INTERFACE -Wall -Wextra -Wpedantic -Werror)
  target_compile_definitions(prism_compile_options INTERFACE EIGEN_INITIALIZE_MATRICES_BY_NAN)
endif()
if(PRISM_SANITIZE)
  target_compile_options(prism_compile_options INTERFACE
    -fsanitize=${PRISM_SANITIZE} -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(prism_compile_options INTERFACE -fsanitize=${PRISM_SANITIZE})
  target_compile_definitions(prism_compile_options INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()
if(PRISM_FUZZ)
  set(fuzz_checks fuzzer-no-link,address,undefined)
  target_compile_options(prism_compile_options INTERFACE
    -fsanitize=${fuzz_checks} -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(prism_compile_options INTERFACE -fsanitize=${fuzz_checks})
endif()

if(PRISM_BUILD_PYTHON)
  # The libraries become part of a shared one; calls within a file are inlined as if they did not.
  target_compile_options(prism_compile_options INTERFACE -fno-semantic-interposition)
endif()

include(cmake/precompiled_headers.cmake)

# prism_module(name [NOT_INSTALLED] SOURCES a.cc ... DEPENDS prism::x pkg::y ...)
# A library prism::name of the folder's sources, or of headers alone if there are none. A module may
# include only what it depends on here. Headers that are generated belong into
# ${PROJECT_BINARY_DIR}/generated/prism/name. Its real name is another than prism_name, because a program
# may be called that (prism_eval, prism_lightfield). The global property PRISM_MODULES lists all.
# A module is installed, and part of prism::prism, unless it is marked as NOT_INSTALLED: what only
# programs or tests of the project use. All its headers are installed, generated ones too.
function(prism_module name)
  cmake_parse_arguments(ARG "NOT_INSTALLED" "" "SOURCES;DEPENDS" ${ARGN})
  set(target prism_module_${name})
  if(ARG_SOURCES)
    set(scope PUBLIC)
    add_library(${target} STATIC ${ARG_SOURCES})
    if(PRISM_BUILD_PYTHON)
      set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    endif()
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:prism_compile_options>)
    prism_precompiled_headers(${target} MODULE)
  else()
    set(scope INTERFACE)
    add_library(${target} INTERFACE)
  endif()
  add_library(prism::${name} ALIAS ${target})
  target_compile_features(${target} ${scope} cxx_std_17)
  target_include_directories(${target} ${scope}
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/generated>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} ${scope} ${ARG_DEPENDS})
  set_property(GLOBAL APPEND PROPERTY PRISM_MODULES ${name})
  if(ARG_NOT_INSTALLED)
    return()
  endif()

  set_property(GLOBAL APPEND PROPERTY PRISM_INSTALLED_MODULES ${name})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} OUTPUT_NAME prism_${name})
  if(PRISM_INSTALL)
    install(TARGETS ${target} EXPORT prismTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
    foreach(folder ${CMAKE_CURRENT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/generated/prism/${name})
      install(DIRECTORY ${folder}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/prism/${name} OPTIONAL
              FILES_MATCHING PATTERN "*.h")
    endforeach()
  endif()
endfunction()

# prism_tool(name SOURCES b.cc ... DEPENDS prism::x ...): the program NAME from NAME.cc and others.
function(prism_tool name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${name}.cc ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE prism_compile_options prism_tool_main ${ARG_DEPENDS})
  prism_precompiled_headers(${name} PROGRAM)
  if(PRISM_INSTALL)
    install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  endif()
endfunction()

# prism_test(name SOURCES a_test.cc ... DEPENDS prism::x ...): a GoogleTest program in ctest.
function(prism_test name)
  if(NOT PRISM_BUILD_TESTS)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name}_test ${ARG_SOURCES})
  target_link_libraries(${name}_test PRIVATE
    prism_compile_options ${ARG_DEPENDS} GTest::gmock GTest::gtest GTest::gtest_main)
  target_compile_definitions(${name}_test PRIVATE PRISM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  prism_precompiled_headers(${name}_test TEST)
  gtest_discover_tests(${name}_test TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST PROPERTIES TIMEOUT 300)
endfunction()

# prism_benchmark(name DEPENDS prism::x ...): the Google Benchmark program NAME from NAME.cc.
function(prism_benchmark name)
  if(NOT PRISM_BUILD_BENCHMARKS)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "DEPENDS" ${ARGN})
  add_executable(${name} ${name}.cc)
  target_link_libraries(${name} PRIVATE prism_compile_options ${ARG_DEPENDS} benchmark::benchmark)
endfunction()
