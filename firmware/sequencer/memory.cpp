// What a compiler without a C library calls all the same (GCC, "Language standards supported": freestanding).
#include <cstddef>
#include <cstdint>

// Else the loops would become calls of themselves.
#define STROBE_LOOP __attribute__((optimize("no-tree-loop-distribute-patterns")))

namespace {

using Word __attribute__((may_alias)) = std::uint32_t;

bool of_words(const void* one, const void* other) {
  return ((reinterpret_cast<std::uintptr_t>(one) | reinterpret_cast<std::uintptr_t>(other)) & 3U) == 0;
}

}  // namespace

extern "C" {

STROBE_LOOP void* memcpy(void* to, const void* from, std::size_t size) {
  auto* out = static_cast<std::uint8_t*>(to);
  const auto* in = static_cast<const std::uint8_t*>(from);
  if (of_words(to, from)) {
    for (; size >= 4; size -= 4, out += 4, in += 4) {
      *reinterpret_cast<Word*>(out) = *reinterpret_cast<const Word*>(in);
    }
  }
  for (; size > 0; --size) *out++ = *in++;
  return to;
}

STROBE_LOOP void* memmove(void* to, const void* from, std::size_t size) {
  auto* out = static_cast<std::uint8_t*>(to);
  const auto* in = static_cast<const std::uint8_t*>(from);
  if (out <= in) return memcpy(to, from, size);
  for (; size > 0; --size) out[size - 1] = in[size - 1];
  return to;
}

STROBE_LOOP void* memset(void* to, int value, std::size_t size) {
  auto* out = static_cast<std::uint8_t*>(to);
  if (of_words(to, to)) {
    const Word word = 0x01010101U * static_cast<std::uint8_t>(value);
    for (; size >= 4; size -= 4, out += 4) *reinterpret_cast<Word*>(out) = word;
  }
  for (; size > 0; --size) *out++ = static_cast<std::uint8_t>(value);
  return to;
}

STROBE_LOOP int memcmp(const void* one, const void* other, std::size_t size) {
  const auto* a = static_cast<const std::uint8_t*>(one);
  const auto* b = static_cast<const std::uint8_t*>(other);
  for (; size > 0; --size, ++a, ++b)
    if (*a != *b) return *a < *b ? -1 : 1;
  return 0;
}

}  // extern "C"
