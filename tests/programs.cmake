# Tests of the command, the viewer, the documents, the Python package and the pages: tests/CMakeLists.txt includes them.
find_program(CVOL_PYTHON python3)
# The rows of tests that cover all pairs of options.
# One of this many rows is tested.
set(compress_parts 5)
set(render_parts 3)
if(CVOL_SANITIZE)
  set(compress_parts 135)
  set(render_parts 81)
endif()
if(CVOL_PYTHON)
  add_test(NAME tables COMMAND ${CVOL_PYTHON} -B ${PROJECT_SOURCE_DIR}/scripts/tables.py --check)
  set_tests_properties(tables PROPERTIES TIMEOUT 60)
  add_test(NAME pairwise COMMAND ${CVOL_PYTHON} -B ${CMAKE_CURRENT_SOURCE_DIR}/pairs/test_pairwise.py)
  set_tests_properties(pairwise PROPERTIES TIMEOUT 60)
  add_test(NAME compress_pairs COMMAND ${CVOL_PYTHON} -B ${CMAKE_CURRENT_SOURCE_DIR}/pairs/compress_pairs.py
    $<TARGET_FILE:cvol_command> ${CMAKE_CURRENT_BINARY_DIR}/compress_pairs 1 ${compress_parts})
  set_tests_properties(compress_pairs PROPERTIES TIMEOUT 600)
  add_test(NAME render_pairs COMMAND ${CVOL_PYTHON} -B ${CMAKE_CURRENT_SOURCE_DIR}/pairs/render_pairs.py
    $<TARGET_FILE:cvol_command> ${CMAKE_CURRENT_BINARY_DIR}/render_pairs 1 ${render_parts})
  set_tests_properties(render_pairs PROPERTIES TIMEOUT 600)
endif()

# A part of the calls that can fail (scripts/failures.sh runs all): the hash of the commit chooses it.
if(TARGET faults AND CVOL_PYTHON)
  set(failure_parts 90)
  if(CVOL_SANITIZE)
    set(failure_parts 500)
  endif()
  add_test(NAME failures COMMAND ${CVOL_PYTHON} -B ${CMAKE_CURRENT_SOURCE_DIR}/failures/failures.py
    $<TARGET_FILE:cvol_command> $<TARGET_FILE:faults> ${CMAKE_CURRENT_BINARY_DIR}/failures --part turn/${failure_parts})
  set_tests_properties(failures PROPERTIES TIMEOUT 600)
  # Files that belong together, where names cannot be exchanged: none gets its name if one cannot.
  add_test(NAME failures_named COMMAND ${CVOL_PYTHON} -B ${CMAKE_CURRENT_SOURCE_DIR}/failures/failures.py
    $<TARGET_FILE:cvol_command> $<TARGET_FILE:faults> ${CMAKE_CURRENT_BINARY_DIR}/failures_named --named --all
    --family name --only "decompress nhdr,render turn,render maps,poses to pictures")
  set_tests_properties(failures_named PROPERTIES TIMEOUT 300)
endif()

# The viewer's HTTP interface.
if(TARGET cvol_viewer AND CVOL_PYTHON)
  file(GLOB CVOL_TESTS_VIEWER CONFIGURE_DEPENDS viewer/test_api_*.py)
  foreach(script IN LISTS CVOL_TESTS_VIEWER)
    get_filename_component(name ${script} NAME_WE)
    string(REPLACE test_ viewer_ name ${name})
    add_test(NAME ${name} COMMAND ${CVOL_PYTHON} -B ${script})
    set_tests_properties(${name} PROPERTIES TIMEOUT 300 ENVIRONMENT
      "CVOL=$<TARGET_FILE:cvol_command>;CVOL_HELPERS=$<TARGET_FILE_DIR:json_get>")
  endforeach()
  # Random and mutated requests, with a new seed each time; the test prints the seed.
  add_test(NAME viewer_fuzz COMMAND ${CVOL_PYTHON} -B ${CMAKE_CURRENT_SOURCE_DIR}/viewer/fuzz.py 500)
  set_tests_properties(viewer_fuzz PROPERTIES TIMEOUT 300 ENVIRONMENT
    "CVOL=$<TARGET_FILE:cvol_command>;CVOL_HELPERS=$<TARGET_FILE_DIR:json_get>")
endif()

# Commands, C programs and Python code of the documents. Once, in the plain build.
if(NOT CVOL_SANITIZE)
  set(library none)
  if(TARGET cvol_shared)
    set(library $<TARGET_SONAME_FILE:cvol_shared>)
  endif()
  add_test(NAME documents COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/check_docs.sh ${PROJECT_SOURCE_DIR}
           $<TARGET_FILE:cvol_command> ${library} ${CMAKE_C_COMPILER})
  set_tests_properties(documents PROPERTIES TIMEOUT 900)
endif()

