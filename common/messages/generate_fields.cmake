# Writes visit_fields() for every type of the .lcm files, which hands each field to a visitor in their order:
#   cmake "-DTYPES=a.lcm;b.lcm" -DOUT=message_fields.hpp -P generate_fields.cmake
# Arrays of fixed size are left out: only a sealed command has them.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/lcm_text.cmake)

macro(flush_field)
  if(NOT call STREQUAL "")
    string(REGEX REPLACE "^(<open>|\\()[^<)]*(<close>|\\))( or (NaN|NO_TIME))?(<semicolon> *|$)" "" meaning "${meaning}")
    string(REPLACE "\"" "'" meaning "${meaning}")
    if(call MATCHES "field")
      string(APPEND visits "  visitor.${call}, \"${meaning}\");\n")
    else()
      string(APPEND visits "  visitor.${call});\n")
    endif()
  endif()
  set(call "")
  set(meaning "")
endmacro()

set(primitive "^(boolean|byte|int8_t|int32_t|int64_t|double|string)$")
set(includes "")
set(declarations "")
set(definitions "")
foreach(file ${TYPES})
  get_filename_component(type ${file} NAME_WE)
  read_lcm_lines(${file} text lines)
  set(visits "")
  set(call "")
  set(meaning "")
  foreach(line ${lines})
    if(line MATCHES "^ +// (.*)$")
      string(APPEND meaning " ${CMAKE_MATCH_1}")
    elseif(line MATCHES "${LCM_FIELD}")
      set(kind "${CMAKE_MATCH_1}")
      set(name "${CMAKE_MATCH_2}")
      set(size "${CMAKE_MATCH_4}")
      set(comment "${CMAKE_MATCH_6}")
      flush_field()
      set(meaning "${comment}")
      if(size MATCHES "^[0-9]+$")
        set(call "")
      elseif(NOT size STREQUAL "")
        set(call "list(\"${name}\", m.${name}")
      elseif(kind MATCHES "${primitive}")
        set(call "field(\"${name}\", m.${name}")
      else()
        set(call "part(\"${name}\", m.${name}")
      endif()
    else()
      flush_field()
    endif()
  endforeach()
  flush_field()
  string(APPEND includes "#include <strobe_msgs/${type}.hpp>\n")
  string(APPEND declarations "template <typename Visitor>\nvoid visit_fields(const strobe_msgs::${type}& m, Visitor& visitor);\n")
  string(APPEND definitions "template <typename Visitor>\nvoid visit_fields([[maybe_unused]] const strobe_msgs::${type}& m, "
                            "[[maybe_unused]] Visitor& visitor) {\n${visits}}\n")
endforeach()
string(REPLACE "<semicolon>" ";" definitions "${definitions}")
string(REPLACE "<open>" "[" definitions "${definitions}")
string(REPLACE "<close>" "]" definitions "${definitions}")

file(WRITE ${OUT} "// Generated from common/messages/*.lcm by generate_fields.cmake. A visitor has field(name, value, meaning) for numbers,
// booleans and texts, part(name, message) for messages in a message, list(name, vector) for arrays of either.
#pragma once
${includes}
namespace strobe::messages {

${declarations}
${definitions}
}  // namespace strobe::messages
")
