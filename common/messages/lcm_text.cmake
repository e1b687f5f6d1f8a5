# Reading .lcm files in CMake, whose lists split at semicolons, but not within brackets: both are replaced by words.
function(read_lcm_lines file out_text out_lines)
  file(READ ${file} text)
  string(REPLACE ";" "<semicolon>" text "${text}")
  string(REPLACE "[" "<open>" text "${text}")
  string(REPLACE "]" "<close>" text "${text}")
  string(REPLACE "\n" ";" lines "${text}")
  set(${out_text} "${text}" PARENT_SCOPE)
  set(${out_lines} "${lines}" PARENT_SCOPE)
endfunction()

# Of a field: kind, name, size or length of an array, comment in CMAKE_MATCH_1, _2, _4 and _6.
set(LCM_FIELD "^  ([a-z0-9_]+) +([a-z0-9_]+)(<open>([a-z0-9_]+)<close>)?<semicolon> *(// *(.*))?$")
