# Tests of the project as a dependency: installed, and as a folder of another project.
set(consumer_dir ${CMAKE_CURRENT_LIST_DIR})

add_test(NAME consumer.Subdirectory
  COMMAND ${CMAKE_COMMAND} --fresh -S ${consumer_dir}/subdirectory
          -B ${CMAKE_CURRENT_BINARY_DIR}/consumer_subdirectory -G ${CMAKE_GENERATOR}
          -DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER} -DPRISM_SOURCE_DIR=${PROJECT_SOURCE_DIR})
set_tests_properties(consumer.Subdirectory PROPERTIES TIMEOUT 120)

if(PRISM_INSTALL AND TARGET prism_simulate)
  # Sanitized libraries want a sanitized program.
  set(flags "")
  if(PRISM_SANITIZE)
    set(flags "-fsanitize=${PRISM_SANITIZE} -DEIGEN_MALLOC_ALREADY_ALIGNED=1")
  endif()
  set(launcher ${CMAKE_CXX_COMPILER_LAUNCHER})
  if(launcher)
    list(GET launcher -1 launcher)  # ccache, without what it is told about precompiled headers
  endif()
  add_test(NAME consumer.Installed
    COMMAND ${CMAKE_COMMAND} -DBINARY_DIR=${PROJECT_BINARY_DIR} -DCONFIG=$<CONFIG>
            -DWORK_DIR=${CMAKE_CURRENT_BINARY_DIR}/consumer_installed -DGENERATOR=${CMAKE_GENERATOR}
            -DCXX_COMPILER=${CMAKE_CXX_COMPILER} -DCXX_LAUNCHER=${launcher}
            -DCXX_FLAGS=${flags} -P ${consumer_dir}/consumer_test.cmake)
  set_tests_properties(consumer.Installed PROPERTIES TIMEOUT 600)
endif()