# Images of ITK, by the plugin.
if(TARGET cvol_itk)
  add_executable(itk_copy plugin/itk_copy.cxx)
  set_target_properties(itk_copy PROPERTIES CXX_STANDARD 17)
  target_include_directories(itk_copy SYSTEM PRIVATE ${ITK_INCLUDE_DIRS})
  target_link_libraries(itk_copy PRIVATE ITKCommon ITKIOImageBase)
  add_test(NAME itk COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/plugin/test_itk.sh $<TARGET_FILE:itk_copy>)
  set_tests_properties(itk PROPERTIES TIMEOUT 120 ENVIRONMENT
    "CVOL=$<TARGET_FILE:cvol_command>;CVOL_HELPERS=$<TARGET_FILE_DIR:json_get>;ITK_AUTOLOAD_PATH=${PROJECT_BINARY_DIR}/itk")
endif()

# The device of ANARI.
if(TARGET anari_library_cvol)
  add_executable(anari_client plugin/anari_client.c)
  target_link_libraries(anari_client PRIVATE anari::anari m Threads::Threads ${CMAKE_DL_LIBS})
  set_target_properties(anari_client PROPERTIES ENABLE_EXPORTS ON) # its pthread_create is that of libraries, too
  set(anari_client $<TARGET_FILE:anari_client>)
  set(anari_libraries $<TARGET_FILE_DIR:anari_library_cvol>:$<TARGET_FILE_DIR:anari::anari>)
endif()
add_test(NAME anari COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/plugin/test_anari.sh "${anari_client}" "${anari_libraries}")
set_tests_properties(anari PROPERTIES TIMEOUT 120 SKIP_RETURN_CODE 77 ENVIRONMENT
  "CVOL=$<TARGET_FILE:cvol_command>;CVOL_HELPERS=$<TARGET_FILE_DIR:json_get>;CVOL_SAMPLES=${PROJECT_SOURCE_DIR}/samples")

# doc/paper-map.md names existing files, functions, tests and pictures.
if(CVOL_PYTHON AND NOT CVOL_SANITIZE)
  add_test(NAME paper_map COMMAND ${CVOL_PYTHON} -B ${CMAKE_CURRENT_SOURCE_DIR}/check_paper_map.py ${PROJECT_SOURCE_DIR})
  set_tests_properties(paper_map PROPERTIES TIMEOUT 30)
endif()

# What decides bytes of files calls no function whose last bit depends on the C library.
if(CVOL_PYTHON AND NOT CVOL_SANITIZE)
  add_test(NAME elementary COMMAND ${CVOL_PYTHON} -B ${CMAKE_CURRENT_SOURCE_DIR}/check_elementary.py ${PROJECT_SOURCE_DIR})
  set_tests_properties(elementary PROPERTIES TIMEOUT 30)
endif()

# Doxygen makes the reference of the public headers without a warning. Once, in the plain build.
if(NOT CVOL_SANITIZE)
  add_test(NAME reference COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/check_reference.sh ${PROJECT_SOURCE_DIR})
  set_tests_properties(reference PROPERTIES TIMEOUT 120 SKIP_RETURN_CODE 77)
endif()

# The Python package with the shared library. Once, in the plain build.
if(TARGET cvol_shared)
  add_test(NAME python COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/check_python.sh ${PROJECT_SOURCE_DIR}
           $<TARGET_SONAME_FILE:cvol_shared>)
  set_tests_properties(python PROPERTIES TIMEOUT 600 SKIP_RETURN_CODE 77)
endif()

# The wheel that needs no library of the system, from the objects of this build. Once, in the plain build.
if(TARGET cvol_shared AND CMAKE_SYSTEM_NAME STREQUAL Linux AND CMAKE_SYSTEM_PROCESSOR STREQUAL x86_64)
  add_test(NAME wheel COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/check_wheel.sh ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR})
  set_tests_properties(wheel PROPERTIES TIMEOUT 300 SKIP_RETURN_CODE 77)
endif()

# The modules of the viewer's page that need no browser. Once, in the plain build.
find_program(CVOL_NODE node)
if(CVOL_NODE AND NOT CVOL_SANITIZE)
  foreach(modules page panel measure)
    add_test(NAME viewer_${modules}_modules
             COMMAND ${CVOL_NODE} ${CMAKE_CURRENT_SOURCE_DIR}/viewer/${modules}_modules.mjs)
    set_tests_properties(viewer_${modules}_modules PROPERTIES TIMEOUT 60)
  endforeach()
endif()

# The viewer's page in a browser, with screenshots. Once, in the plain build.
if(TARGET cvol_viewer AND NOT CVOL_SANITIZE)
  add_test(NAME viewer_browser COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/check_browser.sh ${PROJECT_SOURCE_DIR}
           $<TARGET_FILE:cvol_command> ${CMAKE_CURRENT_BINARY_DIR}/viewer)
  set_tests_properties(viewer_browser PROPERTIES TIMEOUT 600 SKIP_RETURN_CODE 77)
endif()

# The pages of cvol export, in Node and in browsers. Once, in the plain build.
if(NOT CVOL_SANITIZE)
  foreach(part IN ITEMS "" site site_files)
    string(JOIN _ name web ${part})
    add_test(NAME ${name} COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/check_web.sh ${PROJECT_SOURCE_DIR}
             $<TARGET_FILE:cvol_command> ${PROJECT_BINARY_DIR} ${part})
    set_tests_properties(${name} PROPERTIES TIMEOUT 1200 SKIP_RETURN_CODE 77)
  endforeach()
endif()
