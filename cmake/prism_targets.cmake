# Helpers that declare the project's targets: one library a module, one test program a module.

# Flags every target of the project is compiled with.
add_library(prism_compile_options INTERFACE)
target_include_directories(prism_compile_options INTERFACE ${PROJECT_SOURCE_DIR})
# No -march here: the distribution's Ceres was built without AVX, and Eigen's alignment differs
# on the two sides of that boundary. Kernels that want wide vectors dispatch at run time instead.
if(PRISM_STRICT)
  target_compile_options(prism_compile_options INTERFACE -Wall -Wextra -Wpedantic -Werror)
  target_compile_definitions(prism_compile_options INTERFACE EIGEN_INITIALIZE_MATRICES_BY_NAN)
endif()
if(PRISM_SANITIZE)
  target_compile_options(prism_compile_options INTERFACE
    -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(prism_compile_options INTERFACE -fsanitize=address,undefined)
  target_compile_definitions(prism_compile_options INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()

# prism_module(name SOURCES a.cc ... DEPENDS prism::x pkg::y ...)
# A static library prism::name; a module may include only what it depends on here. Its real name is
# another than prism_name, because a program may be called that (prism_eval, prism_lightfield).
function(prism_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  if(ARG_SOURCES)
    add_library(prism_module_${name} STATIC ${ARG_SOURCES})
    target_link_libraries(prism_module_${name} PUBLIC prism_compile_options ${ARG_DEPENDS})
  else()
    add_library(prism_module_${name} INTERFACE)
    target_link_libraries(prism_module_${name} INTERFACE prism_compile_options ${ARG_DEPENDS})
  endif()
  add_library(prism::${name} ALIAS prism_module_${name})
endfunction()

# prism_test(name SOURCES a_test.cc ... DEPENDS prism::x ...): a GoogleTest program in ctest.
function(prism_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name}_test ${ARG_SOURCES})
  target_link_libraries(${name}_test PRIVATE ${ARG_DEPENDS} GTest::gmock GTest::gtest GTest::gtest_main)
  target_compile_definitions(${name}_test PRIVATE PRISM_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  if(NOT PRISM_TESTS)
    set_target_properties(${name}_test PROPERTIES EXCLUDE_FROM_ALL ON)
  endif()
  gtest_discover_tests(${name}_test TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST PROPERTIES TIMEOUT 300)
endfunction()
