# Installs a build of PRISM-VO, builds the project of this folder against it and runs its programs on a
# small rendered sequence.
#   cmake -DBINARY_DIR=build/dev -DCONFIG=RelWithDebInfo -DWORK_DIR=DIR -DGENERATOR=Ninja
#         -DCXX_COMPILER=g++ -DCXX_LAUNCHER=ccache -DCXX_FLAGS=... -P consumer_test.cmake
cmake_minimum_required(VERSION 3.25)

set(here ${CMAKE_CURRENT_LIST_DIR})
get_filename_component(source_dir ${here}/../.. ABSOLUTE)
set(prefix ${WORK_DIR}/prefix)
set(sequence ${WORK_DIR}/sequence)
set(frames 24)

function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} --install ${BINARY_DIR} --config ${CONFIG} --prefix ${WORK_DIR}/elsewhere)
file(RENAME ${WORK_DIR}/elsewhere ${prefix})  # what is installed may be moved

# Nothing of this machine and none of the project's own flags in what others link.
file(GLOB_RECURSE exported ${prefix}/*.cmake)
if(NOT exported)
  message(FATAL_ERROR "no CMake package in ${prefix}")
endif()
foreach(file IN LISTS exported)
  file(READ ${file} text)
  foreach(leak ${source_dir} ${BINARY_DIR} Werror fsanitize EIGEN_)
    string(FIND "${text}" ${leak} position)
    if(NOT position EQUAL -1)
      message(FATAL_ERROR "${file}: found '${leak}', expected nothing of the build")
    endif()
  endforeach()
endforeach()

run(${CMAKE_COMMAND} -S ${here} -B ${WORK_DIR}/build -G ${GENERATOR} -DCMAKE_BUILD_TYPE=${CONFIG}
    -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_CXX_COMPILER=${CXX_COMPILER}
    -DCMAKE_CXX_COMPILER_LAUNCHER=${CXX_LAUNCHER} -DCMAKE_CXX_FLAGS=${CXX_FLAGS})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)

run(${prefix}/bin/prism_simulate --trajectory=${here}/uneven_floor.txt --truth_every=0
    --scene=${source_dir}/test/end_to_end/desk.yaml
    --camera=${source_dir}/test/end_to_end/camera.yaml --output_dir=${sequence})
foreach(flag "" --planar)
  run(${WORK_DIR}/build/consumer ${sequence} ${sequence}/camera.yaml ${WORK_DIR} ${flag})
  file(STRINGS ${WORK_DIR}/trajectory.txt poses REGEX "^[0-9]")
  list(LENGTH poses count)
  if(NOT count EQUAL frames)
    message(FATAL_ERROR "trajectory.txt: found ${count} poses, expected ${frames}")
  endif()
  file(STRINGS ${WORK_DIR}/keyframes.txt keyframes REGEX "^[0-9]")
  if(NOT keyframes)
    message(FATAL_ERROR "keyframes.txt: found no pose, expected some")
  endif()
  file(REMOVE ${WORK_DIR}/trajectory.txt ${WORK_DIR}/keyframes.txt)
endforeach()

# The camera of live_camera is a list of files.
file(GLOB frame_paths ${sequence}/raw/*.png)
list(JOIN frame_paths "\n" list)
file(WRITE ${WORK_DIR}/list.txt "${list}\n")
execute_process(COMMAND ${WORK_DIR}/build/live_camera ${sequence}/camera.yaml ${sequence}/white.png
                INPUT_FILE ${WORK_DIR}/list.txt OUTPUT_VARIABLE poses COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "tracked [^\n]+" tracked "${poses}")
list(LENGTH tracked count)
if(NOT count EQUAL frames)
  message(FATAL_ERROR "live_camera: found ${count} tracked frames, expected ${frames}: ${poses}")
endif()
run(${WORK_DIR}/build/planar_motion_check ${sequence} ${sequence}/camera.yaml)

execute_process(COMMAND ${WORK_DIR}/build/consumer ${WORK_DIR}/nowhere camera.yaml ${WORK_DIR}
                RESULT_VARIABLE status ERROR_VARIABLE message)
if(NOT status EQUAL 2 OR NOT message MATCHES "nowhere: found no such folder")
  message(FATAL_ERROR "a missing sequence: found status ${status}, '${message}', expected status 2")
endif()
file(REMOVE_RECURSE ${WORK_DIR})
