// Content hashes for identities: the same content has the same id in every process and on every machine.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace primo {

/// 64-bit FNV-1a with a final mix. Not cryptographic: for ids of at most some millions of own records.
class Hasher {
 public:
  Hasher& bytes(const void* data, std::size_t size) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) state_ = (state_ ^ p[i]) * 0x100000001b3ULL;
    return *this;
  }
  /// A string with its length, so that ("ab","c") and ("a","bc") differ.
  Hasher& add(std::string_view text) {
    add(static_cast<std::uint64_t>(text.size()));
    return bytes(text.data(), text.size());
  }
  Hasher& add(const char* text) { return add(std::string_view(text)); }
  template <class T>
  requires std::is_integral_v<T> || std::is_enum_v<T> Hasher& add(T value) {
    const auto wide = static_cast<std::uint64_t>(value);
    return bytes(&wide, sizeof wide);
  }
  /// The bits of a double; -0.0 counts as 0.0.
  Hasher& add(double value) {
    if (value == 0.0) value = 0.0;
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    return add(bits);
  }
  template <class T>
  Hasher& add(const std::vector<T>& values) {
    add(static_cast<std::uint64_t>(values.size()));
    for (const auto& value : values) add(value);
    return *this;
  }
  std::uint64_t value() const;

 private:
  std::uint64_t state_ = 0xcbf29ce484222325ULL;
};

/// 16 lower-case hexadecimal digits.
std::string hex(std::uint64_t value);

/// hex() of the hash of `text`.
std::string content_id(std::string_view text);

}  // namespace primo
