// Sets of examples.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace primo::rules {

class Bits {
 public:
  Bits() = default;
  explicit Bits(std::size_t size) : words_((size + 63) / 64) {}

  void resize(std::size_t size) { words_.resize((size + 63) / 64); }
  void set(std::size_t i) { words_[i / 64] |= std::uint64_t{1} << (i % 64); }
  bool test(std::size_t i) const { return (words_[i / 64] >> (i % 64)) & 1; }
  std::int64_t count() const {
    std::int64_t sum = 0;
    for (const auto word : words_) sum += std::popcount(word);
    return sum;
  }
  /// Of this without the other.
  std::int64_t count_without(const Bits& other) const {
    std::int64_t sum = 0;
    for (std::size_t w = 0; w < words_.size(); ++w) sum += std::popcount(words_[w] & ~other.words_[w]);
    return sum;
  }
  bool operator==(const Bits&) const = default;
  bool intersects(const Bits& other) const {
    for (std::size_t w = 0; w < words_.size(); ++w) {
      if (words_[w] & other.words_[w]) return true;
    }
    return false;
  }
  Bits& operator|=(const Bits& other) {
    for (std::size_t w = 0; w < words_.size(); ++w) words_[w] |= other.words_[w];
    return *this;
  }
  Bits& operator&=(const Bits& other) {
    for (std::size_t w = 0; w < words_.size(); ++w) words_[w] &= other.words_[w];
    return *this;
  }
  Bits& remove(const Bits& other) {
    for (std::size_t w = 0; w < words_.size(); ++w) words_[w] &= ~other.words_[w];
    return *this;
  }
  const std::vector<std::uint64_t>& words() const { return words_; }

 private:
  std::vector<std::uint64_t> words_;
};

}  // namespace primo::rules
