# Writes the checks that well_formed.hpp declares from the .lcm files:
#   cmake "-DTYPES=a.lcm;b.lcm" -DOUT=checks.cpp -P generate_checks.cmake
# A field's comment may begin with the field's range as an interval, before "; " and words:
#   [0, 64]   [ARM, CLEAR]   [0, inf)   (0, inf) or NaN   [-2^60, 2^60] or NO_TIME
# The size of an array must have one.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/lcm_text.cmake)

set(boolean_bytes 1)
set(byte_bytes 1)
set(int8_t_bytes 1)
set(int32_t_bytes 4)
set(int64_t_bytes 8)
set(double_bytes 8)

# A limit in C++: a number, a power of two, or a constant of the type.
function(limit_in_cpp limit result)
  if(limit MATCHES "^(-?)2\\^([0-9]+)$")
    math(EXPR power "1 << ${CMAKE_MATCH_2}")
    set(limit "${CMAKE_MATCH_1}${power}")
  elseif(limit MATCHES "^[A-Z]")
    set(limit "${type}::${limit}")
  endif()
  set(${result} "${limit}" PARENT_SCOPE)
endfunction()

# Sets `condition` on `value` and `greatest` from the range at the comment's beginning; both empty if there is none.
function(read_range comment value)
  set(condition "")
  set(high "")
  set(limit "[-A-Z_a-z0-9.^]+")
  if(comment MATCHES "^(<open>|\\()(${limit}), (${limit})(<close>|\\))( or (NaN|NO_TIME))?(<semicolon>|$)")
    set(high "${CMAKE_MATCH_3}")
    set(above ">=")
    set(below "<=")
    set(absent "${CMAKE_MATCH_6}")
    if(CMAKE_MATCH_1 STREQUAL "(")
      set(above ">")
    endif()
    if(CMAKE_MATCH_4 STREQUAL ")")
      set(below "<")
    endif()
    limit_in_cpp("${CMAKE_MATCH_2}" low)
    limit_in_cpp("${high}" high)
    set(condition "${value} ${above} ${low}")
    if(NOT high STREQUAL "inf")
      string(APPEND condition " && ${value} ${below} ${high}")
    elseif(kind STREQUAL "double")
      string(APPEND condition " && std::isfinite(${value})")
    endif()
    if(absent STREQUAL "NaN")
      set(condition "std::isnan(${value}) || (${condition})")
    elseif(absent STREQUAL "NO_TIME")
      set(condition "${value} == ${type}::NO_TIME || (${condition})")
    endif()
  endif()
  set(condition "${condition}" PARENT_SCOPE)
  set(greatest "${high}" PARENT_SCOPE)
endfunction()

# One element of `kind`, encoded: adds to `bytes` what has a fixed size, else to `walk`.
macro(add_element)
  if(DEFINED ${kind}_bytes)
    math(EXPR bytes "${bytes} + ${${kind}_bytes} * ${repeated}")
  else()
    flush_bytes()
    if(kind STREQUAL "string")
      string(APPEND walk "  walk.skip_string();\n")
    else()
      string(APPEND walk "  skip(walk, static_cast<const ${kind}*>(nullptr));\n")
    endif()
  endif()
endmacro()

macro(flush_bytes)
  if(bytes GREATER 0)
    string(APPEND walk "  walk.skip(${bytes});\n")
  endif()
  set(bytes 0)
endmacro()

# An array whose size is the field `size`.
macro(add_array)
  flush_bytes()
  if(DEFINED ${kind}_bytes)
    string(APPEND walk "  walk.skip_elements(${size}, ${${kind}_bytes});\n")
  elseif(kind STREQUAL "string")
    string(APPEND walk "  for (std::size_t i = 0; i < ${size} && walk.good(); ++i) walk.skip_string();\n")
  else()
    string(APPEND walk "  for (std::size_t i = 0; i < ${size} && walk.good(); ++i)\n"
                       "    skip(walk, static_cast<const ${kind}*>(nullptr));\n")
    string(APPEND ranges "  for (const ${kind}& element : m.${name}) {\n    if (!ranges_hold(element)) return false;\n  }\n")
  endif()
endmacro()

set(declarations "")
set(definitions "")
set(instances "")
foreach(file ${TYPES})
  get_filename_component(type ${file} NAME_WE)
  read_lcm_lines(${file} text lines)
  set(bytes 0)
  set(walk "")
  set(ranges "")
  foreach(line ${lines})
    if(NOT line MATCHES "${LCM_FIELD}")
      continue()
    endif()
    set(kind "${CMAKE_MATCH_1}")
    set(name "${CMAKE_MATCH_2}")
    set(size "${CMAKE_MATCH_4}")
    set(repeated 1)
    read_range("${CMAKE_MATCH_6}" "m.${name}")
    if(size MATCHES "^[0-9]+$")
      set(repeated ${size})
      set(size "")
    endif()
    if(NOT size STREQUAL "")
      add_array()
    elseif(text MATCHES "<open>${name}<close>")
      if(greatest STREQUAL "")
        message(FATAL_ERROR "${type}.lcm: ${name}: the size of an array needs a range")
      endif()
      flush_bytes()
      string(APPEND walk "  const std::size_t ${name} = walk.count(${greatest});\n")
    else()
      add_element()
      if(kind MATCHES "_t$" AND NOT DEFINED ${kind}_bytes)
        string(APPEND ranges "  if (!ranges_hold(m.${name})) return false;\n")
      elseif(NOT condition STREQUAL "")
        string(APPEND ranges "  if (!(${condition})) return false;\n")
      endif()
    endif()
  endforeach()
  flush_bytes()
  string(APPEND includes "#include <strobe_msgs/${type}.hpp>\n")
  string(APPEND declarations "void skip(EncodedWalk& walk, const ${type}*);\nbool ranges_hold(const ${type}& m);\n")
  string(APPEND definitions "void skip(EncodedWalk& walk, const ${type}*) {\n${walk}}\n"
                            "bool ranges_hold([[maybe_unused]] const ${type}& m) {\n${ranges}  return true;\n}\n\n")
  string(APPEND instances "template bool well_formed<${type}>(const void*, std::size_t);\n"
                          "template bool in_range(const ${type}&);\n")
endforeach()

file(WRITE ${OUT} "// Generated from common/messages/*.lcm by generate_checks.cmake.
#include <cmath>
${includes}
#include \"common/messages/encoded_walk.hpp\"
#include \"common/messages/well_formed.hpp\"

namespace strobe::messages {

using namespace strobe_msgs;

namespace {

${declarations}
${definitions}}  // namespace

template <typename Message>
bool well_formed(const void* data, std::size_t size) {
  EncodedWalk walk(data, size);
  walk.skip(EncodedWalk::kFingerprint_bytes);
  skip(walk, static_cast<const Message*>(nullptr));
  return walk.at_end();
}
template <typename Message>
bool in_range(const Message& message) {
  return ranges_hold(message);
}

${instances}
}  // namespace strobe::messages
")
