#include "optim/sobol_sequence.h"

#include <bit>

#include "core/random.h"

namespace primo::optim {
namespace {

using Directions = std::array<std::uint32_t, SobolSequence::kBits>;

/// a·b modulo the polynomial, over GF(2); bit i is the coefficient of x^i. @pre degree(a), degree(b) < degree.
std::uint64_t multiply(std::uint64_t a, std::uint64_t b, std::uint64_t polynomial, int degree) {
  std::uint64_t product = 0;
  for (; b != 0; b >>= 1) {
    if ((b & 1) != 0) product ^= a;
    a <<= 1;
    if ((a >> degree & 1) != 0) a ^= polynomial;
  }
  return product;
}

std::uint64_t power(std::uint64_t exponent, std::uint64_t polynomial, int degree) {
  std::uint64_t result = 1, square = degree > 1 ? 2 : (2 ^ polynomial) & 1;  // x, reduced
  for (; exponent != 0; exponent >>= 1) {
    if ((exponent & 1) != 0) result = multiply(result, square, polynomial, degree);
    square = multiply(square, square, polynomial, degree);
  }
  return result;
}

/// Whether x generates the multiplicative group of order 2^degree − 1.
bool is_primitive(std::uint64_t polynomial, int degree) {
  const std::uint64_t order = (std::uint64_t{1} << degree) - 1;
  if (power(order, polynomial, degree) != 1) return false;
  std::uint64_t rest = order;
  for (std::uint64_t p = 2; p * p <= rest; ++p) {
    if (rest % p != 0) continue;
    while (rest % p == 0) rest /= p;
    if (power(order / p, polynomial, degree) == 1) return false;
  }
  return rest == 1 || rest == order || power(order / rest, polynomial, degree) != 1;
}

/// Primitive polynomials in the order of their degree, then of their bits.
class Polynomials {
 public:
  std::uint64_t next() {
    do {
      next_ += 2;  // the constant term is 1
      if (next_ >> (degree_ + 1) != 0) ++degree_;
    } while (!is_primitive(next_, degree_));
    return next_;
  }
  int degree() const { return degree_; }

 private:
  std::uint64_t next_ = 1;
  int degree_ = 1;
};

/// The recurrence of the direction numbers. The initial ones, v[0 … degree − 1], are given as m_k 2^(31 − k).
void extend(Directions& v, std::uint64_t polynomial, int degree) {
  const auto at = [&](int k) -> std::uint32_t& { return v[static_cast<std::size_t>(k)]; };
  for (int k = degree; k < SobolSequence::kBits; ++k) {
    at(k) = at(k - degree) ^ (at(k - degree) >> degree);
    for (int i = 1; i < degree; ++i) {
      if ((polynomial >> (degree - i) & 1) != 0) at(k) ^= at(k - i);
    }
  }
}

/// Rows of first bits, for property A: the d × d matrix over GF(2) of the first bit of direction number j of dimension
/// i must be regular. Kept as the words of all dimensions, up to 32 columns.
bool regular(std::vector<std::uint32_t> rows, std::size_t size) {
  for (std::size_t column = 0; column < size; ++column) {
    std::size_t pivot = column;
    while (pivot < size && (rows[pivot] >> column & 1) == 0) ++pivot;
    if (pivot == size) return false;
    std::swap(rows[pivot], rows[column]);
    for (std::size_t r = column + 1; r < size; ++r) {
      if ((rows[r] >> column & 1) != 0) rows[r] ^= rows[column];
    }
  }
  return true;
}

std::uint32_t first_bits(const Directions& v) {
  std::uint32_t bits = 0;
  for (std::size_t k = 0; k < v.size(); ++k) bits |= (v[k] >> 31) << k;
  return bits;
}

}  // namespace

SobolSequence::SobolSequence(int dimension) {
  Polynomials polynomials;
  std::vector<std::uint32_t> rows;
  for (int d = 0; d < dimension; ++d) {
    Directions v{};
    if (d == 0) {
      for (std::size_t k = 0; k < v.size(); ++k) v[k] = std::uint32_t{1} << (31 - k);
    } else {
      const std::uint64_t polynomial = polynomials.next();
      const int degree = polynomials.degree();
      for (std::uint64_t attempt = 0;; ++attempt) {
        Random random(0, "sobol directions", {static_cast<std::uint64_t>(d), attempt});
        for (int k = 0; k < degree; ++k) {
          const auto m = static_cast<std::uint32_t>(2 * random.below(std::uint64_t{1} << k) + 1);
          v[static_cast<std::size_t>(k)] = m << (31 - k);
        }
        extend(v, polynomial, degree);
        if (d >= kBits) break;  // so many orthants no budget ever visits
        auto with = rows;
        with.push_back(first_bits(v));
        // A coin's throw each time; where no choice can do it (of the first degrees there are few) any is taken.
        if (attempt >= 256 || regular(with, with.size())) break;
      }
    }
    if (d < kBits) rows.push_back(first_bits(v));
    directions_.push_back(v);
  }
}

std::vector<std::uint32_t> SobolSequence::point(std::uint32_t n) const {
  std::vector<std::uint32_t> x(directions_.size(), 0);
  for (std::uint32_t gray = n ^ (n >> 1); gray != 0; gray &= gray - 1) {
    const auto bit = static_cast<std::size_t>(std::countr_zero(gray));
    for (std::size_t i = 0; i < x.size(); ++i) x[i] ^= directions_[i][bit];
  }
  return x;
}

}  // namespace primo::optim
