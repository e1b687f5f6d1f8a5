# The message types for other languages, from the same .lcm files: Python modules (strobe_msgs, and strobe_log, which reads
# logs) and, where a JDK and LCM's jar are there, a jar for lcm-spy. Found by programs in the build tree as installed.
set(PYTHON_DIR ${PROJECT_BINARY_DIR}/lib/python3/dist-packages)
set(PYTHON_MODULES ${PYTHON_DIR}/strobe_msgs/__init__.py)
set(JAVA_SOURCES)
foreach(type ${LCM_TYPES})
  get_filename_component(name ${type} NAME_WE)
  list(APPEND PYTHON_MODULES ${PYTHON_DIR}/strobe_msgs/${name}.py)
  list(APPEND JAVA_SOURCES ${LCM_DIR}/java/strobe_msgs/${name}.java)
endforeach()
# lcm-gen adds to an __init__.py that is there.
add_custom_command(
  OUTPUT ${PYTHON_MODULES} ${PYTHON_DIR}/strobe_log.py
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${PYTHON_DIR}/strobe_msgs
  COMMAND ${LCM_GEN} --python --ppath ${PYTHON_DIR} ${LCM_TYPES}
  COMMAND ${CMAKE_COMMAND} -E copy ${CMAKE_CURRENT_SOURCE_DIR}/messages/python/strobe_log.py ${PYTHON_DIR}
  DEPENDS ${LCM_TYPES} ${CMAKE_CURRENT_SOURCE_DIR}/messages/python/strobe_log.py
  COMMENT "Generating Python modules of the LCM types")
add_custom_target(strobe_python ALL DEPENDS ${PYTHON_MODULES})
install(DIRECTORY ${PYTHON_DIR}/ DESTINATION lib/python3/dist-packages FILES_MATCHING PATTERN "*.py")

find_program(JAVAC javac)
find_program(JAR jar)
find_file(LCM_JAR lcm.jar PATHS /usr/share/java /usr/local/share/java)
if(NOT JAVAC OR NOT JAR OR NOT LCM_JAR)
  message(STATUS "lcm-spy's jar is not made: it needs default-jdk-headless and liblcm-java")
  return()
endif()
set(MESSAGES_JAR ${PROJECT_BINARY_DIR}/share/java/strobe_msgs.jar CACHE INTERNAL "lcm-spy's jar")
add_custom_command(
  OUTPUT ${MESSAGES_JAR}
  COMMAND ${LCM_GEN} --java --jpath ${LCM_DIR}/java ${LCM_TYPES}
  COMMAND ${JAVAC} --release 8 -Xlint:-options -nowarn -encoding UTF-8 -cp ${LCM_JAR} -d ${LCM_DIR}/classes ${JAVA_SOURCES}
  COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/share/java
  COMMAND ${JAR} --create --file ${MESSAGES_JAR} -C ${LCM_DIR}/classes strobe_msgs
  DEPENDS ${LCM_TYPES}
  COMMENT "Generating lcm-spy's jar of the LCM types")
add_custom_target(strobe_jar ALL DEPENDS ${MESSAGES_JAR})
install(FILES ${MESSAGES_JAR} DESTINATION ${CMAKE_INSTALL_DATADIR}/java)
