# Writes a C++ file with the page's files: cmake -DFOLDER=… -DOUT=… -P embed.cmake
file(GLOB_RECURSE FILES RELATIVE ${FOLDER} ${FOLDER}/*)
list(FILTER FILES EXCLUDE REGEX "(\\.md|package\\.json)$")
list(SORT FILES)
set(entries "")
foreach(name ${FILES})
  file(READ ${FOLDER}/${name} bytes HEX)
  file(SHA256 ${FOLDER}/${name} hash)
  string(SUBSTRING ${hash} 0 16 hash)
  string(LENGTH "${bytes}" digits)
  math(EXPR size "${digits} / 2")
  string(REGEX REPLACE "(................................................................)" "\\1\"\n     \"" bytes "${bytes}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "\\\\x\\1" bytes "${bytes}")
  string(APPEND entries "    {\"${name}\", \"${hash}\", std::string_view(\n     \"${bytes}\",\n     ${size})},\n")
endforeach()
file(WRITE ${OUT} "#include <array>
#include <span>

#include \"host/web/http/gate.hpp\"

namespace strobe::web {

std::span<const EmbeddedFile> embedded_files();

std::span<const EmbeddedFile> embedded_files() {
  static constexpr auto kFiles = std::to_array<EmbeddedFile>({
${entries}  });
  return kFiles;
}

}  // namespace strobe::web
")
